// How a run begins, goes on from a mark, and advances.
#include "step/run.hpp"

#include <chrono>

#include "step/flush_to_zero.hpp"
#include "step/step.hpp"

namespace mbproj {

namespace {

void count_factorisations(Run& run) {
    run.state.counters.factorisations = run.factorised_before + run.equations.factorisations();
}

// The state of a run before its first step.
RunState starting(const Mechanism& model, double t, const std::vector<double>& y, std::vector<long> turns) {
    RunState state;
    state.now.t = t;
    state.now.y = Eigen::Map<const Eigen::VectorXd>(y.data(), model.layout.size());
    state.now.slope = Eigen::VectorXd::Zero(model.layout.size());
    state.now.lambda.resize(model.all_multipliers());
    state.now.counted.turns = std::move(turns);
    return state;
}

// The slope at the state, whose pose, masses and velocities are in place; multipliers on request.
bool evaluate(Run& run, bool with_multipliers) {
    State& now = run.now;
    return run.equations.slope_at(now.y.data(), now.slope.data(), with_multipliers ? now.lambda.data() : nullptr);
}

// Goes on from the mark: the state of the run becomes that one.
void go_on_from_mark(Run& run) {
    run.state = *run.mark;
    State& now = run.now;
    run.schedule.resume(now.t);
    if (run.locates()) run.switches.hold();
    run.equations.set_window(run.window());
    if (run.has_contacts()) {
        run.contacts.resume();
        run.contacts.watch(run.watch, run.spacing);
    }
    if (run.watch.any()) watch_from_here(run);
    run.equations.set_pose(now.t, now.y.data());
    run.equations.set_velocities(now.y.data(), false);
    const bool anew = std::exchange(run.state.anew, false), carries = run.stepper.carries_slope() && !anew;
    if (!run.equations.start() || !(carries || evaluate(run, false))) return stop_at(run, now.t);
    run.began = true;
    run.factorised_before = run.state.counters.factorisations - run.equations.factorisations();
    if (anew) run.mark.reset();  // another run with this method cannot go on from it
}

void begin(Run& run) {
    State& now = run.now;
    run.equations.set_pose(now.t, now.y.data());
    run.equations.set_velocities(now.y.data(), true);
    now.peaks.watch(run.equations.constraint(), run.equations.C_dot(), run.model.row_count(), run.model.driven_count(),
                    now.t);
    now.counted = run.turns.start(now.counted.turns, now.t, now.y);
    if (run.mark) return go_on_from_mark(run);
    if (run.has_contacts() && run.contacts.begins() && !decide_first(run)) return run.stop({Status::undecided, now.t});
    if (run.watch.any()) watch_from_here(run);
    ++run.state.counters.evaluations;
    if (!run.equations.start() || !evaluate(run, true)) return stop_at(run, now.t);
    run.began = true;
    begin_balance(run);
    run.state.h = run.steps.step;
    if (!run.steps.fixed() && !choose_step(run)) return;
    sample(run, now, run.state.h);
    run.equations.set_window(run.window());
    if (run.switches.passes()) run.switches.watch(now.t, now.y, run.window());
    if (run.schedule.is_after_break() || run.locates()) cross_break(run);
}

}  // namespace

Run::Run(std::unique_ptr<Mechanics> of, Steps given, const std::vector<double>& y, std::vector<long> turned)
    : mechanics(std::move(of)), steps(std::move(given)), equations(mechanics->equations()),
      model(equations.mechanism()), thresholds(model.thresholds), projector(mechanics->projector()),
      stepper(mechanics->stepper()), phases(mechanics->phases),
      state(starting(model, steps.start, y, std::move(turned))), schedule(steps, state.grid),
      control(stepper.error_order(), thresholds, state.error), switches(equations, state.branches, steps.fixed()),
      contacts(equations, state.contacts), instants(equations), next(now), turns(equations, stepper),
      doubling(stepper, equations, projector), watch(equations), inside(now) {}

bool resume(Run& run, RunState mark) {
    const bool fits = (!run.has_contacts() || run.contacts.fits(mark.contacts)) && run.switches.fits(mark.branches) &&
                      (!run.other || run.other->resume(mark.other));
    if (!fits) return false;
    if (Invariants* rows = run.projector.invariants()) rows->kept = mark.now.kept;
    run.mark = std::move(mark);
    return true;
}

const RunState* mark_of(Run& run) {
    if (run.began && run.steps.fixed()) take_mark(run);
    return run.mark ? &*run.mark : nullptr;
}

void take_mark(Run& run) {
    if (!run.state.shaped && run.keeps_marks) run.mark = here(run);
}

RunState here(Run& run) {
    count_factorisations(run);
    RunState found = run.state;
    if (run.other) found.other = run.other->save();
    return found;
}

void follow_formulation(Run& run, std::unique_ptr<Formulation> other) {
    run.other = std::move(other);
    run.equations.follow(run.other.get());
}

void advance(Run& run, std::size_t samples, double seconds, long attempts) {
    const FlushToZero flush;
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    run.block.clear();
    if (std::exchange(run.waits, false)) cross_break(run);
    const long look = std::max(1L, 64L / (1 + run.model.size() / 8));  // steps between two looks at the clock
    run.pauses = false;
    for (long done = 0; !run.outcome.stops() && run.block.t.size() < samples && !run.pauses && !run.waits; ++done) {
        if (done % look == look - 1 && std::chrono::steady_clock::now() > until) break;
        if (!run.began)
            begin(run);
        else if (run.schedule.inside())
            sample_inside(run);
        else if (run.now.steps + run.state.counters.rejected_steps >= attempts)
            run.pauses = true, take_mark(run);
        else
            step(run);
    }
    if ((run.began || !run.mark) && loses_contacts(run)) decide_anew(run);
    count_factorisations(run);
}

const Eigen::VectorXd* try_step(Run& run, double h) {
    const FlushToZero flush;
    begin(run);
    run.to = run.schedule.to(run.now.t, run.now.t + h);
    return !run.outcome.stops() && stages(run) ? run.stepper.estimate() : nullptr;
}

void sample(Run& run, const State& at, double h) {
    count_factorisations(run);
    run.block.add(at.t, at.y, at.slope, run.model, at.lambda, h, at.counted.values(),
                  run.state.counters.list(at.steps));
    if (run.has_contacts()) record_contacts(run, at.lambda);
}

}  // namespace mbproj
