// The base of methods with explicit stages: how a step begins at the end of the last, and at a jump.
#pragma once

#include "step/stepper.hpp"

namespace mbproj {

class ExplicitStages : public Stepper {
public:
    long attempt_cost() const override { return tableau_.stages() - 1; }
    int extend_cost() const override { return static_cast<int>(tableau_.extra_c.size()); }
    int arrival_cost() const override { return 1; }

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

protected:
    ExplicitStages(const Tableau& tableau, Equations& equations)
        : Stepper(tableau, equations, tableau.stages() + (tableau.error.rows() > 0 ? 1 + tableau.extra_c.size() : 0)) {}

    // The norm of a single estimate; for the two of DOP853, their combination by its authors.
    double combined(const double* norms) const {
        if (tableau_.error.rows() == 1 || norms[0] == 0.0) return norms[0];
        return norms[0] * norms[0] / std::hypot(norms[0], 0.1 * norms[1]);
    }
};

}  // namespace mbproj
