// Explicit Runge-Kutta steps.
#pragma once

#include "steppers/stepper.hpp"

namespace mbproj {

template <int D> class ExplicitRungeKutta final : public Stepper<D> {
public:
    using Base = Stepper<D>;
    using typename Base::Vector;
    using typename Base::Visit;

    ExplicitRungeKutta(const Tableau& tableau, EquationsOfMotion<D>& equations)
        : Base(tableau, equations, tableau.stages() + (tableau.error.rows() > 0 ? 1 + tableau.extra_c.size() : 0)) {}

    std::unique_ptr<Base> copy() const override { return std::make_unique<ExplicitRungeKutta>(*this); }

    long attempt_cost() const override { return tableau_.stages() - 1; }
    int error_cost() const override { return 1; }
    int extend_cost() const override { return static_cast<int>(tableau_.extra_c.size()); }
    int arrival_cost() const override { return 1; }

    bool attempt(double t, const Vector& y, double h, Vector& y_new) override {
        for (int s = 1; s < tableau_.stages(); ++s) {
            combine(y, h, tableau_.a.row(s), s, stage_);
            if (!equations_.watched_derivative(t + tableau_.c[s] * h, stage_.data(), k_[s].data())) return false;
        }
        combine(y, h, tableau_.b, tableau_.stages(), y_new);
        return true;
    }

    void quadrature(double t, const Vector& y, double h, const Visit& visit) const override {
        Vector state(y.size());
        for (int s = 0; s < tableau_.stages(); ++s) {
            if (tableau_.b[s] == 0.0) continue;
            combine(y, h, tableau_.a.row(s), s, state);
            visit(tableau_.b[s], t + tableau_.c[s] * h, state);
        }
    }

    // It evaluates f before any projection, as the extension needs it too.
    std::optional<double> error(double t, const Vector& y, const Vector& y_new, double h, double tolerance,
                                bool) override {
        if (!equations_.watched_derivative(t, y_new.data(), k_[tableau_.stages()].data())) return std::nullopt;
        return norm_of_error(y, y_new, h, tolerance);
    }

    // The extra stages of the continuous extension of the last step.
    bool extend(double t, const Vector& y, double h) override {
        for (std::size_t x = 0; x < tableau_.extra_c.size(); ++x) {
            const int known = tableau_.stages() + 1 + static_cast<int>(x);
            combine(y, h, tableau_.extra_a.row(x), known, stage_);
            if (!equations_.derivative(t + tableau_.extra_c[x] * h, stage_.data(), k_[known].data())) return false;
        }
        return true;
    }

    bool arrive(const Vector& y, Vector& slope, double* lambda) override {
        return equations_.slope_at(y.data(), slope.data(), lambda);
    }
    bool follow_on(double t, const Vector& y) override {
        return equations_.watched_derivative(t, y.data(), k_[0].data());
    }
    bool inside(double, double, double, const Vector& y, Vector& slope, double* lambda) override {
        if (!equations_.factor(Metric::mass)) return false;
        equations_.set_velocities(y.data(), false);
        return equations_.slope_at(y.data(), slope.data(), lambda);
    }

    bool before_jump(double, const Vector&) override { return true; }
    bool after_jump(double t, const Vector& y, Vector& slope, double* lambda) override {
        equations_.set_pose(t, y.data());
        return inside(t, 0.0, 0.0, y, slope, lambda);
    }
    bool meet_break(double, const Vector&, const TimeWindow&, Vector&, double*) override { return true; }
    bool carries_slope() const override { return false; }

private:
    // Of two estimates (DOP853) the combination of its authors.
    double norm_of_error(const Vector& y, const Vector& y_new, double h, double tolerance) const {
        double norms[2] = {0.0, 0.0};
        for (int e = 0; e < tableau_.error.rows(); ++e) {
            double sum = 0.0;
            for (int i = 0; i < layout_.controlled(); ++i) {
                double estimate = 0.0;
                for (int s = 0; s <= tableau_.stages(); ++s) estimate += tableau_.error(e, s) * k_[s][i];
                const double part =
                    h * estimate / (tolerance * (layout_.scale[i] + std::max(std::abs(y[i]), std::abs(y_new[i]))));
                sum += part * part;
            }
            norms[e] = std::sqrt(sum / layout_.controlled());
        }
        if (tableau_.error.rows() == 1 || norms[0] == 0.0) return norms[0];
        return norms[0] * norms[0] / std::hypot(norms[0], 0.1 * norms[1]);
    }

    using Base::combine, Base::equations_, Base::k_, Base::layout_, Base::stage_, Base::tableau_;
};

}  // namespace mbproj
