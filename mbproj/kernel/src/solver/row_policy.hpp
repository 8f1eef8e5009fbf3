// The rows of the loops' joints that a step holds. Where a mechanism has redundant rows, or comes near a singular pose,
// not all can be held: S = G W⁻¹ Gᵀ would be singular. The choice is a function of the pose at which the step begins.
// Nothing comes from the steps before, so that a run which starts at any of its states goes on the same.
//
// The usual rows are chosen before the run (mbproj.motion.formulations.redundant_rows). Where these are
// ill-conditioned, the step holds the best-conditioned rows of its pose. Off the constraints each choice is another
// differential equation: the rows change within a step only where it cannot be made with them (`hold_others`).
//
// The reference is mbproj.equations.rank.row_policy. It judges by singular values of C_q and holds combinations of
// rows; here single rows are held, by pivots of S, squares of distances in the metric of the masses. Both solve the
// same equations where the rows are independent. Near a singular pose each errs by the distance σ of the rows that it
// leaves out from the span of those that it holds, and so they may differ by that.
//
// Functions that factor leave the factor in the solver, with the masses, and return whether there is one.
#pragma once

#include "solver/equations.hpp"
#include "solver/kkt_solver.hpp"
#include "solver/row_values.hpp"

namespace mbproj {

template <class D> class RowPolicy final {
public:
    RowPolicy(const Model<D>& model, KktSolver<D>& solver) : model_(model), solver_(solver) {
        hold_all_but(model_.rows.left_out);
    }

    // Chooses the rows of a step that begins at a pose, and factors there. False where the equations have no unique
    // solution.
    bool start(const Pose<D>& pose) {
        hold_all_but(model_.rows.left_out);
        return settle(pose, solver_.factor(pose, Metric::mass));
    }
    // `start` with the rows that are held now, already factored at the pose; `has_factor`: whether that succeeded.
    bool settle(const Pose<D>& pose, bool has_factor) {
        others_may_serve_ = true;
        if (model_.rows.redundant > 0 && !(has_factor && rows_serve())) has_factor = choose(pose);
        at_start_ = {};
        at_start_.record(solver_.nearness());
        begin();
        return has_factor;
    }
    // From now on holds all rows but these, ascending, at any pose.
    void hold_all_but(const std::vector<int>& rows) {
        solver_.leave_out(rows);
        solver_.expect(holds_usual() ? model_.rows.pivots : std::vector<double>());
    }
    // Whether the rows held are the usual ones.
    bool holds_usual() const { return solver_.left_out() == model_.rows.left_out; }

    // A step is tried from the last accepted state: the poses of a rejected step do not count.
    void begin() { over_step_ = at_start_; }
    // Records how near to dependent rows the pose is that was factored last, one of this step.
    void record_pose() { over_step_.record(solver_.nearness()); }
    const Passed& passed() const { return over_step_; }

    // Whether the rows held are dependent at the pose that was factored last, and others are not. Near a branch point
    // of the motion all are.
    bool wants_others(const Pose<D>& pose) const {
        return model_.rows.redundant > 0 && others_may_serve_ && solver_.near_singular() && !solver_.near_branch(pose);
    }
    // Holds the best-conditioned rows of a pose in the current step. False where no others serve.
    bool hold_others(const Pose<D>& pose) { return model_.rows.redundant > 0 && others_may_serve_ && choose(pose); }
    // Factors at a stage that violates the constraints by C + C' · `seconds`. Let a row be at a distance s from the span
    // of the others, and violated by c more than they imply. If it is held, accelerations err by c / s²; if it is left
    // out, by s. So it is held where s³ > c. The first limit, a cheap one, takes the whole violation for c.
    bool factor_for_violation(const Pose<D>& pose, const std::vector<double>& C, const std::vector<double>& C_dot,
                              double seconds) {
        const double limit = held_above(model_.thresholds, largest(model_, C) + largest(model_, C_dot) * seconds);
        if (solver_.nearness() > limit || solver_.is_clear(pose, limit)) return true;
        if (!solver_.factor(pose, Metric::mass, limit)) return false;
        const double c = solver_.contradiction(C.data()) + solver_.contradiction(C_dot.data()) * seconds;
        return solver_.factor(pose, Metric::mass, std::min(held_above(model_.thresholds, c), limit));
    }

private:
    // Whether no pivot of the rows held is far below its usual value.
    bool rows_serve() const {
        return solver_.is_regular() && !model_.rows.pivots.empty() && solver_.nearness() >= model_.thresholds.decline;
    }
    // From now on holds the best-conditioned rows of a pose, and factors there. The rows stay as they are where more
    // than the redundant number of rows is dependent.
    bool choose(const Pose<D>& pose) {
        if (const auto rows = solver_.rows_to_leave_out(pose)) hold_all_but(*rows);
        bool has_factor = solver_.factor(pose, Metric::mass);
        if (has_factor && solver_.is_regular() && !holds_usual()) has_factor = factor_with_own_pivots(pose);
        others_may_serve_ = has_factor && !solver_.near_singular();
        return has_factor;
    }
    // Rows that are not the usual ones have no pivots from before the run to be compared with. Theirs at this pose are
    // taken, divided by the part to which the pose lowers them where all masses are equal.
    bool factor_with_own_pivots(const Pose<D>& pose) {
        const double part = std::min(1.0, solver_.even_nearness(pose));
        std::vector<double> usual = solver_.cholesky().pivots();
        for (double& pivot : usual) pivot = std::min(1.0, pivot / part);
        solver_.expect(usual);
        return solver_.factor(pose, Metric::mass);
    }

    const Model<D>& model_;
    KktSolver<D>& solver_;
    bool others_may_serve_ = true;  // whether other rows may do where those held are dependent
    Passed at_start_, over_step_;   // the nearness at the start of the step, and over its poses
};

}  // namespace mbproj
