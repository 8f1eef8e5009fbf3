// Contact events in the loop: a step that meets one is made again, to there, where the contact policy decides.
#pragma once

#include "contacts/contact_policy.hpp"
#include "contacts/meeting_search.hpp"
#include "stepping/step_trial.hpp"

namespace mbproj {

class StopEvents {
public:
    using Vector = Eigen::VectorXd;
    using Counted = TurnCounter::Counted;

    StopEvents(const Steps& steps, Standing& now, Equations& equations, Stepper& stepper, StepEnd& step_end,
               Schedule& schedule, StepTrial& trial);

    StopWatch& watch() { return watch_; }
    // The loop itself decides stops and frictions with these laws. False where the state does not fit them.
    bool begin(std::vector<StopLaw> laws, std::vector<FrictionLaw> frictions, ImpactLaw impacts, ContactState state,
               double spacing, LoadedJoints joints_in_space);
    void resume(const ContactState& state);
    bool inside() const { return policy_.any(); }
    // Whether a run ends before a step that meets something, as the trial run of a method does.
    bool halts() const { return halts_; }
    void halt() { halts_ = true; }
    ContactPolicy& policy() { return policy_; }
    const ContactPolicy& policy() const { return policy_; }

    // Whether a run cannot go on because rows of contacts have come to depend on each other, or on the joints'.
    bool loses_contacts(const Outcome& outcome);

    // Whether the step that was made, with this slope at its end, meets something.
    [[gnu::noinline, gnu::cold]] bool meets(const Vector& slope, const std::vector<long>& turns,
                                            const std::vector<double>& lambda);

    // Whether a friction pushes along the motion at the end of the step that was made: nothing could be right then.
    bool finds_push(const std::vector<double>& lambda) { return policy_.finds_push(now_.y_new, lambda); }

    enum class Found { nothing, at_once, ahead, none };

    // Finds the first meeting in the step that was made, and sets `now.to` there. `counted`: the turns at the start;
    // `slope`: that at the end of the step. `nothing`: nothing is met after all; `none`: a step on the way could not be
    // made.
    [[gnu::noinline, gnu::cold]] Found locate(const Counted& counted, const Vector& slope);

    // Whether contacts at the start of the run are not decided yet. `start` decides them, and puts the pose in place.
    // False where nothing can be decided.
    bool begins() const { return inside() && policy_.begins(); }
    bool start(const std::vector<long>& turns);
    // Shortens a fixed step from here, with this slope, so that sliding in a plane does not come to rest in it.
    void shorten(const Vector& slope);
    // Whether the current step ends at a meeting.
    bool meeting() const { return meeting_; }
    void forget() { meeting_ = false; }
    // Decides the meeting there; `decide_anew` decides contacts that are not known. False where nothing can be decided.
    bool meet(const std::vector<long>& turns);
    bool decide_anew(const std::vector<long>& turns) { return meet(turns, -1, false); }
    // Sets the start of the next step: y at t, with these turns.
    void set_start(double t, const Vector& y, const std::vector<long>& turns);

    // Adds the contacts to the last sample of a block, from its multipliers.
    void record(SampleBlock& block, const std::vector<double>& lambda);

private:
    bool meet(const std::vector<long>& turns, int stop, bool released);
    // Holds the rows again with which the step began, at its start.
    bool back(const Counted&);

    // Makes and closes a step of size h, and evaluates the margins at its end.
    bool reach(double h, const Counted& counted, MeetingSearch::Margins& found);

    // The multipliers at the part x of the step that was made. Stiff forces are those of its extension: at a state
    // beside it they are far off.
    bool solve_inside(const CubicStep& step, double x, std::vector<double>& lambda);

    // The margins at y at t. Where the slope is part of the state, forces are those of the last stage.
    bool margins(double t, const Vector& y, const std::vector<long>& turns, MeetingSearch::Margins& found);

    const Steps& steps_;
    Standing& now_;
    Equations& equations_;
    Stepper& stepper_;
    StepEnd& step_end_;
    Schedule& schedule_;
    StepTrial& trial_;
    StopWatch watch_;
    ContactPolicy policy_;
    Vector slope_, inside_;
    std::vector<double> lambda_;
    MeetingSearch::Margins last_;
    double spacing_ = 1.0;
    int stop_ = -1, rests_ = -1;
    bool released_ = false, meeting_ = false, last_known_ = false, halts_ = false;
};

}  // namespace mbproj
