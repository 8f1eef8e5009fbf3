// Which rows the next step holds, and whether a step comes near a singular pose: what a run remembers of the poses passed.
//
// Within a step its answer does not change, it only takes note of the poses (`see`). Between steps `after` makes the next
// answer, and `hold_others` where a step cannot be made with this one. `save` and `resume` carry it from one run to the next.
// The reference is mbproj.dynamics.rank.row_policy; row_set.hpp says by how much the two may differ.
#pragma once

#include "dynamics/kkt_solver.hpp"

namespace mbproj {

// Of the poses of a step, the smallest pivots of S, parts of the usual ones; 0 where rows were left out.
struct Passed {
    double smallest = 1.0, largest = 0.0;
    bool looked = false;  // whether a pose had to be looked at closely
    void see(double nearness, bool closely) {
        smallest = std::min(smallest, nearness);
        largest = std::max(largest, nearness);
        looked = looked || closely;
    }
};

template <int D> class RowPolicy final {
public:
    // All that the next answers depend on, as plain data.
    struct Saved {
        RowSet rows;
        double largest_pivot = 0.0;         // of accepted poses: the smallest pivot of each
        double largest_even = 0.0;          // and where all bodies weigh the same
        std::vector<double> chosen_pivots;  // of the rows held, where they were chosen
        bool others_may_serve = true;       // where the rows held depend on each other
        double before = 0.0;                // the largest of the last step, as in `Passed`
    };

    RowPolicy(const Model<D>& model, KktSolver<D>& solver) : model_(model), solver_(solver) {}

    // A run starts at a pose, and factors there with the masses. False where the equations have no unique solution.
    bool start(const Pose<D>& pose) {
        saved_ = {};
        saved_.rows.usual = 0.0;  // no pivot is small until one was seen
        solver_.hold(saved_.rows);
        bool found = model_.redundant == 0 && solver_.factor(pose, Metric::mass);
        if (model_.redundant > 0) found = choose(pose);
        return settle(pose, found);
    }

    // The same where a run goes on from what was saved between two steps.
    bool resume(const Pose<D>& pose, Saved saved) {
        saved_ = std::move(saved);
        solver_.hold(saved_.rows);
        const bool found = solver_.factor(pose, Metric::mass);
        arrive();
        return found;
    }
    const Saved& save() const { return saved_; }

    // A step is tried from the last accepted state: what a rejected one has passed does not count.
    void begin() { passed_ = here_; }
    // Takes note of the pose that was factored last, one of the step at hand.
    void see() { passed_.see(solver_.nearness(), solver_.looked()); }
    const Passed& passed() const { return passed_; }
    double before() const { return saved_.before; }

    // The step is accepted at a pose, which is factored with the masses, if that was `found`: makes the rows of the next one.
    // False where the equations have no unique solution there.
    bool after(const Pose<D>& pose, bool found) {
        saved_.before = passed_.largest;
        if (model_.redundant > 0) {
            const bool regular = found && !solver_.near_singular();
            saved_.others_may_serve = saved_.others_may_serve || regular;
            if (saved_.rows.held.empty() || (regular ? declines() : !found || saved_.others_may_serve))
                found = choose(pose);
        }
        return settle(pose, found);
    }

    // Whether the rows held depend on each other at the pose that was factored last, and others may not.
    bool wants_others() const { return model_.redundant > 0 && saved_.others_may_serve && solver_.near_singular(); }
    // Makes the best rows of a pose those of the step at hand. False where no others serve.
    bool hold_others(const Pose<D>& pose) { return model_.redundant > 0 && saved_.others_may_serve && choose(pose); }

private:
    // Holds the best-conditioned rows of a pose from here on, where exactly as many as are redundant depend on them.
    bool choose(const Pose<D>& pose) {
        if (auto best = solver_.best_rows(pose)) {
            saved_.rows.held = std::move(*best);
            saved_.rows.clear_even = 0.0;
            solver_.hold(saved_.rows);
        }
        const bool found = solver_.factor(pose, Metric::mass);
        saved_.others_may_serve = found && !solver_.near_singular();
        saved_.chosen_pivots.clear();
        if (found && solver_.is_regular()) saved_.chosen_pivots = solver_.cholesky().pivots();
        return found;
    }

    // Whether a pivot of the rows held has fallen so far that others may be better.
    bool declines() const {
        if (saved_.chosen_pivots.empty()) return false;
        const std::vector<double> now = solver_.cholesky().pivots();
        return !std::equal(now.begin(), now.end(), saved_.chosen_pivots.begin(),
                           [this](double a, double b) { return a >= model_.thresholds.decline * b; });
    }

    // The rows are those of the next step.
    bool settle(const Pose<D>& pose, bool found) {
        if (found && solver_.is_regular()) learn(pose);
        if (saved_.rows.usual == 0.0) {
            saved_.rows.usual = 1.0;
            solver_.hold(saved_.rows);
        }
        arrive();
        return found;
    }
    void arrive() {
        here_ = {};
        here_.see(solver_.nearness(), false);
        begin();
    }

    // Masses and lengths of different orders make small pivots at every pose: singular is one where they are small beside
    // the largest that was seen. The same of bodies that weigh alike.
    void learn(const Pose<D>& pose) {
        const Thresholds& thresholds = model_.thresholds;
        const double pivot = solver_.cholesky().smallest_pivot();
        RowSet& rows = saved_.rows;
        if (pivot > thresholds.usual_growth * saved_.largest_pivot) {
            saved_.largest_pivot = pivot;
            const bool is_small = pivot < thresholds.near_branch;
            rows.usual = is_small ? pivot : 1.0;
            if (is_small) saved_.largest_even = std::max(saved_.largest_even, solver_.even_pivot(pose));
            rows.usual_even = is_small ? saved_.largest_even : 1.0;
            rows.clear_even = 0.0;
        } else if (passed_.looked) {
            rows.clear_pivot = pivot;
            rows.clear_even = solver_.clear_part(pose);
        } else {
            return;
        }
        solver_.hold(rows);
    }

    const Model<D>& model_;
    KktSolver<D>& solver_;
    Saved saved_;
    Passed here_, passed_;  // at the accepted pose alone, and in the step at hand
};

}  // namespace mbproj
