// Events of contacts: a step that meets one is made again, to there, where the contact policy decides.
#include "step/step.hpp"

namespace mbproj {

namespace {

// The step at hand as the cubic through both ends. The slope at its end is known.
CubicStep cubic_of(const Run& run) { return {run.to.h, run.now.y, run.now.slope, run.next.y, run.next.slope}; }

// The multipliers at the part x of the step, where the state is `inside`. Stiff forces are those of its extension: at a state
// beside it they are far off.
bool solve_inside(Run& run, double h, double x, State& inside, std::vector<double>& lambda) {
    const double t = run.now.t + x * h;
    const bool solved = run.stepper.carries_slope()
                            ? run.stepper.inside(t, h, x, inside.y, inside.slope, lambda.data())
                            : run.equations.own_derivative(t, inside.y.data(), inside.slope.data(), lambda.data());
    if (solved) run.equations.variables_at(t, inside.y.data());
    return solved;
}

// The margins at the end of the step, whose state is in place. Where the slope is part of the state, forces are those of the last
// stage.
bool margins_at_end(Run& run, MeetingSearch::Margins& found) {
    State &next = run.next, &inside = run.inside;
    double* lambda = inside.lambda.data();
    if (!run.watch.rows().empty()) {
        const bool solved = run.stepper.carries_slope()
                                ? run.stepper.arrive(next.y, inside.slope, lambda)
                                : run.equations.factor(Metric::mass) &&
                                      run.equations.own_slope_at(next.y.data(), inside.slope.data(), lambda);
        if (!solved) return false;
        run.equations.variables_at(next.t, next.y.data());
    }
    run.watch.margins(next.counted.turns, inside.lambda, found);
    return true;
}

// Takes back the end of the step, and holds the rows again with which it began, at its start.
bool back(Run& run) {
    discard_end(run);
    run.equations.set_pose(run.now.t, run.now.y.data());
    return run.equations.start();
}

// Makes and closes the step once more, with size h, and evaluates the margins at its end.
bool reach(Run& run, const Target& whole, double h, MeetingSearch::Margins& found) {
    discard_end(run);
    run.to = whole;
    if (h != whole.h) run.to = run.schedule.to(run.now.t, run.now.t + h), run.to.shaped = whole.shaped;
    if (!stages(run)) return false;
    const EndAtBreak at_break(run);
    return !closed_end(run).stops() && margins_at_end(run, found);
}

// The margins at the end of the whole step.
bool margins_of_whole(Run& run, MeetingSearch::Margins& found) {
    const EndAtBreak at_break(run);
    run.equations.set_pose(run.next.t, run.next.y.data());
    run.equations.set_velocities(run.next.y.data(), false);
    return margins_at_end(run, found);
}

// Where the step meets something, by looks at its extension, or at the cubic: they are cheaper than steps. False where the forces
// at its start have no solution.
bool expect(Run& run, double grain, MeetingSearch::Margins& first, const MeetingSearch::Margins& last,
            Meeting& expected) {
    const CubicStep step = cubic_of(run);
    const bool forces = !run.watch.rows().empty(), fixed = run.steps.fixed() && !run.stepper.carries_slope();
    if (!fixed) run.state.counters.evaluations += run.stepper.extend_cost();
    const bool extended = !fixed && run.stepper.extend(run.now.t, run.now.y, step.h);
    State& inside = run.inside;
    const auto along = [&](double h, MeetingSearch::Margins& found) {
        const double x = h / step.h;
        extended ? run.stepper.at(run.now.y, step.h, x, inside.y) : step.at(x, inside.y);
        if (forces) {
            if (!solve_inside(run, step.h, x, inside, inside.lambda)) return false;
        } else {
            run.equations.set_pose(run.now.t + h, inside.y.data());
            run.equations.set_velocities(inside.y.data(), false);
        }
        return run.watch.margins(run.now.counted.turns, inside.lambda, found), true;
    };
    if (forces && !along(0.0, first)) return false;
    expected = MeetingSearch(run.watch.slacks(), 0.5, run.thresholds.near_miss)
                   .first(along, first, last, run.watch.parts(), step.h, grain);
    if (expected.which < 0 || std::isfinite(last[expected.which].rate)) return true;
    const double beside = run.thresholds.beside * step.h;
    MeetingSearch::Margins before, after;
    if (along(expected.h - beside, before) && along(expected.h + beside, after))
        expected.slope = (after[expected.which].value - before[expected.which].value) / (2.0 * beside);
    return true;
}

// Sets which contact is met: number `which` among the margins.
void set_met(Run& run, int which) {
    const auto gaps = static_cast<int>(run.watch.gaps().size());
    const bool is_force = which >= gaps;
    run.met.released = is_force || run.watch.gaps()[which].begins;
    run.met.stop = is_force ? run.watch.rows()[which - gaps].row - run.model.all_rows() : run.watch.gaps()[which].stop;
    run.met.at_end = true;
}

}  // namespace

bool begin_contacts(Run& run, std::vector<StopLaw> laws, std::vector<FrictionLaw> frictions, ImpactLaw impacts,
                    ContactState state, double spacing, LoadedJoints joints_in_space) {
    run.spacing = spacing;
    if (!run.contacts.begin(std::move(laws), std::move(frictions), impacts, std::move(state),
                            std::move(joints_in_space)))
        return false;
    run.contacts.watch(run.watch, spacing);
    return true;
}

bool loses_contacts(Run& run) {
    const bool lost = run.outcome.status == Status::singular || run.outcome.status == Status::vanished;
    return lost && run.has_contacts() && run.equations.contacts().any() && !run.equations.contacts().cholesky().full();
}

bool meets(Run& run) {
    const CubicStep step = cubic_of(run);
    run.equations.variables_at(run.next.t, run.next.y.data());
    const bool at_end = run.watch.met(step, run.next.counted.turns, run.next.lambda);
    run.met.rests = run.watch.rests(step.h);
    const auto solve = [&](double x, std::vector<double>& found) {
        State& inside = run.inside;
        run.stepper.carries_slope() ? run.stepper.at(run.now.y, step.h, x, inside.y) : step.at(x, inside.y);
        return solve_inside(run, step.h, x, inside, found);
    };
    if (!run.watch.gives_way_inside(step.h, !run.steps.fixed(), run.next.lambda, solve) && !at_end &&
        run.met.rests < 0) {
        run.watch.pass();
        if (run.contacts.finds_push(run.next.y, run.next.lambda)) run.stop({Status::undecided, run.next.t});
        return false;
    }
    return true;
}

bool locate(Run& run) {
    if (run.halts) return run.stop({Status::halted, run.now.t}), false;  // where the step began
    const Target whole = run.to;
    const double grain = 4.0 * run.schedule.grain(run.now.t);
    MeetingSearch::Margins first = run.watch.first_margins(), last;
    Meeting expected;
    const bool rests = run.met.rests >= 0;
    const bool known = rests || (margins_of_whole(run, last) && expect(run, grain, first, last, expected));
    if (!back(run) || !known) return stop_at(run, run.now.t), false;
    run.contacts.record_speed(run.now.y);
    if (rests) return run.met.stop = run.met.rests, run.met.released = false, meet_contact(run), false;
    double made = -1.0;  // the size of the last step
    const auto at = [&](double h, MeetingSearch::Margins& found) { return reach(run, whole, made = h, found); };
    const Meeting met = MeetingSearch(run.watch.slacks(), 1e-3, run.thresholds.near_miss)
                            .first(at, first, last, run.watch.parts(), whole.h, grain, expected);
    if (!met.made) return discard_end(run), stop_at(run, run.now.t), false;
    if (met.which >= 0) {  // else nothing is met after all
        set_met(run, met.which);
        run.crossing.reset();
        if (met.h < 4.0 * grain) return back(run) ? void(meet_contact(run)) : stop_at(run, run.now.t), false;
    }
    const bool ends_there = whole.h - met.h <= (run.steps.fixed() ? run.thresholds.on_grid * run.steps.step : 0.0);
    const double h = ends_there ? whole.h : met.h;
    if (made != h && !reach(run, whole, h, first)) return discard_end(run), stop_at(run, run.now.t), false;
    const EndAtBreak at_break(run);
    run.watch.begin(run.next.counted.turns);
    run.state.counters.evaluations += run.stepper.arrival_cost();
    return arrive(run, false);
}

void shorten_to_rest(Run& run) {
    if (!run.has_contacts() || run.state.contacts.sliding.empty()) return;
    if (const double h = run.watch.longest(run.now.y, run.now.slope, run.to.h); h < run.to.h)
        run.to = run.schedule.to(run.now.t, run.now.t + h);
}

bool decide(Run& run, int stop, bool released) {
    if (!run.contacts.meet(run.now.t, run.now.y, run.now.counted.turns, stop, released, run.steps.interval()))
        return false;
    run.contacts.watch(run.watch, run.spacing);
    return true;
}

bool decide_first(Run& run) {
    if (!decide(run, -1, false)) return false;
    run.equations.set_pose(run.now.t, run.now.y.data());
    run.equations.set_velocities(run.now.y.data(), true);
    return true;
}

void watch_from_here(Run& run) {
    run.equations.set_pose(run.now.t, run.now.y.data());
    run.equations.set_velocities(run.now.y.data(), false);
    run.watch.begin(run.now.counted.turns);
}

void record_contacts(Run& run, const std::vector<double>& lambda) {
    const ContactState& state = run.state.contacts;
    SampleBlock& block = run.block;
    const double* y = block.y.data() + block.y.size() - run.now.y.size();
    const std::vector<double> forces = run.contacts.forces(block.t.back(), y, lambda);
    block.pushes.insert(block.pushes.end(), forces.begin(), forces.end());
    const std::vector<double> slides = run.contacts.slides(forces);
    block.slides.insert(block.slides.end(), slides.begin(), slides.end());
    block.jumps.push_back(state.work);
    block.jumps.push_back(state.lost);
    for (std::size_t k = 0; k + run.contacts.stops() < forces.size(); ++k)
        block.jumps.push_back(k < state.rubbed.size() ? state.rubbed[k] : 0.0);
}

}  // namespace mbproj
