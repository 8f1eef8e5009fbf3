// The time loop: step, project, check, record; with a fixed step, or with the step that the error allows. Its parts have
// their own headers: the stepper, the schedule with its breaks, the trial of a step, its end, events in the state, samples.
#pragma once

#include "dynamics/instants.hpp"
#include "stepping/flush_to_zero.hpp"
#include "stepping/mark.hpp"
#include "stepping/mechanics.hpp"
#include "stepping/stop_events.hpp"

namespace mbproj {

class TimeLoop final {
public:
    using Vector = Eigen::VectorXd;

    TimeLoop(std::unique_ptr<Mechanics> mechanics, Steps steps, const std::vector<double>& y, std::vector<long> turns)
        : mechanics_(std::move(mechanics)), steps_(std::move(steps)), phases_(mechanics_->phases),
          equations_(mechanics_->equations()), model_(equations_.mechanism()), projector_(mechanics_->projector()),
          stepper_(mechanics_->stepper()), turns_(equations_, stepper_), step_end_(equations_, projector_, turns_),
          schedule_(steps_), now_{steps_.start, 0.0, Eigen::Map<const Vector>(y.data(), model_.layout.size()),
                                  Vector::Zero(model_.layout.size())},
          trial_(steps_, now_, equations_, projector_, stepper_, step_end_, schedule_, phases_),
          stops_(steps_, now_, equations_, stepper_, step_end_, schedule_, trial_), instants_(equations_),
          slope_(now_.y), copy_(now_.y), copy_slope_(now_.y), lambda_(model_.all_multipliers()), copy_lambda_(lambda_) {
        counted_.turns = std::move(turns);
    }
    TimeLoop(const TimeLoop&) = delete;
    TimeLoop& operator=(const TimeLoop&) = delete;

    // Before the first step: goes on from the mark of a run with the same start. False where the mark does not fit.
    bool resume(Mark mark) {
        mark_ = std::move(mark);
        return takes(*mark_);
    }
    const Mark* mark() {  // where a longer run can go on from; null where that is the start
        if (started_ && steps_.fixed()) take_mark();
        return mark_ ? &*mark_ : nullptr;
    }

    // Runs on until there are `samples` more samples, `seconds` have passed, `attempts` steps were tried since the start, or
    // the run ends.
    void advance(std::size_t samples, double seconds, long attempts = std::numeric_limits<long>::max()) {
        const FlushToZero flush;
        const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
        block.clear();
        if (std::exchange(waits, false)) cross_break();
        const long look = std::max(1L, 64L / (1 + model_.size() / 8));  // steps between two looks at the clock
        pauses = false;
        for (long done = 0; now_.outcome.status == Status::running && block.t.size() < samples && !pauses && !waits;
             ++done) {
            if (done % look == look - 1 && std::chrono::steady_clock::now() > until) break;
            if (!started_)
                begin();
            else if (schedule_.inside())
                sample_inside();
            else if (now_.counters.steps + now_.counters.rejected_steps >= attempts)
                pauses = true, take_mark();
            else
                step();
        }
        if ((began_ || !mark_) && stops_.loses_contacts(now_.outcome)) decide_anew();
        count_factorisations();
    }
    // A mark of the state between two steps, for a run by another method: this run's end may have limited a step.
    Mark here() {
        Mark mark;
        return write(mark), mark;
    }
    // Tries a step of size h from the start, and does not take it. Returns the estimated error of each number of y;
    // `now` has its end. Null where it cannot be made.
    const Vector* try_step(double h) {
        const FlushToZero flush;
        begin();
        now_.to = schedule_.to(now_.t, now_.t + h);
        return !now_.outcome.stops() && trial_.stages_and_error() ? stepper_.estimate() : nullptr;
    }
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
    void follow_formulation(std::unique_ptr<Formulation> other) {
        other_ = std::move(other);
        equations_.follow(other_.get());
    }

private:
    void begin() {
        started_ = true, ++now_.counters.evaluations;
        equations_.set_pose(now_.t, now_.y.data());
        equations_.set_velocities(now_.y.data(), true);
        peaks.watch(equations_.constraint(), equations_.C_dot(), model_.row_count(), model_.driven_count(), now_.t);
        counted_ = turns_.start(counted_.turns, now_.t, now_.y);
        if (mark_) return go_on_from_mark();
        if (stops_.begins() && !stops_.start(counted_.turns)) return stop({Status::undecided, now_.t});
        if (stops_.watch().any()) stops_.set_start(now_.t, now_.y, counted_.turns);
        if (!equations_.start() || !evaluate(now_.y, true)) return stop_at(now_.t);
        began_ = true, stepper_.first() = slope_, begin_balance();
        now_.h = steps_.step;
        if (!steps_.fixed() && !choose_step(schedule_.left(now_.t))) return;
        sample(now_.t, now_.y, slope_, lambda_, now_.h, counted_);
        equations_.set_window(schedule_.window());
        if (trial_.passes()) events().watch(now_.t, now_.y, schedule_.window());
        if (schedule_.is_after_break() || trial_.locates()) cross_break();
    }

