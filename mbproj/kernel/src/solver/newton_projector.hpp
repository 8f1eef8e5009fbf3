// The projection after a step: positions by simplified Newton with one factor, velocities by one solve at the pose reached.
#pragma once

#include <limits>
#include <memory>
#include <numeric>

#include "model/phase_times.hpp"
#include "solver/invariant_rows.hpp"

namespace mbproj {

template <class D> class NewtonProjector final : public Projector {
public:
    using S = Size<D>;

    NewtonProjector(EquationsOfMotion<D>& equations, const ProjectionSettings& settings, Phases& phases);
    ~NewtonProjector() override;
    Projected after_step(long step, double t, const double* before, double* y) override;
    Projected anywhere(double t, double* y) override;
    void keep(bool energy, const std::vector<double>& fields, double tolerance) override;
    InvariantRows<D>* invariants() override { return invariants_.get(); }

    // One exact Newton correction of the position; false where there is none.
    bool newton(double t, double* y);

private:
    Projected close(long step, double t, double* y);
    Projected anywhere_alone(double t, double* y);
    // The projection by another formulation, with its change of the velocities.
    [[gnu::noinline, gnu::cold]] Projected by_other(long step, double t, double* y);
    static Metric metric_of(Correction correction);
    bool closes() const { return settings_.corrects() && (model_.constraints.rows > 0 || equations_.contacts().any()); }

    // Without joints nothing has to be closed; conserved quantities are projected by the same schedule.
    bool frees_all(long step) const { return !closes() && settings_.corrects() && step % settings_.every == 0; }
    // Whether velocities that are `due` can be corrected: the pose is closed and factored.
    bool keeps(bool due, const Projected& done);
    double largest(const double* rows) const;
    void normalise(double* y) const;

    // Corrects the levels that are asked for, with a factor of this pose.
    Projected correct(double* y, bool position, bool velocity);

    // Corrects the position by the test that is set; if it fails, again in the coordinates' metric, if allowed.
    void correct_position(double* y, Projected& done, bool fresh);

    // Iterates until every row of C meets its tolerance. One factor, `fresh` from this pose or from one nearby, serves all passes
    // (simplified Newton) unless they converge slowly. A correction by a fresh factor that does not reduce the violation is
    // damped. Where that fails, round-off is reached, or the iteration diverges.
    void by_violation(double* y, Projected& done, Metric metric, bool fresh);

    // Near a singular pose a row that is left out for want of a gradient stays open to second order. With all rows,
    // each damped step leaves a quarter of that. Counts a failure where more is left, or the pose is not singular.
    void close_in_full(double* y, double left, Projected& done, Metric metric);

    // Iterates until ΔqᵀMΔq + CᵀC <= tolerance, by Newton's method: the paper's test (sect. 5) in the metric of Eq. 72, since M
    // alone does not measure every direction.
    void by_paper(double* y, Projected& done);

    // Eqs. 46, 41, 74: G (u + δ) = 0; a penalty reaches that in the limit (Eq. 55).
    void correct_velocity(double* y, Projected& done);

    // Whether the velocity violation is less than half of what was `left` before: round-off does not fall.
    bool falls(double* y, double& left);

    // δᵀMδ of the current correction.
    double energy() const;

    // Whether |C| <= tolerance row by row: the tolerance that is set; else 1e-13, times the mechanism's length if it is
    // below 1 m, or what round-off allows.
    bool meets(const double* C) const { return rows_meet(C) && (!equations_.contacts().any() || contacts_meet()); }
    bool rows_meet(const double* C) const;
    [[gnu::noinline, gnu::cold]] bool contacts_meet() const;

    // Whether each row that does not meet its tolerance is open by little more than round-off.
    bool may_be_round_off(const double* C) const;

    // Whether each row is at most `grains` ε of the largest coordinate that enters it, or `least`.
    bool within(const double* C, double grains, double least = 0.0) const;

    EquationsOfMotion<D>& equations_;
    const Model<D>& model_;
    const Thresholds& thresholds_;
    const ProjectionSettings& settings_;
    Phases& phases_;
    TrustRegion<D> trust_region_;
    Metric metric_;
    double length2_;
    std::vector<double> start_;
    std::unique_ptr<InvariantRows<D>> invariants_;  // null where none are asked for
};

extern template class NewtonProjector<Plane<double>>;
extern template class NewtonProjector<Space<double>>;

}  // namespace mbproj
