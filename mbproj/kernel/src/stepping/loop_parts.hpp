// The parts of a time loop, each after those that it needs.
#pragma once

#include "dynamics/instants.hpp"
#include "steppers/choice.hpp"
#include "stepping/mark.hpp"
#include "stepping/stop_events.hpp"

namespace mbproj {

template <class D> class LoopParts {
public:
    LoopParts(const LoopParts&) = delete;
    LoopParts& operator=(const LoopParts&) = delete;

protected:
    LoopParts(Model<D> model, Tableau tableau, ProjectionSettings projection, Steps steps, const std::vector<double>& y)
        : model_(tableau.is_implicit() ? with_compliant_rows(std::move(model)) : std::move(model)),
          tableau_(std::move(tableau)), projection_(projection), steps_(std::move(steps)),
          equations_(model_, projection_), projector_(equations_, projection_, phases_),
          made_by_(stepper_of(tableau_, equations_, projector_, steps_.fixed() ? 0.0 : steps_.tolerance)),
          stepper_(*made_by_), turns_(model_, equations_, stepper_), step_end_(model_, equations_, projector_, turns_),
          schedule_(steps_), now_{steps_.start, 0.0, Eigen::Map<const Eigen::VectorXd>(y.data(), model_.layout.size()),
                                  Eigen::VectorXd::Zero(model_.layout.size())},
          trial_(steps_, now_, equations_, projector_, stepper_, step_end_, schedule_, phases_),
          stops_(steps_, now_, equations_, stepper_, step_end_, schedule_, trial_), instants_(model_, equations_) {}
    ~LoopParts() = default;

    Schedule& schedule() { return schedule_; }
    StateEvents<D>& events() { return trial_.events(); }
    const StateEvents<D>& events() const { return trial_.events(); }
    // The values of programs of the time and channels, at the state between two steps.
    std::vector<double> values(const Programs& programs) { return instants_.values(programs, now_.t, now_.y.data()); }
    // Sets states of elements from here on, where the run waits.
    void give(typename Instants<D>::Given states) { instants_.give(std::move(states)); }
    // At a break that asks, a run waits for values from outside.
    bool is_asked() { return waits = !instants_.any_given() && schedule_.asks(now_.t); }
    // Changes states at the breaks that are passed: to values from outside, then by controllers.
    void act() {
        instants_.take_given(now_.y.data());
        bool looked = false;
        acted_ = schedule_.act([&](int action) {
            if (!std::exchange(looked, true)) instants_.set_channels(now_.t, now_.y.data());
            return instants_.act(action, now_.y.data());
        });
    }
    void go_on() {
        if (steps_.fixed()) return;  // else the step is chosen anew
        trial_.control().forget();
        choose_step(schedule_.left(now_.t));
    }

    bool choose_step(double longest) {
        const FirstStep first = stepper_.first_step(now_.t, now_.y, steps_.tolerance, longest);
        ++now_.counters.evaluations;
        if (first.h < 0.0) return stop_at(now_.t), false;
        now_.h = std::max(first.h, schedule_.shortest(now_.t));  // round-off of y may ask for less
        shaped_ = shaped_ || (first.limited && schedule_.is_before_end());
        return true;
    }

    Projector<D>& projector() { return projector_; }
    // Before the first step: another formulation makes accelerations and projections.
    void follow_formulation(std::unique_ptr<Formulation> other) {
        other_ = std::move(other);
        equations_.follow(other_.get());
    }
    // Takes over a mark, except its contacts, which follow when the run begins. False where it is not of such a loop.
    bool takes(const Mark<D>& mark) {
        auto* rows = step_end_.invariants();
        if (mark.contacts.has_value() != stops_.inside() || mark.kept.has_value() != (rows != nullptr)) return false;
        if (mark.contacts && !stops_.policy().fits(*mark.contacts)) return false;
        if (rows) rows->kept = *mark.kept;
        if (other_ && !other_->resume(mark.other)) return false;
        return events().resume(mark.events);
    }
    void make_again() {  // takes back the step that was closed
        --now_.counters.steps;
        counted_ = counted_before_;
        step_end_.take_back();
    }
    // Begins a new balance of the conserved quantities, at the current state.
    void begin_balance() {
        if (auto* rows = step_end_.invariants()) rows->begin(now_.t, now_.y.data());
    }

    void stop(const Outcome& reached) { now_.outcome = reached; }
    void stop_at(double t) { stop(step_end_.failed_at(t)); }

    void count_factorisations() {
        now_.counters.factorisations = factorised_before_ + equations_.solver().factorisations();
    }
    void reach() {
        schedule_.reach(now_.to);
        if (path) path->add(now_.t, now_.to.h, now_.y);
    }
    void write(Mark<D>& mark) {
        count_factorisations();
        mark.t = now_.t, mark.h = now_.h, mark.y = now_.y, mark.grid = schedule_.grid();
        mark.part = schedule_.parts().at(), mark.halved = trial_.halvings();
        mark.counted = counted_, mark.counters = now_.counters, mark.peaks = peaks;
        mark.control = trial_.control().save(), mark.shortened = trial_.shortened();
        if (events().any()) mark.events = events().save();
        if (stops_.inside()) mark.contacts = stops_.policy().state();
        if (const auto* rows = step_end_.invariants()) mark.kept = rows->kept;
        if (other_) mark.other = other_->save();
        mark.shaped = shaped_, mark.anew = false;
        if (stepper_.carries_slope()) mark.slope = stepper_.first();
    }

    const Model<D> model_;
    const Tableau tableau_;
    const ProjectionSettings projection_;
    const Steps steps_;
    Phases phases_;
    std::unique_ptr<Formulation> other_;
    EquationsOfMotion<D> equations_;
    Projector<D> projector_;
    const std::unique_ptr<Stepper<D>> made_by_;
    Stepper<D>& stepper_;
    TurnCounter<D> turns_;
    StepEnd<D> step_end_;
    Schedule schedule_;
    Standing now_;
    StepTrial<D> trial_;
    StopEvents<D> stops_;
    Instants<D> instants_;
    typename TurnCounter<D>::Counted counted_, counted_before_;
    Peaks peaks;
    std::optional<StepPath> path;  // if it is asked for
    std::optional<Mark<D>> mark_;
    bool started_ = false;
    bool keeps_marks = false;     // whether marks are asked for
    long factorised_before_ = 0;  // by the run that this one continues
    bool shaped_ = false;         // whether the run's end has limited a step
    bool waits = false;           // at a break, for values from outside
    bool acted_ = true;           // whether all values of controllers were finite
};

}  // namespace mbproj