    // Decides anew which contacts hold at the current state, where the equations cannot hold them.
    [[gnu::noinline, gnu::cold]] void decide_anew() {
        const Outcome lost = std::exchange(now_.outcome, {});
        const auto change = [this] { return stops_.decide_anew(counted_.turns); };
        if (!began_ && change())
            started_ = false, --now_.counters.evaluations;
        else if (!began_)
            stop({Status::undecided, now_.t});
        else if (change_contacts(change) && std::exchange(left_at_end_, false))
            end_step();
        if (now_.outcome.status == Status::undecided && stops_.policy().undecided().cause == Cause::no_inertia)
            stop(lost);
    }

    void go_on_from_mark() {
        now_.t = mark_->t, now_.h = mark_->h, now_.y = mark_->y, now_.counters = mark_->counters;
        counted_ = mark_->counted, peaks = mark_->peaks;
        trial_.resume(mark_->control, mark_->shortened, mark_->halved);
        schedule_.resume(now_.t, mark_->grid, StepParts(mark_->part));
        if (trial_.locates()) events().hold();
        equations_.set_window(schedule_.window());
        if (mark_->contacts) stops_.resume(*mark_->contacts);
        if (stops_.watch().any()) stops_.set_start(now_.t, now_.y, counted_.turns);
        equations_.set_pose(now_.t, now_.y.data());
        equations_.set_velocities(now_.y.data(), false);
        const bool anew = mark_->anew, carries = stepper_.carries_slope() && !anew;
        if (!equations_.start() || !(carries || evaluate(now_.y, false))) return stop_at(now_.t);
        if (carries) slope_ = mark_->slope;
        began_ = true, stepper_.first() = slope_;
        factorised_before_ = now_.counters.factorisations - equations_.factorisations();
        shaped_ = mark_->shaped;
        if (anew) mark_.reset();  // another run with this method cannot go on from it
    }

    // Makes a step. Its end is closed and counted; samples inside follow one by one, before the step is taken over.
    void step() {
        if (!steps_.fixed() && !schedule_.resolves(now_.t, now_.h))
            return stop(trial_.lost().stops() ? trial_.lost() : Outcome{Status::vanished, now_.t});
        now_.to = schedule_.target(now_.t, now_.h);
        if (steps_.fixed()) stops_.shorten(stepper_.first());
        if (!steps_.fixed() || now_.to.shaped) take_mark();
        shaped_ = shaped_ || now_.to.shaped;
        phases_.begin(now_.counters.steps + 1);
        if (!trial_.make()) {
            if (trial_.crossing() && !now_.outcome.stops() && cross_event()) go_on();
            return;
        }
        if (!take_step(stops_.watch().any()) && !(meets_ && end_at_meeting())) return;
        if (schedule_.inside() && !trial_.extend()) return;
        if (!steps_.fixed()) now_.h = trial_.control().after_accepted(trial_.error(), now_.to.h);
        phases_.mark(Phase::rest);
        if (!schedule_.inside()) finish_step();
    }

    bool take_step(bool watching) {
        schedule_.enter(now_.to);
        if (now_.to.at_break) equations_.set_window({});  // samples there belong to that time itself
        const bool goes_on = accept(watching);
        if (now_.to.at_break) equations_.set_window(schedule_.window());
        return goes_on;
    }

    bool accept(bool watching) {  // the end of a step: closed, counted, and its slope evaluated
        meets_ = false;
        if (!all_finite(now_.y_new.data(), now_.y_new.size())) return stop({Status::not_finite, now_.to.t}), false;
        ++now_.counters.steps;
        now_.counters.evaluations += stepper_.arrival_cost();
        if (!steps_.fixed() || watching) counted_before_ = counted_;
        const Outcome closed =
            step_end_.close(now_.t, now_.y, now_.to.t, now_.y_new, counted_, trial_.halves(), now_.counters, peaks);
        if (closed.status == Status::untold && !steps_.fixed()) return report_turns(closed), false;
        if (closed.stops()) return stop(closed), false;
        double* lambda = now_.to.due || watching ? lambda_.data() : nullptr;
        if (!equations_.start() || !stepper_.arrive(now_.y_new, slope_, lambda) ||
            (now_.to.at_break && !stepper_.meet_break(now_.to.t, now_.y_new, schedule_.window(), slope_, lambda)))
            return stop_at(now_.to.t), false;
        if (!all_finite(slope_.data(), slope_.size())) return stop({Status::not_finite, now_.to.t}), false;
        meets_ = watching && stops_.meets(slope_, counted_.turns, lambda_);
        if (!meets_) return !watching || !stops_.finds_push(lambda_) || (stop({Status::undecided, now_.to.t}), false);
        make_again();
        if (stops_.halts()) stop({Status::halted, now_.t});  // where the step began
        return false;
    }

