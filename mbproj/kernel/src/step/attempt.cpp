// The attempt of a step: its stages and their error; shorter, or in halves, where it fails; and the check near singular poses.
#include "step/step.hpp"

namespace mbproj {

namespace {

// Whether a fixed step is to be made in halves: it passes a singular pose, so that stages have left rows out. Only one half has
// such an error, of the third power of its size. A step that ends beyond the reach of its joints passes none.
bool passes_branch(Run& run) {
    if (!run.doubling.is_near() || run.equations.passed().smallest > 0.0) return false;
    run.equations.set_pose(run.to.t, run.next.y.data());
    if (run.model.open_by_more(run.equations.constraint(), run.thresholds.lost_limit) >= 0 ||
        !run.schedule.halve(run.now.t, run.to.h, run.thresholds.branch_halvings))
        return false;
    ++run.state.counters.rejected_steps;
    return true;
}

// A fixed step whose equations were not solved is tried again in halves.
void halve(Run& run) {
    const auto unsolved = run.stepper.unsolved();
    if (!unsolved || !run.schedule.halve(run.now.t, run.to.h, run.thresholds.most_halvings))
        return stop_unsolved(run, run.to.t);
    note_halved(run.state.halved, *unsolved, run.now.t);
    ++run.state.counters.rejected_steps;
    run.equations.forget_broken_state();
}

// Why a step could not be made.
Outcome why_unsolved(Run& run, double t) {
    const auto unsolved = run.stepper.unsolved();
    if (!unsolved) return failed_at(run, t);
    const bool near = run.equations.passed().smallest < run.thresholds.near_branch || run.equations.is_near_singular();
    return Outcome::unsolved(t, unsolved->body, unsolved->force, near);
}

bool attempt_fixed(Run& run) {
    const bool made = stages(run).has_value();
    run.phases.mark(Phase::evaluation);
    if (made && !passes_branch(run)) return true;
    if (!made) halve(run);
    return false;
}

bool attempt_controlled(Run& run) {
    run.equations.forget_broken_state();
    const std::optional<double> error = stages(run);
    run.phases.mark(Phase::evaluation);
    run.lost = {};
    if (!error)
        run.lost = why_unsolved(run, run.to.t);
    else if (!std::isfinite(*error))
        run.lost = {Status::not_finite, run.to.t};
    run.error = error.value_or(not_a_number);
    const bool passes = run.schedule.follows() ? std::isfinite(run.error) : run.error <= 1.0;
    if (!passes) reject(run, run.control.after_rejected(run.error, run.to.h));
    return passes;
}

// The stages with the rows that are held; nothing also where others would serve.
std::optional<double> stages_with_rows(Run& run) {
    run.equations.begin_step();
    if (run.other) run.other->begin_step();
    run.stepper.begin(run.now.slope);
    const bool fixed = run.steps.fixed(), made = run.stepper.attempt(run.now.t, run.now.y, run.to.h, run.next.y);
    run.state.counters.evaluations += run.stepper.attempt_cost() + (fixed ? 0 : run.stepper.error_cost());
    if (!made) return std::nullopt;
    if (fixed) return 0.0;
    return run.stepper.error(run.to.t, run.now.y, run.next.y, run.to.h, run.steps.tolerance, run.control.is_again());
}

// How far the step and its extension are from its halves.
double off_halves(Run& run) {
    run.stepper.at(run.now.y, run.to.h, 0.5, run.inside.y);
    return std::max(run.equations.distance(run.doubling.end(), run.next.y, run.to.h),
                    run.equations.distance(run.doubling.middle(), run.inside.y, run.to.h));
}

bool halves_made(Run& run) {
    const double h = run.to.t - run.now.t;
    return run.doubling.repeat(run.now.t, run.now.y, run.now.slope, h, run.state.counters.evaluations);
}

}  // namespace

bool attempt(Run& run) { return run.steps.fixed() ? attempt_fixed(run) : attempt_controlled(run); }

std::optional<double> stages(Run& run) {
    run.extended = run.halved = false;
    std::optional<double> error = stages_with_rows(run);
    if (!error && run.equations.hold_others()) error = stages_with_rows(run);
    return error;
}

void reject(Run& run, double h) {
    if (run.schedule.follows()) run.stop({Status::vanished, run.now.t});  // that run has no shorter step
    ++run.state.counters.rejected_steps;
    run.crossing.reset();
    run.state.h = h;
}

bool extend(Run& run) {
    if (run.extended) return true;
    run.state.counters.evaluations += run.stepper.extend_cost();
    run.extended = run.stepper.extend(run.now.t, run.now.y, run.to.h);
    if (!run.extended) stop_unsolved(run, run.now.t);
    return run.extended;
}

bool agrees_with_halves(Run& run) {
    run.halved = run.doubling.is_near();
    if (run.halved) {
        if (!halves_made(run) && !(run.equations.hold_others() && halves_made(run)))
            return stop_unsolved(run, run.to.t), false;
        if (!run.steps.fixed() && !run.schedule.follows()) {
            if (!extend(run)) return false;
            if (run.state.shortened < run.thresholds.most_shorter &&
                off_halves(run) > run.thresholds.agreed_tolerances * run.steps.tolerance)
                return ++run.state.shortened, reject(run, run.thresholds.shorter * run.to.h), false;
        }
    }
    run.state.shortened = 0;
    return true;
}

void stop_unsolved(Run& run, double t) { run.stop(why_unsolved(run, t)); }

}  // namespace mbproj
