// The time loop: step, project, check, record; with a fixed step, or with the step that the error allows. Its parts have
// their own headers: the stepper, the schedule with its breaks, the trial of a step, its end, events in the state, samples.
#pragma once

#include "dynamics/instants.hpp"
#include "steppers/mechanics.hpp"
#include "stepping/flush_to_zero.hpp"
#include "stepping/mark.hpp"
#include "stepping/stop_events.hpp"

namespace mbproj {

class TimeLoop final {
public:
    using Vector = Eigen::VectorXd;

    TimeLoop(std::unique_ptr<Mechanics> mechanics, Steps steps, const std::vector<double>& y, std::vector<long> turns);
    TimeLoop(const TimeLoop&) = delete;
    TimeLoop& operator=(const TimeLoop&) = delete;

    // Before the first step: goes on from the mark of a run with the same start. False where the mark does not fit.
    bool resume(Mark mark);
    // Where a longer run can go on from; null where that is the start.
    const Mark* mark();

    // Runs on until there are `samples` more samples, `seconds` have passed, `attempts` steps were tried since the start, or
    // the run ends.
    void advance(std::size_t samples, double seconds, long attempts = std::numeric_limits<long>::max());
    // A mark of the state between two steps, for a run by another method: this run's end may have limited a step.
    Mark here();
    // Tries a step of size h from the start, and does not take it. Returns the estimated error of each number of y;
    // `now` has its end. Null where it cannot be made.
    const Vector* try_step(double h);
    SampleBlock block;
    Peaks peaks;
    std::optional<StepPath> path;  // if it is asked for
    bool keeps_marks = false;      // whether marks are asked for
    bool waits = false;            // at a break, for values from outside
    bool pauses = false;           // whether `advance` came back because so many steps were tried
    const Mechanism& model() const { return model_; }
    bool carries_slope() const { return stepper_.carries_slope(); }
    const Phases& phases() const { return phases_; }
    Equations& equations() { return equations_; }
    const std::vector<Halved>& halved() const { return trial_.halvings(); }
    StopEvents& stops() { return stops_; }
    const StopEvents& stops() const { return stops_; }
    const Standing& now() const { return now_; }
    const std::vector<long>& turns() const { return counted_.turns; }
    Schedule& schedule() { return schedule_; }
    StateEvents& events() { return trial_.events(); }
    const StateEvents& events() const { return trial_.events(); }
    // The values of programs of the time and channels, at the state between two steps.
    std::vector<double> values(const Programs& programs) { return instants_.values(programs, now_.t, now_.y.data()); }
    // Sets states of elements from here on, where the run waits.
    void give(Instants::Given states) { instants_.give(std::move(states)); }
    Projector& projector() { return projector_; }
    // Before the first step: another formulation makes accelerations and projections.
    void follow_formulation(std::unique_ptr<Formulation> other);

private:
    void begin();

    // Decides anew which contacts hold at the current state, where the equations cannot hold them.
    [[gnu::noinline, gnu::cold]] void decide_anew();
    void go_on_from_mark();

    // Makes a step. Its end is closed and counted; samples inside follow one by one, before the step is taken over.
    void step();
    bool take_step(bool watching);
    // The end of a step: closed, counted, and its slope evaluated.
    bool accept(bool watching);

    // Makes the step that meets a stop again, to there. False where that fails, or the stop is met at once.
    [[gnu::noinline, gnu::cold]] bool end_at_meeting();
    void report_turns(const Outcome& untold);
    // Projects a copy of the extension's value; the integration does not see it.
    void sample_inside();
    void finish_step();
    // What follows a step.
    void end_step();

    // No mark once the run's end has limited a step: a longer run makes other steps.
    void take_mark();
    bool evaluate(const Vector& y, bool with_multipliers);
    void sample(double t, const Vector& y, const Vector& slope, const std::vector<double>& lambda, double h,
                const TurnCounter::Counted& turned);