    // Makes the step that meets a stop again, to there. False where that fails, or the stop is met at once.
    [[gnu::noinline, gnu::cold]] bool end_at_meeting() {
        if (now_.outcome.stops()) return false;
        schedule_.leave();
        const auto found = stops_.locate(counted_, slope_);
        if (found == StopEvents::Found::none) return stop_at(now_.to.t), false;
        if (found == StopEvents::Found::at_once) return meet_stop(), false;
        if (!trial_.again() || !take_step(false)) return stops_.forget(), false;
        stops_.watch().begin(counted_.turns);
        return true;
    }

    void report_turns(const Outcome& untold) {
        make_again();
        trial_.reject(untold.step);  // it is made again, shorter
    }

    void sample_inside() {  // projects a copy of the extension's value; the integration does not see it
        const double time = schedule_.take();
        ++now_.counters.evaluations;
        const double h = now_.to.h, theta = (time - now_.t) / h;
        stepper_.at(now_.y, h, theta, copy_);
        if (const Outcome closed = step_end_.close_sample(time, copy_); closed.stops()) return stop(closed);
        if (!stepper_.inside(time, h, theta, copy_, copy_slope_, copy_lambda_.data())) return stop_at(time);
        const auto turned = turns_.inside(counted_before_, now_.t, counted_, now_.to.t, time, copy_);
        sample(time, copy_, copy_slope_, copy_lambda_, now_.to.h, turned);
        if (!schedule_.inside()) finish_step();
    }

    void finish_step() {
        now_.y.swap(now_.y_new);
        stepper_.first().swap(slope_);
        now_.t = now_.to.t;
        if (now_.to.due) sample(now_.t, now_.y, stepper_.first(), lambda_, now_.to.h, counted_);
        reach();
        if (trial_.passes()) events().watch(now_.t, now_.y, schedule_.window());
        if (stops_.meeting() && !meet_stop()) return void(left_at_end_ = true);
        end_step();
    }
    void end_step() {  // what follows a step
        if (schedule_.finished()) return stop({Status::finished, now_.t});
        if (trial_.crossing()) {
            if (cross_event()) now_.to.at_break ? cross_break() : go_on();
        } else if (now_.to.at_break) {
            cross_break();
        } else if (trial_.locates()) {
            events().set_free_signs(now_.t, now_.y, schedule_.window());
        }
    }

    // No mark once the run's end has limited a step: a longer run makes other steps.
    void take_mark() {
        if (shaped_ || !keeps_marks) return;
        if (!mark_) mark_.emplace();
        write(*mark_);
    }
    bool evaluate(const Vector& y, bool with_multipliers) {
        return equations_.slope_at(y.data(), slope_.data(), with_multipliers ? lambda_.data() : nullptr);
    }

    void sample(double t, const Vector& y, const Vector& slope, const std::vector<double>& lambda, double h,
                const TurnCounter::Counted& turned) {
        count_factorisations();
        block.add(t, y, slope, model_, lambda, h, turned.values(), now_.counters);
        if (stops_.inside()) stops_.record(block, lambda);
    }

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

    // Takes over a mark, except its contacts, which follow when the run begins. False where it is not of such a loop.
    bool takes(const Mark& mark) {
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

    void count_factorisations() { now_.counters.factorisations = factorised_before_ + equations_.factorisations(); }
    void reach() {
        schedule_.reach(now_.to);
        if (path) path->add(now_.t, now_.to.h, now_.y);
    }
    void write(Mark& mark) {
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

    [[gnu::noinline, gnu::cold]] bool meet_stop() {
        return change_contacts([this] { return stops_.meet(counted_.turns); });
    }
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

    void cross_break() {  // from here on functions of time are evaluated after the break
        if (is_asked()) return;
        equations_.set_window({});  // as in the current slope
        if (!stepper_.before_jump(now_.t, now_.y)) return stop_at(now_.t);
        equations_.set_window(schedule_.window());
        const bool goes_on = jump([this] {
            schedule_.pass_break(now_.t);
            equations_.set_window(schedule_.window());
            act();
        });
        if (goes_on) acted_ ? go_on() : stop_at(now_.t);
    }
    // Makes an instantaneous change: switches whose arguments jump with it take the branch at the new argument.
    template <class Change> bool jump(const Change& change) {
        if (trial_.locates()) events().before_jump(now_.t, now_.y, schedule_.window());
        change();
        if (trial_.locates()) events().after_jump(now_.t, now_.y, schedule_.window());
        return renew() && (!trial_.locates() || !events().any_free() || change_branches([this] { events().turn(); }));
    }

    // Changes the branch of a switch at its crossing. False where the run stops.
    bool cross_event() {
        const Crossing crossing = *trial_.crossing();
        trial_.crossing().reset();
        int often = -1;
        const bool passes = change_branches(
            [&] { often = events().cross(crossing, now_.t, schedule_.grain(now_.t), steps_.interval()); });
        if (often >= 0) return stop(Outcome::pushed_back(now_.t, often)), false;
        return passes;
    }

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

    bool renew() {  // the slope at the state, and a new balance
        begin_balance();
        ++now_.counters.evaluations;
        return stepper_.after_jump(now_.t, now_.y, stepper_.first(), nullptr) || (stop_at(now_.t), false);
    }

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
