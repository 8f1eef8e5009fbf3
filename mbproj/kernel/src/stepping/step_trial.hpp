// One step on trial: attempted, made shorter where its error or the check by halves asks for it, and made to end where a
// switch of a law changes its branch.
#pragma once

#include "contacts/stop_watch.hpp"
#include "model/phase_times.hpp"
#include "stepping/schedule.hpp"
#include "stepping/state_events.hpp"
#include "stepping/step_end.hpp"

namespace mbproj {

// The current point of a run: y at t; the size of the next step, its end, and the state there.
struct Standing {
    double t, h = 0.0;
    Eigen::VectorXd y, y_new;
    Target to{};
    Counters counters{};
    Outcome outcome{};
};

class StepTrial {
public:
    StepTrial(const Steps& steps, Standing& now, Equations& equations, Projector& projector, Stepper& stepper,
              StepEnd& step_end, Schedule& schedule, Phases& phases);

    StateEvents& events() { return events_; }
    const StateEvents& events() const { return events_; }
    // Steps end at events in the state; fixed ones pass over those from which the motion is pushed back.
    bool locates() const { return locates_; }
    bool passes() const { return events_.passes(); }
    StepSizeControl& control() { return control_; }
    const std::vector<Halved>& halvings() const { return halvings_.all(); }
    // Of the last step: the check by halves, null if none was due; the crossing at its end; its error; why it failed.
    const StepDoubling* halves() const { return halved_ ? &doubling_ : nullptr; }
    std::optional<Crossing>& crossing() { return crossing_; }
    double error() const { return error_; }
    const Outcome& lost() const { return lost_; }

    // How often the current step was shortened near a singular pose; `resume` restores this.
    int shortened() const { return shortened_; }
    void resume(const StepSizeControl::Saved& control, int shortened, const std::vector<Halved>& halved);

    // A step to `now.to`, or nearer. False where the run stops, or where the step is to be tried again; also where a switch
    // changes its branch at its very start: `crossing` is set then.
    bool make() { return attempt() && (!locates_ || end_at_crossing()) && agrees_with_halves(); }

    // The step to `now.to` once more, where it is known to end there. False where it is to be tried again.
    bool again() { return halved_ = false, attempt(); }
    // The stages of a step alone, with the rows that are held; false also where others would serve.
    bool stages();

    // The norm of the error of its stages; nothing where they fail.
    std::optional<double> stages_and_error();

    // Rejects the step that was made: the next one is tried with size h.
    void reject(double h);

    // Sets the continuous extension: for samples after the projection, which uses the last factor; for events before.
    bool extend();

private:
    // A step from y to y_new, by the stepper alone.
    bool attempt();

    // Whether a fixed step is to be made in halves: it passes a singular pose, so that stages have left rows out. Only
    // one half has such an error, of the third power of its size. A step that ends beyond the reach of its joints
    // passes none.
    bool passes_branch();

    // A fixed step whose equations were not solved is tried again in halves.
    void halve();

    // Where a switch changes its branch within the step that was tried, the step is made again, so that it ends there:
    // first where its extension shows the crossing, then by Newton's method on the ends of the steps themselves.
    bool end_at_crossing();

    // Near a singular pose, the same step in two halves. False where these cannot be made, or where they are so far off
    // that the step is to be tried again.
    bool agrees_with_halves();

    // The slope at the end of a step whose error is not estimated: the cubic through both ends shows where events are.
    bool set_end_slope();
    bool halves_made();

    // How far the step and its extension are from its halves.
    double off();

    // Why a step could not be made.
    Outcome failed_at(double t);
    void stop_at(double t) { now_.outcome = failed_at(t); }

    const Steps& steps_;
    const Thresholds& thresholds_;
    Standing& now_;
    Equations& equations_;
    Stepper& stepper_;
    StepEnd& step_end_;
    Schedule& schedule_;
    Phases& phases_;
    StepDoubling doubling_;
    StepSizeControl control_;
    StateEvents events_;
    Halvings halvings_;
    const bool locates_;
    Eigen::VectorXd copy_, slope_;
    std::optional<Crossing> crossing_;  // the crossing at which the step ends
    double error_ = 0.0;                // the norm of the error
    Outcome lost_{};                    // why the last step that was tried overflowed or had no solution
    bool halved_ = false, extended_ = false;
    int shortened_ = 0;  // how often the current step was shortened near a singular pose
};

}  // namespace mbproj
