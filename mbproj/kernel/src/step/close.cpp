// The end of a step: the state there is projected and checked, its turns are counted, and its slope is evaluated.
#include "step/step.hpp"

namespace mbproj {

namespace {

// By how much a joint may be open.
double limit(const Run& run, const Projected& done) {
    return done.failures ? run.thresholds.open_limit : run.thresholds.lost_limit;
}

void count(const Projected& done, Counters& counters) {
    counters.projections += done.projections;
    counters.projection_iterations += done.position_passes;
    counters.velocity_iterations += done.velocity_passes;
    counters.projection_failures += done.failures;
    counters.projection_fallbacks += done.fallbacks;
}

// Whether the step has led so far off the constraints that its projection is arbitrary.
Outcome lost(const Run& run, const Projected& done) {
    const bool found = done.velocity_change > run.thresholds.lost_velocity &&
                       done.speed_change * (run.to.t - run.now.t) > run.thresholds.lost_way * run.model.length;
    return found ? Outcome::at_branch(Status::branch, run.to.t, done.velocity_change, false) : Outcome{};
}

// Whether a step past a singular pose has met another branch of the motion: velocities are continuous, but branches cross in
// singular poses at an angle. Or whether its halves end elsewhere.
Outcome other_branch(Run& run, const Projected& done) {
    const double t = run.to.t, h = t - run.now.t;
    const bool jumps = done.velocity_change > run.thresholds.branch_change &&
                       done.speed_change * h > run.thresholds.at_rest * run.model.length;
    if (jumps && run.equations.is_near_singular())
        return Outcome::at_branch(Status::branch, t, done.velocity_change, true);
    const double off = run.halved ? run.equations.distance(run.doubling.end(), run.next.y, h) : 0.0;
    if (off > run.thresholds.agreement && run.equations.is_near_singular())
        return Outcome::at_branch(Status::unresolved, t, off, true);
    return {};
}

// The violations at the end of the step, or at a sample inside it: with the step they count or do not.
void watch_peaks(Run& run, double t) {
    Equations& equations = run.equations;
    run.next.peaks.watch(equations.constraint(), equations.C_dot(), run.model.row_count(), run.model.driven_count(), t);
}

Outcome closed(Run& run) {
    const double t = run.to.t, h = t - run.now.t;
    State& next = run.next;
    run.turns.lead(t, next.y);
    const Projected done = run.projector.after_step(next.steps, t, run.now.y.data(), next.y.data());
    count(done, run.state.counters);
    if (!done.regular) return failed_at(run, t);
    if (const Outcome other = other_branch(run, done); other.stops()) return other;
    const double* C = run.equations.constraint();
    run.equations.set_velocities(next.y.data(), true);
    const int worst = run.model.open_by_more(C, limit(run, done));
    if (const Slip slip = worst >= 0 ? run.turns.far(next.counted, h)
                                     : run.turns.advance(next.counted, run.now.t, run.now.y, t, next.y))
        return Outcome::untold(slip, t, h);
    watch_peaks(run, t);
    if (worst < 0) {
        if (const auto off = run.equations.off_rope()) return Outcome::off_rope(t, off->first, off->second);
        if (const auto found = run.equations.overlap())
            return Outcome::overlap(t, found->first < 0 ? -1 : run.model.joint_of(found->first), found->second);
        return lost(run, done);
    }
    if (!done.near_singular)
        return Outcome::left_open(t, worst, std::abs(C[worst]), done.position_passes, done.failures > 0);
    Outcome found = failed_at(run, t);
    found.joint = run.model.joint_of(worst);
    return found;
}

}  // namespace

Outcome closed_end(Run& run) {
    State& next = run.next;
    next.t = run.to.t, next.steps = run.now.steps + 1;
    next.counted = run.now.counted, next.peaks = run.now.peaks;
    if (run.other) run.other->enter_end();
    const Outcome found = closed(run);
    if (run.other && !found.stops()) run.other->arrive(next.y.data());
    return found;
}

bool close(Run& run) {
    if (!all_finite(run.next.y.data(), run.next.y.size())) return run.stop({Status::not_finite, run.to.t}), false;
    run.state.counters.evaluations += run.stepper.arrival_cost();
    const Outcome found = closed_end(run);
    if (found.status == Status::untold && !run.steps.fixed()) {
        discard_end(run);
        reject(run, found.step);
    } else if (found.stops()) {
        run.stop(found);
    }
    return !found.stops();
}

Outcome close_inside(Run& run, State& inside) {
    run.turns.lead(inside.t, inside.y);
    const Projected done = run.projector.anywhere(inside.t, inside.y.data());
    if (!done.regular) return failed_at(run, inside.t);
    const double* C = run.equations.constraint();
    const int worst = run.model.open_by_more(C, limit(run, done));
    run.equations.set_velocities(inside.y.data(), true);
    watch_peaks(run, inside.t);
    if (worst < 0) return {};
    return Outcome::left_open(inside.t, worst, std::abs(C[worst]), done.position_passes, done.failures > 0);
}

bool arrive(Run& run, bool asked) {
    State& next = run.next;
    double* lambda = run.to.due || asked ? next.lambda.data() : nullptr;
    if (!run.equations.start() || !run.stepper.arrive(next.y, next.slope, lambda) ||
        (run.to.at_break && !run.stepper.meet_break(next.t, next.y, run.window(), next.slope, lambda)))
        return stop_at(run, next.t), false;
    if (!all_finite(next.slope.data(), next.slope.size())) return run.stop({Status::not_finite, next.t}), false;
    return true;
}

void discard_end(Run& run) {
    if (Invariants* rows = run.projector.invariants()) rows->kept = run.now.kept;
    if (run.other) run.other->take_back();
}

Outcome failed_at(Run& run, double t) {
    const Equations& equations = run.equations;
    if (!equations.broken_state().empty()) return {Status::broken, equations.time()};
    if (!equations.is_finite()) return {Status::not_finite, t};
    if (equations.jammed() >= 0) return Outcome::jammed(t, equations.jammed());
    Outcome found{Status::singular, t};
    found.joint = equations.singular_joint();
    return found;
}

void stop_at(Run& run, double t) { run.stop(failed_at(run, t)); }

}  // namespace mbproj
