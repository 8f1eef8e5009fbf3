// The parts of a step, in the order in which `step.cpp` takes them. A part that returns false has ended the step: the run
// stops, or tries another one from the same state.
#pragma once

#include "step/run.hpp"

namespace mbproj {

// At a break functions of time belong to that time itself, while the end of the step is closed.
class EndAtBreak final {
public:
    explicit EndAtBreak(Run& run) : run_(run) {
        if (run.to.at_break) run.equations.set_window({});
    }
    ~EndAtBreak() {
        if (run_.to.at_break) run_.equations.set_window(run_.window());
    }
    EndAtBreak(const EndAtBreak&) = delete;
    EndAtBreak& operator=(const EndAtBreak&) = delete;

private:
    Run& run_;
};

// Makes a step. Where samples lie inside it, it waits to be taken over until they are recorded.
void step(Run& run);
// Records the next sample inside the step that was made: a copy of the extension's value is projected, which the integration
// does not see.
void sample_inside(Run& run);
// Takes the step over: its end becomes the state of the run.
void commit(Run& run);
// What follows a step, once contacts at its end are decided.
void end_step(Run& run);

// attempt.cpp: the stages of a step to `to`, and its error.

bool attempt(Run& run);
// Its stages, with the rows that are held, else with others; the norm of their error, which for fixed steps is 0. Nothing
// where they fail.
std::optional<double> stages(Run& run);
// Rejects the step: the next one is tried with size h.
void reject(Run& run, double h);
// Sets the continuous extension: for samples after the projection, which uses the last factor; for events before.
bool extend(Run& run);
// Near a singular pose, the same step in two halves. False also where they are so far off that a shorter one is tried.
bool agrees_with_halves(Run& run);
// Ends the run where a step could not be made.
void stop_unsolved(Run& run, double t);

// switch_events.cpp

// Where a law changes its branch within the step, the step is made again, so that it ends there: first where its extension
// shows the crossing, then by Newton's method on the ends of the steps themselves. At the very start of the step the branch
// changes at once.
bool cut_at_switch(Run& run);

// close.cpp

// Projects the end of the step, checks it, and counts its turns.
bool close(Run& run);
// The same for a trial. Returns why the run cannot go on from there; `running` where it can.
Outcome closed_end(Run& run);
// Moves a state inside the step to the constraints. Returns why it cannot be recorded; `running` where it can.
Outcome close_inside(Run& run, State& inside);
// Evaluates the slope at the closed end; multipliers where they are `asked` for, or a sample is due.
bool arrive(Run& run, bool asked);
// Forgets the end of the step: it is made again.
void discard_end(Run& run);
// Why the equations have just had no solution.
Outcome failed_at(Run& run, double t);
void stop_at(Run& run, double t);  // for that reason

// contact_events.cpp

// Whether the step meets a contact, or a friction changes. Such an end is discarded. Where a friction pushes along the motion,
// nothing could be right, and the run stops.
[[gnu::noinline, gnu::cold]] bool meets(Run& run);
// Makes the step once more, to where the meeting is. False also where that is at once, and decided.
[[gnu::noinline, gnu::cold]] bool locate(Run& run);
// Shortens a fixed step so that sliding in a plane does not come to rest in it.
void shorten_to_rest(Run& run);
// Decides contacts that are not known at the start of a run, and puts the pose in place. False where nothing can be decided.
bool decide_first(Run& run);
// Decides what happens at `now`: this contact is met, or `released`; or none, -1. False where nothing can be decided.
bool decide(Run& run, int stop, bool released);
// Looks at the gaps where the next step starts.
void watch_from_here(Run& run);
// Whether a run cannot go on because rows of contacts have come to depend on each other, or on the joints'.
bool loses_contacts(Run& run);
// Adds the contacts to the last sample.
void record_contacts(Run& run, const std::vector<double>& lambda);

// jumps.cpp: changes at an instant

// From here on functions of time are evaluated after the break, where controllers act.
void cross_break(Run& run);
// Changes the branch of a switch at its crossing. False where the run stops.
bool cross_switch(Run& run);
// Decides the contact that is met. Velocities may jump, and with them branches of forces. False where the run stops.
[[gnu::noinline, gnu::cold]] bool meet_contact(Run& run);
// Decides anew which contacts hold, where the equations cannot hold them.
[[gnu::noinline, gnu::cold]] void decide_anew(Run& run);
// With error control the size of the next step is chosen anew.
void choose_step_anew(Run& run);
bool choose_step(Run& run);
// Begins a new balance of the conserved quantities.
void begin_balance(Run& run);

}  // namespace mbproj
