// A step: to its next end, or nearer.
#include "step/step.hpp"

namespace mbproj {

namespace {

bool choose_end(Run& run) {
    run.crossing.reset();
    run.met.at_end = false;
    if (!run.steps.fixed() && !run.schedule.resolves(run.now.t, run.state.h))
        return run.stop(run.lost.stops() ? run.lost : Outcome{Status::vanished, run.now.t}), false;
    run.to = run.schedule.target(run.now.t, run.state.h);
    if (run.steps.fixed()) shorten_to_rest(run);
    if (!run.steps.fixed() || run.to.shaped) take_mark(run);
    run.state.shaped = run.state.shaped || run.to.shaped;
    run.phases.begin(run.now.steps + 1);
    return true;
}

// Makes the step from `now` to `next`. False where there is none: the run stops, or tries another one.
bool make(Run& run) {
    if (!attempt(run)) return false;             // stages and error; else shorter, or in halves
    if (!cut_at_switch(run)) return false;       // by the extension, at the first crossing
    if (!agrees_with_halves(run)) return false;  // near singular poses
    {
        const EndAtBreak at_break(run);
        const bool watches = run.watch.any();
        if (!close(run)) return false;                             // projections; turns; peaks
        if (!arrive(run, watches)) return false;                   // rows that hold there; slope
        if (!watches || !meets(run)) return !run.outcome.stops();  // contacts and frictions
    }
    return locate(run);  // the step is made again: it ends where the contact is met
}

}  // namespace

void step(Run& run) {
    if (!choose_end(run) || !make(run)) return;
    run.schedule.enter(run.to);
    if (run.schedule.inside() && !extend(run)) return;
    if (!run.steps.fixed()) run.state.h = run.control.after_accepted(run.error, run.to.h);
    run.phases.mark(Phase::rest);
    if (!run.schedule.inside()) commit(run);
}

void sample_inside(Run& run) {
    State& inside = run.inside;
    inside.t = run.schedule.take();
    ++run.state.counters.evaluations;
    const double h = run.to.h, theta = (inside.t - run.now.t) / h;
    run.stepper.at(run.now.y, h, theta, inside.y);
    if (const Outcome closed = close_inside(run, inside); closed.stops()) return run.stop(closed);
    if (!run.stepper.inside(inside.t, h, theta, inside.y, inside.slope, inside.lambda.data()))
        return stop_at(run, inside.t);
    inside.counted = run.turns.inside(run.now.counted, run.now.t, run.next.counted, run.next.t, inside.t, inside.y);
    inside.steps = run.next.steps;
    sample(run, inside, h);
    if (!run.schedule.inside()) commit(run);
}

void commit(Run& run) {
    run.now.take(run.next);
    if (const Invariants* rows = run.projector.invariants()) run.now.kept = rows->kept;
    if (run.to.due) sample(run, run.now, run.to.h);
    run.schedule.reach(run.to);
    if (run.path) run.path->add(run.now.t, run.to.h, run.now.y);
    if (run.switches.passes()) run.switches.watch(run.now.t, run.now.y, run.window());
    run.left_at_end = run.met.at_end && !meet_contact(run);
    if (!run.left_at_end) end_step(run);
}

void end_step(Run& run) {
    if (run.schedule.finished()) return run.stop({Status::finished, run.now.t});
    if (run.crossing) {
        if (cross_switch(run)) run.to.at_break ? cross_break(run) : choose_step_anew(run);
    } else if (run.to.at_break) {
        cross_break(run);
    } else if (run.locates()) {
        run.switches.set_free_signs(run.now.t, run.now.y, run.window());
    }
}

}  // namespace mbproj
