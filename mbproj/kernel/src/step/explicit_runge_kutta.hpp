// Explicit Runge-Kutta steps.
#pragma once

#include "step/explicit_stages.hpp"

namespace mbproj {

class ExplicitRungeKutta final : public ExplicitStages {
public:
    ExplicitRungeKutta(const Tableau& tableau, Equations& equations) : ExplicitStages(tableau, equations) {}

    std::unique_ptr<Stepper> copy() const override { return std::make_unique<ExplicitRungeKutta>(*this); }

    int error_cost() const override { return 1; }

    bool attempt(double t, const Vector& y, double h, Vector& y_new) override;
    void quadrature(double t, const Vector& y, double h, const Visit& visit) const override;

    // Evaluates f at y_new before any projection; the extension needs it, too.
    std::optional<double> error(double t, const Vector& y, const Vector& y_new, double h, double tolerance,
                                bool) override;

    // The extra stages of the continuous extension of the last step.
    bool extend(double t, const Vector& y, double h) override;

private:
    double norm_of_error(const Vector& y, const Vector& y_new, double h, double tolerance) const;
};

}  // namespace mbproj
