// The time loop: step, project, check, record; with a fixed step, or with the step that the error allows.
#pragma once

#include "projection/projector.hpp"
#include "stepping/flush_to_zero.hpp"
#include "stepping/samples.hpp"
#include "stepping/step_doubling.hpp"
#include "stepping/step_size_control.hpp"
#include "stepping/turn_counter.hpp"

namespace mbproj {

template <int D> class TimeLoop {
public:
    using S = Size<D>;
    using Vector = Eigen::VectorXd;

    TimeLoop(Model<D> model, Tableau tableau, ProjectionSettings projection, Steps steps, const std::vector<double>& y,
             std::vector<long> turns)
        : model_(std::move(model)), tableau_(std::move(tableau)), projection_(projection), steps_(std::move(steps)),
          equations_(model_, projection_), projector_(equations_, projection_, phases_),
          method_(tableau_, equations_, model_.length), counter_(model_, equations_, method_),
          doubling_(tableau_, equations_, projector_), control_(tableau_.error_order, model_.thresholds),
          t_(steps_.start), y_(Vector::Zero(equations_.total())), y_new_(y_), slope_(y_), copy_(y_), copy_slope_(y_),
          lambda_(model_.all_rows()), copy_lambda_(lambda_), counted_{{}, std::move(turns)} {
        std::copy(y.begin(), y.end(), y_.data());
    }
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
            else if (next_sample_ < inside_)
                sample_inside();
            else if (steps_.fixed())
                fixed_step();
            else
                controlled_step();
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
        watch(equations_.constraint(), equations_.C_dot(), t_);
        counted_ = counter_.start(counted_.turns, t_, y_);
        if (!evaluate(y_, true)) return stop_at(t_);
        method_.first() = slope_;
        h_ = steps_.step;
        if (!steps_.fixed()) {
            h_ = method_.first_step(t_, y_, steps_.tolerance, steps_.duration);
            ++counters.evaluations;
            next_sample_ = 1;
            if (h_ < 0.0) return stop_at(t_);
        }
        sample(t_, y_, slope_, lambda_, h_, counted_.turns);
    }

    // Steps of one size; the time of step k is t0 + k h, so that it does not drift. The last step may be shorter.
    void fixed_step() {
        const long k = counters.steps + 1;
        const bool last = k == steps_.count;
        const double t = last ? steps_.start + steps_.duration : steps_.start + static_cast<double>(k) * steps_.step;
        const double h = t - t_;
        phases_.begin(k);
        if (!method_.step(t_, y_, h, y_new_)) return stop_at(t);
        counters.evaluations += tableau_.stages() - 1;
        phases_.mark(Phase::evaluation);
        const bool due = k % steps_.every == 0 || last;
        if (!halve(t) || !accept(t, due)) return;
        take_over({t, h, due});
        if (last) stop({Status::finished, t_});
        phases_.mark(Phase::rest);
    }

