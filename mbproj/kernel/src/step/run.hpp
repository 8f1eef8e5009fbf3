// A run: what is constant in it, its state, and scratch. `step.hpp` has what a step does to it.
#pragma once

#include "contact/contact_policy.hpp"
#include "contact/meeting_search.hpp"
#include "solver/instants.hpp"
#include "step/mechanics.hpp"
#include "step/outcome.hpp"
#include "step/samples.hpp"
#include "step/schedule.hpp"
#include "step/step_doubling.hpp"
#include "step/switch_events.hpp"
#include "step/turn_counter.hpp"

namespace mbproj {

// What every step changes: y at t, its slope y', the multipliers where a sample or contacts ask for them, the counted turns,
// the number of steps that led here, the largest violations on the way, and the balance of conserved quantities.
struct State {
    double t = 0.0;
    Eigen::VectorXd y, slope;
    std::vector<double> lambda;
    TurnCounter::Counted counted;
    long steps = 0;
    Peaks peaks;
    Kept kept;

    // Takes over the state that a step has led to; that one has the memory of this one then.
    void take(State& made) {
        t = made.t, steps = made.steps, peaks = made.peaks;
        y.swap(made.y), slope.swap(made.slope), lambda.swap(made.lambda);
        counted.angles.swap(made.counted.angles), counted.turns.swap(made.counted.turns);
    }
};

// All that the next step depends on, and what was counted. A copy of it is a mark: a run can go on from there.
struct RunState {
    State now;
    // How the next step is chosen: its size; the last error; how often it was shortened near a singular pose; where it is on
    // the grid of fixed steps; and whether the run's end has limited a step: a longer run makes other steps then.
    double h = 0.0;
    LastError error;
    int shortened = 0;
    Grid grid;
    bool shaped = false;
    // What only jumps change.
    Branches branches;
    ContactState contacts;
    // Counts.
    Counters counters;
    std::vector<Halved> halved;
    // Of marks alone: the numbers of another formulation; and whether another method goes on from here.
    std::vector<double> other;
    bool anew = false;
};

// A contact that the step at hand meets, or a friction: its number; whether it lets go or begins to slide; the coordinate that
// has come to rest, or -1; and whether the step ends there.
struct MetContact {
    int stop = -1;
    bool released = false;
    int rests = -1;
    bool at_end = false;
};

struct Run {
    using Vector = Eigen::VectorXd;

    Run(std::unique_ptr<Mechanics> of, Steps given, const std::vector<double>& y, std::vector<long> turns);
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    // Ends the run.
    void stop(const Outcome& reached) { outcome = reached; }
    TimeWindow window() const { return schedule.window(); }
    // Whether contacts are decided here, and whether steps end at switches.
    bool has_contacts() const { return contacts.any(); }
    bool locates() const { return switches.any(); }

    // Constant.
    const std::unique_ptr<Mechanics> mechanics;
    const Steps steps;
    Equations& equations;
    const Mechanism& model;
    const Thresholds& thresholds;
    Projector& projector;
    Stepper& stepper;
    Phases& phases;
    std::unique_ptr<Formulation> other;
    double spacing = 1.0;      // at least how often forces of contacts are looked at, s
    bool halts = false;        // ends before a step that meets something, as the trial run of a method does
    bool keeps_marks = false;  // whether marks are asked for

    // The state, and what works on its parts.
    RunState state;
    State& now = state.now;
    Schedule schedule;
    StepSizeControl control;
    SwitchEvents switches;
    ContactPolicy contacts;
    Instants instants;
    Outcome outcome{};
    std::optional<RunState> mark;  // where a longer run can go on from; before the first step, where this one does
    bool began = false;            // whether the slope at the first state is known
    bool left_at_end = false;      // whether a step has ended where contacts could not be held
    bool pauses = false;           // so many steps were tried as were asked for
    bool waits = false;            // for values from outside, at a break
    long factorised_before = 0;    // by the run that this one continues

    // The step at hand: its end, and the state there, which becomes `now`; the crossing of a switch at its end; the norm of its
    // error; why it overflowed or had no solution; whether it was made in halves, and its extension is set.
    Target to{};
    State next;
    std::optional<Crossing> crossing;
    double error = 0.0;
    Outcome lost{};
    bool halved = false, extended = false;
    MetContact met;

    // What is recorded.
    SampleBlock block;
    std::optional<StepPath> path;  // if it is asked for

    // Scratch.
    const TurnCounter turns;
    StepDoubling doubling;
    StopWatch watch;
    State inside;  // a state between the ends of the step at hand
};

// Before the first step: goes on from the mark of a run with the same start. False where the mark does not fit.
bool resume(Run& run, RunState mark);
// Where a longer run can go on from; null where that is the start.
const RunState* mark_of(Run& run);
// Takes a mark, if marks are asked for: none once the run's end has limited a step, since a longer run makes other steps.
void take_mark(Run& run);
// A mark of the state between two steps, for a run by another method: this run's end may have limited a step.
RunState here(Run& run);

// The loop itself decides stops and frictions with these laws. False where the state does not fit them.
bool begin_contacts(Run& run, std::vector<StopLaw> laws, std::vector<FrictionLaw> frictions, ImpactLaw impacts,
                    ContactState state, double spacing, LoadedJoints joints_in_space);
// Before the first step: another formulation makes accelerations and projections.
void follow_formulation(Run& run, std::unique_ptr<Formulation> other);

// Runs on until there are `samples` more samples, `seconds` have passed, `attempts` steps were tried since the start, or the
// run ends.
void advance(Run& run, std::size_t samples, double seconds, long attempts = std::numeric_limits<long>::max());
// Tries a step of size h from the start, and does not take it: `next` has its end. Returns the estimated error of each
// number of y; null where it cannot be made.
const Eigen::VectorXd* try_step(Run& run, double h);

// Records a state; h is the size of the step that led there.
void sample(Run& run, const State& at, double h);

}  // namespace mbproj
