// Changes at an instant, between two steps: breaks in time, branches of laws, contacts.
#include "step/step.hpp"

namespace mbproj {

namespace {

// At a break that asks, a run waits for values from outside.
bool is_asked(Run& run) { return run.waits = !run.instants.has_from_outside() && run.schedule.asks(run.now.t); }

// Changes states at the breaks that are passed: to values from outside, then by controllers. False where a controller has a
// value that is not finite.
bool act(Run& run) {
    run.instants.set_from_outside(run.now.y.data());
    bool looked = false;
    return run.schedule.act([&](int action) {
        if (!std::exchange(looked, true)) run.instants.set_channels(run.now.t, run.now.y.data());
        return run.instants.act(action, run.now.y.data());
    });
}

// The slope after a jump, and a new balance.
bool renew(Run& run) {
    begin_balance(run);
    ++run.state.counters.evaluations;
    if (run.stepper.after_jump(run.now.t, run.now.y, run.now.slope, nullptr)) return true;
    return stop_at(run, run.now.t), false;
}

// Changes branches of switches. False where the run stops, also where the motion leads back on both sides.
template <class Change> bool change_branches(Run& run, const Change& change) {
    SwitchEvents& switches = run.switches;
    const State& now = run.now;
    switches.glance_before(now.t, now.y, now.slope, run.state.h, run.window());
    if (!run.stepper.before_jump(now.t, now.y)) return stop_at(run, now.t), false;
    change();
    do {
        if (!renew(run)) return false;
        switches.glance_after(now.t, now.y, now.slope, run.state.h, run.window());
    } while (switches.passes_over_back(now.t));
    const int back = switches.pushed_back();
    return back < 0 || (run.stop(Outcome::pushed_back(now.t, back)), false);
}

// Makes an instantaneous change: switches whose arguments jump with it take the branch at the new argument. False where the run
// stops.
template <class Change> bool jump(Run& run, const Change& change) {
    const State& now = run.now;
    if (!run.locates()) return change(), renew(run);
    run.switches.before_jump(now.t, now.y, run.window());
    change();
    run.switches.after_jump(now.t, now.y, run.window());
    return renew(run) && (!run.switches.any_free() || change_branches(run, [&] { run.switches.turn(); }));
}

// Decides contacts at `now`: velocities may jump, and with them branches of forces.
bool change_contacts(Run& run, int stop, bool released) {
    bool decided = true;
    if (!run.stepper.before_jump(run.now.t, run.now.y)) return stop_at(run, run.now.t), false;
    const bool goes_on = jump(run, [&] { decided = decide(run, stop, released); });
    if (!decided) run.stop({Status::undecided, run.now.t});
    if (!decided || !goes_on) return false;
    watch_from_here(run);
    run.turns.take_speeds(run.now.counted);
    choose_step_anew(run);
    return true;
}

}  // namespace

void cross_break(Run& run) {
    if (is_asked(run)) return;
    run.equations.set_window({});  // as in the current slope
    if (!run.stepper.before_jump(run.now.t, run.now.y)) return stop_at(run, run.now.t);
    run.equations.set_window(run.window());
    bool acted = true;
    const bool goes_on = jump(run, [&] {
        run.schedule.pass_break(run.now.t);
        run.equations.set_window(run.window());
        acted = act(run);
    });
    if (goes_on) acted ? choose_step_anew(run) : stop_at(run, run.now.t);
}

bool cross_switch(Run& run) {
    const Crossing crossing = *std::exchange(run.crossing, std::nullopt);
    const double t = run.now.t;
    int often = -1;
    const bool passes = change_branches(
        run, [&] { often = run.switches.cross(crossing, t, run.schedule.grain(t), run.steps.interval()); });
    if (often >= 0) return run.stop(Outcome::pushed_back(t, often)), false;
    return passes;
}

bool meet_contact(Run& run) {
    run.met.at_end = false;
    return change_contacts(run, run.met.stop, run.met.released);
}

void decide_anew(Run& run) {
    const Outcome lost = std::exchange(run.outcome, {});
    if (!run.began) {
        if (!decide(run, -1, false)) run.stop({Status::undecided, run.now.t});  // else the run begins once more
    } else if (change_contacts(run, -1, false) && std::exchange(run.left_at_end, false)) {
        end_step(run);
    }
    if (run.outcome.status == Status::undecided && run.contacts.undecided().cause == Cause::no_inertia) run.stop(lost);
}

void choose_step_anew(Run& run) {
    if (run.steps.fixed()) return;
    run.control.forget();
    choose_step(run);
}

bool choose_step(Run& run) {
    const State& now = run.now;
    const FirstStep first =
        run.stepper.first_step(now.t, now.y, now.slope, run.steps.tolerance, run.schedule.left(now.t));
    ++run.state.counters.evaluations;
    if (first.h < 0.0) return stop_at(run, now.t), false;
    run.state.h = std::max(first.h, run.schedule.shortest(now.t));  // round-off of y may ask for less
    run.state.shaped = run.state.shaped || (first.limited && run.schedule.is_before_end());
    return true;
}

void begin_balance(Run& run) {
    Invariants* rows = run.projector.invariants();
    if (!rows) return;
    rows->begin(run.now.t, run.now.y.data());
    run.now.kept = rows->kept;
}

}  // namespace mbproj
