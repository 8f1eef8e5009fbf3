// The rows that a step holds, a function of the pose at which it begins. Nothing comes from the steps before, so that a
// run which starts at any of its states goes on the same.
//
// The usual rows are found before the run (mbproj.motion.formulations.redundant_rows). Where these are
// ill-conditioned, the step holds the best-conditioned rows of its pose; off the constraints each choice is another
// differential equation. The rows change within a step only where it cannot be made with them: `hold_others`. The
// reference is mbproj.equations.rank.row_policy. It judges by singular values of C_q and holds combinations of rows;
// here single rows are held, by pivots of S, squares of distances in the metric of the masses. Both solve the same
// equations where the rows are independent. Near a singular pose each errs by the distance σ of the rows that it leaves
// out, and so they may differ by that.
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

    // Chooses the rows of a step that begins at a pose, and factors there with the masses. False where the equations have no
    // unique solution.
    bool start(const Pose<D>& pose) {
        hold_all_but(model_.rows.left_out);
        return settle(pose, solver_.factor(pose, Metric::mass));
    }
    // From now on holds all rows but these, at any pose.
    void hold_all_but(const std::vector<int>& rows) {
        solver_.leave_out(rows);
        solver_.expect(holds_usual() ? model_.rows.pivots : std::vector<double>());
    }
    // Whether the rows held are the usual ones.
    bool holds_usual() const { return solver_.left_out() == model_.rows.left_out; }
    // `start` with the rows held now; `found`: whether these have a factor at the pose.
    bool settle(const Pose<D>& pose, bool found) {
        others_may_serve_ = true;
        if (model_.rows.redundant > 0 && !(found && serves())) found = choose(pose);
        here_ = {};
        here_.record(solver_.nearness());
        begin();
        return found;
    }

    // A step is tried from the last accepted state: the poses of a rejected step do not count.
    void begin() { passed_ = here_; }
    // Records the nearness of the pose that was factored last, one of this step.
    void record_pose() { passed_.record(solver_.nearness()); }
    const Passed& passed() const { return passed_; }

    // Whether the rows held are dependent at the pose that was factored last, and others are not. Near a branch point of the
    // motion all are.
    bool wants_others(const Pose<D>& pose) const {
        return model_.rows.redundant > 0 && others_may_serve_ && solver_.near_singular() && !solver_.near_branch(pose);
    }
    // A stage violates the constraints. Let a row be at a distance s from the span of the others, and violated by c
    // more than they imply. Held, it makes accelerations err by c / s², left out by s: it is held where s³ > c.
    bool factor_for_violation(const Pose<D>& pose, const std::vector<double>& C, const std::vector<double>& C_dot,
                              double seconds) {
        const double first = held_above(model_.thresholds, largest(model_, C) + largest(model_, C_dot) * seconds);
        if (solver_.nearness() > first || solver_.is_clear(pose, first)) return true;
        if (!solver_.factor(pose, Metric::mass, first)) return false;
        const double off = solver_.contradiction(C.data()) + solver_.contradiction(C_dot.data()) * seconds;
        return solver_.factor(pose, Metric::mass, std::min(held_above(model_.thresholds, off), first));
    }
    // Holds the best-conditioned rows of a pose in the current step. False where no others serve.
    bool hold_others(const Pose<D>& pose) { return model_.rows.redundant > 0 && others_may_serve_ && choose(pose); }

private:
    // Whether no pivot of the usual rows is far below its usual value.
    bool serves() const {
        return solver_.is_regular() && !model_.rows.pivots.empty() && solver_.nearness() >= model_.thresholds.decline;
    }
    // From now on holds the best-conditioned rows of a pose, where exactly the redundant number of rows is dependent.
    bool choose(const Pose<D>& pose) {
        if (const auto rows = solver_.rows_to_leave_out(pose)) hold_all_but(*rows);
        bool found = solver_.factor(pose, Metric::mass);
        if (found && solver_.is_regular() && !holds_usual()) found = expect_more(pose);
        others_may_serve_ = found && !solver_.near_singular();
        return found;
    }
    // For rows chosen at this pose the expected pivots are smaller by the same factor as with equal masses.
    bool expect_more(const Pose<D>& pose) {
        const double part = std::min(1.0, solver_.even_nearness(pose));
        std::vector<double> usual = solver_.cholesky().pivots();
        for (double& pivot : usual) pivot = std::min(1.0, pivot / part);
        solver_.expect(usual);
        return solver_.factor(pose, Metric::mass);
    }

    const Model<D>& model_;
    KktSolver<D>& solver_;
    bool others_may_serve_ = true;  // whether other rows may do where those held are dependent
    Passed here_, passed_;          // at the start of the step, and over this step
};

}  // namespace mbproj