    // At a break that asks, a run waits for values from outside.
    bool is_asked() { return waits = !instants_.any_given() && schedule_.asks(now_.t); }
    // Changes states at the breaks that are passed: to values from outside, then by controllers.
    void act();
    void go_on();
    bool choose_step(double longest);

    // Takes over a mark, except its contacts, which follow when the run begins. False where it is not of such a loop.
    bool takes(const Mark& mark);
    // Takes back the step that was closed.
    void make_again();
    // Begins a new balance of the conserved quantities, at the current state.
    void begin_balance();
    void stop(const Outcome& reached) { now_.outcome = reached; }
    void stop_at(double t) { stop(step_end_.failed_at(t)); }

    void count_factorisations() { now_.counters.factorisations = factorised_before_ + equations_.factorisations(); }
    void reach();
    void write(Mark& mark);
    [[gnu::noinline, gnu::cold]] bool meet_stop();
    // Velocities may jump, and with them branches of forces. False where the run stops, also where nothing can be decided.
    template <class Change> bool change_contacts(const Change& change) {
        bool met = true;
        if (!stepper_.before_jump(now_.t, now_.y)) return stop_at(now_.t), false;
        const bool goes_on = jump([&] { met = change(); });
        if (!met) stop({Status::undecided, now_.t});
        if (!met || !goes_on) return false;
        stops_.set_start(now_.t, now_.y, counted_.turns);
        turns_.take_speeds(counted_);
        go_on();
        return true;
    }

    // From here on functions of time are evaluated after the break.
    void cross_break();
    // Makes an instantaneous change: switches whose arguments jump with it take the branch at the new argument.
    template <class Change> bool jump(const Change& change) {
        if (trial_.locates()) events().before_jump(now_.t, now_.y, schedule_.window());
        change();
        if (trial_.locates()) events().after_jump(now_.t, now_.y, schedule_.window());
        return renew() && (!trial_.locates() || !events().any_free() || change_branches([this] { events().turn(); }));
    }

    // Changes the branch of a switch at its crossing. False where the run stops.
    bool cross_event();

    template <class Change> bool change_branches(const Change& change) {  // false where the motion leads back
        events().glance_before(now_.t, now_.y, stepper_.first(), now_.h, schedule_.window());
        if (!stepper_.before_jump(now_.t, now_.y)) return stop_at(now_.t), false;
        change();
        do {
            if (!renew()) return false;
            events().glance_after(now_.t, now_.y, stepper_.first(), now_.h, schedule_.window());
        } while (events().passes_over_back(now_.t));
        return events().pushed_back() < 0 || (stop(Outcome::pushed_back(now_.t, events().pushed_back())), false);
    }

    // The slope at the state, and a new balance.
    bool renew();

    const std::unique_ptr<Mechanics> mechanics_;
    const Steps steps_;
    Phases& phases_;
    std::unique_ptr<Formulation> other_;
    Equations& equations_;
    const Mechanism& model_;
    Projector& projector_;
    Stepper& stepper_;
    TurnCounter turns_;
    StepEnd step_end_;
    Schedule schedule_;
    Standing now_;
    StepTrial trial_;
    StopEvents stops_;
    Instants instants_;
    TurnCounter::Counted counted_, counted_before_;
    std::optional<Mark> mark_;
    bool started_ = false;
    long factorised_before_ = 0;  // by the run that this one continues
    bool shaped_ = false;         // whether the run's end has limited a step
    bool acted_ = true;           // whether all values of controllers were finite
    Vector slope_;                // at the end of a step, until the step is taken over
    Vector copy_, copy_slope_;    // of a sample inside a step
    std::vector<double> lambda_, copy_lambda_;
    bool meets_ = false;        // whether the current step meets a stop
    bool began_ = false;        // whether the slope at the first state is known
    bool left_at_end_ = false;  // whether a step has ended where contacts could not be held
};

}  // namespace mbproj