    // Steps as large as the error estimate allows; outputs in between by the continuous extension.
    void controlled_step() {
        const double end = steps_.start + steps_.duration;
        if (h_ < 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t_), std::abs(end)))
            return stop(lost_.status == Status::running ? Outcome{Status::vanished, t_} : lost_);
        const double h = fitted(h_, end - t_);
        const double t = h == end - t_ ? end : t_ + h;
        phases_.begin(counters.steps + 1);
        equations_.forget_broken_state();
        const bool made = method_.step(t_, y_, h, y_new_) && method_.last(t, y_new_);
        counters.evaluations += tableau_.stages();
        const double error = made ? method_.error(y_, y_new_, h, steps_.tolerance) : not_a_number;
        phases_.mark(Phase::evaluation);
        lost_ = {};
        if (!std::isfinite(error)) lost_ = made ? Outcome{Status::not_finite, t} : failed_at(t);
        if (!(error <= 1.0)) return reject(control_.after_rejected(error, h));
        inside_ = next_sample_;
        while (inside_ < steps_.times.size() && steps_.times[inside_] < t) ++inside_;
        const bool due = inside_ < steps_.times.size() && steps_.times[inside_] == t;
        if (!halve(t) || (halved_ && !extend(h))) return;
        if (halved_ && shortened_ < model_.thresholds.most_shorter &&
            off(h) > model_.thresholds.agreed_tolerances * steps_.tolerance) {
            ++shortened_;
            return reject(model_.thresholds.shorter * h);
        }
        shortened_ = 0;
        counted_before_ = counted_;
        if (!accept(t, due) || (!halved_ && next_sample_ < inside_ && !extend(h))) return;
        reached_ = {t, h, due};
        h_ = control_.after_accepted(error, h);
        phases_.mark(Phase::rest);
        if (next_sample_ == inside_) finish_step();
    }

    void reject(double h) {
        ++counters.rejected_steps;
        equations_.pivots = {};
        inside_ = 0;
        h_ = h;
    }

    // The continuous extension: after the projection, which uses the last stage's factor; to be checked, before it.
    bool extend(double h) {
        counters.evaluations += static_cast<long>(tableau_.extra_c.size() + inside_ - next_sample_);
        const Aside aside(equations_);
        if (!method_.extend(t_, y_, h)) return stop_at(t_), false;
        return true;
    }

    // How far the step and its extension are from its halves.
    double off(double h) {
        method_.at(y_, h, 0.5, copy_);
        return std::max(doubling_.off(doubling_.end(), y_new_, h), doubling_.off(doubling_.middle(), copy_, h));
    }

    // One sample inside a step: the extension's value, of which a copy is projected; the integration does not see it.
    void sample_inside() {
        const double time = steps_.times[next_sample_++];
        method_.at(y_, reached_.h, (time - t_) / reached_.h, copy_);
        const Aside aside(equations_);
        counter_.lead(time, copy_);
        projector_.anywhere(time, copy_.data());
        if (!equations_.factor(Metric::mass)) return stop_at(time);
        equations_.set_velocities(copy_.data(), false);
        if (!equations_.slope_at(copy_.data(), copy_slope_.data(), copy_lambda_.data())) return stop_at(time);
        const auto turns = counter_.inside(counted_before_, t_, counted_, reached_.t, time, copy_);
        sample(time, copy_, copy_slope_, copy_lambda_, reached_.h, turns);
        if (next_sample_ == inside_) finish_step();
    }

    void finish_step() {
        take_over(reached_);
        if (reached_.due) ++next_sample_;
        inside_ = 0;
        if (next_sample_ == steps_.times.size()) stop({Status::finished, t_});
    }

    void take_over(const Reached& reached) {
        y_.swap(y_new_);
        method_.first().swap(slope_);
        t_ = reached.t;
        if (reached.due) sample(t_, y_, method_.first(), lambda_, reached.h, counted_.turns);
    }

    // Near a singular pose, the same step in two halves. False where these cannot be made.
    bool halve(double t) {
        halved_ = doubling_.is_near(equations_.pivots);
        if (halved_ && !doubling_.repeat(t_, y_, method_.first(), t - t_, counters.evaluations))
            return stop_at(t), false;
        return true;
    }

    // The state y_new after a step: projected, checked, counted, and its slope evaluated.
    bool accept(double t, bool with_multipliers) {
        if (!y_new_.allFinite()) return stop({Status::not_finite, t}), false;
        ++counters.steps;
        ++counters.evaluations;
        doubling_.accepted(equations_.pivots);
        equations_.pivots = {};
        counter_.lead(t, y_new_);
        const Projected done = projector_.after_step(counters.steps, t, y_new_.data());
        counters.projections += done.projections;
        counters.projection_iterations += done.position_passes;
        counters.velocity_iterations += done.velocity_passes;
        counters.projection_failures += done.failures;
        counters.projection_fallbacks += done.fallbacks;
        if (!done.regular) return stop_at(t), false;
        const bool jumps = done.velocity_change > model_.thresholds.branch_change &&
                           done.speed_change * (t - t_) > model_.thresholds.at_rest * model_.length;
        if (jumps && equations_.is_near_singular())
            return stop(Outcome::at_branch(Status::branch, t, done.velocity_change)), false;
        const double off = halved_ ? doubling_.off(doubling_.end(), y_new_, t - t_) : 0.0;
        if (off > model_.thresholds.agreement && equations_.is_near_singular())
            return stop(Outcome::at_branch(Status::unresolved, t, off)), false;
        const double* C = equations_.constraint();
        equations_.set_velocities(y_new_.data(), true);
        const int worst =
            model_.open_by_more(C, done.failures ? model_.thresholds.open_limit : model_.thresholds.lost_limit);
        if (const Slip slip =
                worst >= 0 ? counter_.far(counted_, t - t_) : counter_.advance(counted_, t_, y_, t, y_new_))
            return untold(slip, t), false;
        watch(C, equations_.C_dot(), t);
        if (worst >= 0 && done.near_singular) {
            stop_at(t);
            outcome.joint = model_.joint_of(worst);
            return false;
        }
        if (worst >= 0) {
            return stop(Outcome::left_open(t, worst, std::abs(C[worst]), done.position_passes, done.failures > 0)),
                   false;
        }
        if (!evaluate(y_new_, with_multipliers)) return stop_at(t), false;
        if (!slope_.allFinite()) return stop({Status::not_finite, t}), false;
        return true;
    }

    bool evaluate(const Vector& y, bool with_multipliers) {
        if (!equations_.factor_closed()) return false;
        equations_.pivots.watch(equations_.solver().nearness());
        return equations_.slope_at(y.data(), slope_.data(), with_multipliers ? lambda_.data() : nullptr);
    }

    void watch(const double* C, const double* C_dot, double t) {
        peaks.watch(C, C_dot, model_.constraints.rows, model_.driven.size(), t);
    }

    // A step to t that cannot tell turns is made again, shorter; one of fixed size ends the run.
    void untold(const Slip& slip, double t) {
        if (steps_.fixed()) return stop(Outcome::untold(slip, t, t - t_));
        --counters.steps;
        counted_ = counted_before_;
        reject(slip.shorter() * (t - t_));
    }

    void sample(double t, const Vector& y, const Vector& slope, const std::vector<double>& lambda, double h,
                const std::vector<long>& turns) {
        counters.factorisations = equations_.solver().factorisations();
        block.add<D>(t, y, slope, model_.size(), lambda, model_.constraints.rows, h, turns, counters,
                     model_.integrals());
    }

    void stop(const Outcome& reached) { outcome = reached; }
    void stop_at(double t) { stop(failed_at(t)); }

    // Why the equations have just had no solution.
    Outcome failed_at(double t) {
        if (!equations_.broken_state().empty()) return {Status::broken, equations_.time()};
        if (!equations_.finite()) return {Status::not_finite, t};
        Outcome found{Status::singular, t};
        found.joint = equations_.solver().singular_joint();
        return found;
    }

    const Model<D> model_;
    const Tableau tableau_;
    const ProjectionSettings projection_;
    const Steps steps_;
    Phases phases_;
    EquationsOfMotion<D> equations_;
    Projector<D> projector_;
    RungeKutta<D> method_;
    TurnCounter<D> counter_;
    StepDoubling<D> doubling_;
    StepSizeControl control_;
    double t_, h_ = 0.0;
    Vector y_, y_new_, slope_;  // slope_ at y_new_, until the step is taken over
    Vector copy_, copy_slope_;  // of a sample inside a step
    std::vector<double> lambda_, copy_lambda_;
    typename TurnCounter<D>::Counted counted_, counted_before_;
    Reached reached_{};
    Outcome lost_{};  // why the last step that was tried overflowed or had no solution; running where it did not
    std::size_t next_sample_ = 0, inside_ = 0;  // samples up to `inside_` lie in the step that was just accepted
    bool started_ = false, halved_ = false;
    int shortened_ = 0;  // times the step at hand, near a singular pose
};

}  // namespace mbproj
