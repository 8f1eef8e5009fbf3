// The time loop: step, project, check, record; with a fixed step, or with the step that the error allows. Its parts have
// their own headers: the stepper, the control of the step size, the schedule with its breaks, the end of a step, samples.
#pragma once

#include "stepping/flush_to_zero.hpp"
#include "stepping/schedule.hpp"
#include "stepping/step_end.hpp"

namespace mbproj {

template <int D> class TimeLoop {
public:
    using S = Size<D>;
    using Vector = Eigen::VectorXd;

    TimeLoop(Model<D> model, Tableau tableau, ProjectionSettings projection, Steps steps, const std::vector<double>& y,
             std::vector<long> turns)
        : model_(std::move(model)), tableau_(std::move(tableau)), projection_(projection), steps_(std::move(steps)),
          equations_(model_, projection_), projector_(equations_, projection_, phases_),
          stepper_(tableau_, equations_, model_.length), turns_(model_, equations_, stepper_),
          doubling_(stepper_, equations_, projector_), step_end_(model_, equations_, projector_, turns_),
          control_(stepper_.error_order(), model_.thresholds), schedule_(steps_), t_(steps_.start),
          y_(Vector::Zero(equations_.total())), y_new_(y_), slope_(y_), copy_(y_), copy_slope_(y_),
          lambda_(model_.all_rows()), copy_lambda_(lambda_), counted_{{}, std::move(turns)} {
        std::copy(y.begin(), y.end(), y_.data());
    }
    // Before the first step: the rows go on from what another run has saved between two of its steps.
    void resume(typename RowPolicy<D>::Saved rows) { resumed_ = std::move(rows); }
    TimeLoop(const TimeLoop&) = delete;
    TimeLoop& operator=(const TimeLoop&) = delete;

    // Runs on until there are `samples` more samples, `seconds` have passed, or the run ends.
    void advance(std::size_t samples, double seconds) {
        const FlushToZero flush;
        const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
        block.clear();
        const long look = std::max(1L, 64L / (1 + model_.size() / 8));  // steps between two looks at the clock
        for (long done = 0; outcome.status == Status::running && block.t.size() < samples; ++done) {
            if (done % look == look - 1 && std::chrono::steady_clock::now() > until) break;
            if (!started_)
                begin();
            else if (schedule_.inside())
                sample_inside();
            else
                step();
        }
        counters.factorisations = equations_.solver().factorisations();
    }

    SampleBlock block;
    Counters counters;
    Peaks peaks;
    Outcome outcome;

    const Model<D>& model() const { return model_; }
    const Phases& phases() const { return phases_; }
    EquationsOfMotion<D>& equations() { return equations_; }
    Projector<D>& projector() { return projector_; }

private:
    void begin() {
        started_ = true;
        ++counters.evaluations;
        equations_.set_pose(t_, y_.data());
        equations_.set_velocities(y_.data(), true);
        peaks.watch(equations_.constraint(), equations_.C_dot(), model_.constraints.rows, model_.driven.size(), t_);
        counted_ = turns_.start(counted_.turns, t_, y_);
        const bool regular = resumed_ ? equations_.resume(std::move(*resumed_)) : equations_.start();
        if (!regular || !evaluate(y_, true)) return stop_at(t_);
        stepper_.first() = slope_;
        h_ = steps_.step;
        if (!steps_.fixed() && !choose_step(schedule_.left(t_))) return;
        sample(t_, y_, slope_, lambda_, h_, counted_.turns);
        equations_.see(schedule_.window());
        if (schedule_.is_after_break()) cross_break();
    }

    // A step is attempted, and taken where its error allows it. Its end is closed and counted; samples that lie inside follow
    // one by one, before the step is taken over.
    void step() {
        if (!steps_.fixed() && !schedule_.resolves(t_, h_))
            return stop(lost_.stops() ? lost_ : Outcome{Status::vanished, t_});
        to_ = schedule_.target(t_, h_);
        phases_.begin(counters.steps + 1);
        if (!attempt()) return;
        schedule_.enter(to_);
        if (!agrees_with_halves()) return;
        if (to_.at_break) equations_.see({});  // what is recorded there belongs to that time itself
        const bool goes_on = accept();
        if (to_.at_break) equations_.see(schedule_.window());
        if (!goes_on || (!halved_ && schedule_.inside() && !extend())) return;
        if (!steps_.fixed()) h_ = control_.after_accepted(error_, to_.h);
        phases_.mark(Phase::rest);
        if (!schedule_.inside()) finish_step();
    }

    // From y_ to y_new_, by the stepper alone; false where the run stops, or where the step is to be tried again.
    bool attempt() {
        if (steps_.fixed()) {
            if (!stages() && !(equations_.hold_others() && stages())) return stop_at(to_.t), false;
            phases_.mark(Phase::evaluation);
            return true;
        }
        equations_.forget_broken_state();
        std::optional<double> error = stages_and_error();
        if (!error && equations_.hold_others()) error = stages_and_error();
        phases_.mark(Phase::evaluation);
        lost_ = {};
        if (!error || !std::isfinite(*error)) lost_ = error ? Outcome{Status::not_finite, to_.t} : failed_at(to_.t);
        error_ = error.value_or(not_a_number);
        if (!(error_ <= 1.0)) return reject(control_.after_rejected(error_, to_.h)), false;
        return true;
    }

    // With the rows that are held; false also where others would serve.
    bool stages() {
        equations_.policy().begin();
        counters.evaluations += stepper_.attempt_cost();
        return stepper_.attempt(t_, y_, to_.h, y_new_);
    }
    std::optional<double> stages_and_error() {
        ++counters.evaluations;
        if (!stages()) return std::nullopt;
        return stepper_.error(to_.t, y_, y_new_, to_.h, steps_.tolerance);
    }

    void reject(double h) {
        ++counters.rejected_steps;
        schedule_.leave();
        h_ = h;
    }

    // Near a singular pose, the same step in two halves. False where these cannot be made, or where they are so far off
    // that the step is to be tried again.
    bool agrees_with_halves() {
        halved_ = doubling_.is_near();
        if (halved_) {
            if (!halves() && !(equations_.hold_others() && halves())) return stop_at(to_.t), false;
            if (!steps_.fixed()) {
                if (!extend()) return false;
                if (shortened_ < model_.thresholds.most_shorter &&
                    off() > model_.thresholds.agreed_tolerances * steps_.tolerance)
                    return ++shortened_, reject(model_.thresholds.shorter * to_.h), false;
            }
        }
        shortened_ = 0;
        return true;
    }

    bool halves() { return doubling_.repeat(t_, y_, stepper_.first(), to_.t - t_, counters.evaluations); }

    // How far the step and its extension are from its halves.
    double off() {
        stepper_.at(y_, to_.h, 0.5, copy_);
        return std::max(doubling_.off(doubling_.end(), y_new_, to_.h), doubling_.off(doubling_.middle(), copy_, to_.h));
    }

    // The continuous extension: after the projection, which uses the last stage's factor; to be checked, before it.
    bool extend() {
        counters.evaluations += stepper_.extend_cost() + static_cast<long>(schedule_.count_inside());
        if (!stepper_.extend(t_, y_, to_.h)) return stop_at(t_), false;
        return true;
    }

    // The state y_new_ after a step: closed, counted, and its slope evaluated.
    bool accept() {
        if (!y_new_.allFinite()) return stop({Status::not_finite, to_.t}), false;
        ++counters.steps;
        ++counters.evaluations;
        if (!steps_.fixed()) counted_before_ = counted_;
        const Outcome closed =
            step_end_.close(t_, y_, to_.t, y_new_, counted_, halved_ ? &doubling_ : nullptr, counters, peaks);
        if (closed.status == Status::untold && !steps_.fixed()) return tell_turns(closed), false;
        if (closed.stops()) return stop(closed), false;
        if (!equations_.arrive() || !evaluate(y_new_, to_.due)) return stop_at(to_.t), false;
        if (!slope_.allFinite()) return stop({Status::not_finite, to_.t}), false;
        return true;
    }

    // A step that cannot tell turns is made again, shorter.
    void tell_turns(const Outcome& untold) {
        --counters.steps;
        counted_ = counted_before_;
        reject(untold.step);
    }

    // One sample inside a step: the extension's value, of which a copy is projected; the integration does not see it.
    void sample_inside() {
        const double time = schedule_.take();
        stepper_.at(y_, to_.h, (time - t_) / to_.h, copy_);
        if (const Outcome closed = step_end_.close_sample(time, copy_); closed.stops()) return stop(closed);
        if (!equations_.factor(Metric::mass)) return stop_at(time);
        equations_.set_velocities(copy_.data(), false);
        if (!equations_.slope_at(copy_.data(), copy_slope_.data(), copy_lambda_.data())) return stop_at(time);
        const auto turned = turns_.inside(counted_before_, t_, counted_, to_.t, time, copy_);
        sample(time, copy_, copy_slope_, copy_lambda_, to_.h, turned);
        if (!schedule_.inside()) finish_step();
    }

    void finish_step() {
        y_.swap(y_new_);
        stepper_.first().swap(slope_);
        t_ = to_.t;
        if (to_.due) sample(t_, y_, stepper_.first(), lambda_, to_.h, counted_.turns);
        schedule_.reach(to_);
        if (schedule_.finished()) return stop({Status::finished, t_});
        if (to_.at_break) cross_break();
    }

    // From a break on functions of time are seen from its other side, and the step is chosen anew.
    void cross_break() {
        schedule_.pass_break(t_);
        equations_.see(schedule_.window());
        equations_.set_pose(t_, y_.data());
        equations_.set_velocities(y_.data(), false);
        ++counters.evaluations;
        if (!equations_.factor(Metric::mass) || !evaluate(y_, false)) return stop_at(t_);
        stepper_.first() = slope_;
        if (steps_.fixed()) return;
        control_.forget();
        choose_step(model_.thresholds.part_after_break * schedule_.left(t_));
    }

    bool choose_step(double longest) {
        h_ = stepper_.first_step(t_, y_, steps_.tolerance, longest);
        ++counters.evaluations;
        if (h_ < 0.0) return stop_at(t_), false;
        return true;
    }

    bool evaluate(const Vector& y, bool with_multipliers) {
        return equations_.slope_at(y.data(), slope_.data(), with_multipliers ? lambda_.data() : nullptr);
    }

    void sample(double t, const Vector& y, const Vector& slope, const std::vector<double>& lambda, double h,
                const std::vector<long>& turned) {
        counters.factorisations = equations_.solver().factorisations();
        block.add<D>(t, y, slope, model_.size(), lambda, model_.constraints.rows, h, turned, counters,
                     model_.integrals());
    }

    void stop(const Outcome& reached) { outcome = reached; }
    void stop_at(double t) { stop(failed_at(t)); }
    Outcome failed_at(double t) { return step_end_.failed_at(t); }

    const Model<D> model_;
    const Tableau tableau_;
    const ProjectionSettings projection_;
    const Steps steps_;
    Phases phases_;
    EquationsOfMotion<D> equations_;
    Projector<D> projector_;
    Stepper<D> stepper_;
    TurnCounter<D> turns_;
    StepDoubling<D> doubling_;
    StepEnd<D> step_end_;
    StepSizeControl control_;
    Schedule schedule_;
    double t_, h_ = 0.0;
    Vector y_, y_new_, slope_;  // slope_ at y_new_, until the step is taken over
    Vector copy_, copy_slope_;  // of a sample inside a step
    std::vector<double> lambda_, copy_lambda_;
    typename TurnCounter<D>::Counted counted_, counted_before_;
    Target to_{};         // of the step at hand
    double error_ = 0.0;  // its norm
    Outcome lost_{};      // why the last step that was tried overflowed or had no solution; running where it did not
    std::optional<typename RowPolicy<D>::Saved> resumed_;
    bool started_ = false, halved_ = false;
    int shortened_ = 0;  // times the step at hand, near a singular pose
};

}  // namespace mbproj
