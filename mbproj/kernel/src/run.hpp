// The time loop: step, project, check, record; with a fixed step, or with the step that the error allows.
#pragma once

#include "block.hpp"
#include "correction.hpp"
#include "flush_to_zero.hpp"
#include "runge_kutta.hpp"
#include "step_size.hpp"
#include "turn_counter.hpp"

namespace mbproj {

// Violations, in rad or in units of the system's length, that no run goes on with: after a failed projection, and ever.
constexpr double open_limit = 1e-6, lost_limit = 1.0;

template <int D> class Run {
public:
    using S = Size<D>;
    using Vector = Eigen::VectorXd;

    Run(Model<D> model, Tableau tableau, Projection projection, Steps steps, const std::vector<double>& y,
        std::vector<long> turns)
        : model_(std::move(model)), tableau_(std::move(tableau)), projection_(projection), steps_(std::move(steps)),
          dynamics_(model_, projection_), corrector_(dynamics_, projection_, phases_), counter_(model_),
          method_(tableau_, dynamics_, model_.length), control_(tableau_.error_order), t_(steps_.start),
          y_(Eigen::Map<const Vector>(y.data(), static_cast<Eigen::Index>(y.size()))), y_new_(y_), lambda_(model_.constraints.rows),
          counted_{{}, std::move(turns)} {}
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    // Runs on until there are `samples` more samples, `seconds` have passed, or the run ends.
    void advance(std::size_t samples, double seconds) {
        const FlushToZero flush;
        const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
        block.clear();
        const long look = std::max(1L, 64L / (1 + model_.size() / 8));  // steps between two looks at the clock
        for (long done = 0; outcome.status == Status::running && block.t.size() < samples; ++done) {
            if (done % look == look - 1 && std::chrono::steady_clock::now() > until) break;
            if (!started_) begin();
            else if (steps_.fixed()) fixed_step();
            else controlled_step();
        }
    }

    Block block;
    Counters counters;
    Peak position_peak, velocity_peak;
    Outcome outcome;

    const Model<D>& model() const { return model_; }
    const Phases& phases() const { return phases_; }
    Dynamics<D>& dynamics() { return dynamics_; }
    Corrector<D>& corrector() { return corrector_; }

private:
    void begin() {
        started_ = true;
        ++counters.evaluations;
        dynamics_.place(y_.data());
        dynamics_.move(y_.data(), true);
        watch(dynamics_.constraint(), dynamics_.C_dot());
        counted_ = counter_.start(dynamics_.pose(), dynamics_.motion(), counted_.turns);
        if (!evaluate(y_, true)) return stop_singular(t_);
        if (!steps_.fixed()) {
            const double slope_first = steps_.tolerance;
            sample(t_, y_, method_.first(), 0.0, counted_.turns);
            h_ = method_.first_step(y_, slope_first, steps_.duration);
            ++counters.evaluations;
            block.step_size.back() = h_;
            next_sample_ = 1;
            if (h_ < 0.0) return stop_singular(t_);
        } else {
            h_ = steps_.step;
            sample(t_, y_, method_.first(), h_, counted_.turns);
        }
    }

    // Steps of one size; the time of step k is t0 + k h, so that it does not drift. The last step may be shorter.
    void fixed_step() {
        const long k = counters.steps + 1;
        const double t = k == steps_.count ? steps_.start + steps_.duration : steps_.start + static_cast<double>(k) * steps_.step;
        const double h = t - t_;
        phases_.begin(k);
        if (!method_.step(y_, h, y_new_)) return stop_singular(t_);
        counters.evaluations += tableau_.stages() - 1;
        phases_.mark(Phase::evaluation);
        const bool due = k % steps_.every == 0 || k == steps_.count;
        if (!accept(t, due)) return;
        y_.swap(y_new_);
        t_ = t;
        if (due) sample(t_, y_, method_.first(), h, counted_.turns);
        if (k == steps_.count) stop({Status::finished, t_});
        phases_.mark(Phase::rest);
    }

    // Steps as large as the error estimate allows; outputs in between by the continuous extension.
    void controlled_step() {
        const double end = steps_.start + steps_.duration;
        if (h_ < 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t_), std::abs(end)))
            return stop({Status::vanished, t_});
        const double h = fitted(h_, end - t_);
        const double t = h == end - t_ ? end : t_ + h;
        phases_.begin(counters.steps + 1);
        if (!method_.step(y_, h, y_new_) || !method_.last(y_new_)) return stop_singular(t_);
        counters.evaluations += tableau_.stages();
        const double error = method_.error(y_, y_new_, h, steps_.tolerance);
        phases_.mark(Phase::evaluation);
        if (!(error <= 1.0)) {
            ++counters.rejected_steps;
            h_ = control_.after_rejected(error, h);
            return;
        }
        std::size_t upto = next_sample_;
        while (upto < steps_.times.size() && steps_.times[upto] < t) ++upto;
        if (upto > next_sample_ && !in_between(h, upto)) return;
        const bool due = upto < steps_.times.size() && steps_.times[upto] == t;
        if (!accept(t, due)) return;
        y_.swap(y_new_);
        t_ = t;
        next_sample_ = upto;
        if (due) {
            sample(t_, y_, method_.first(), h, counted_.turns);
            ++next_sample_;
        }
        if (next_sample_ == steps_.times.size()) return stop({Status::finished, t_});
        h_ = control_.after_accepted(error, h);
        phases_.mark(Phase::rest);
    }

    // Samples inside a step: the extension's value, of which a copy is projected; the integration does not see it.
    bool in_between(double h, std::size_t upto) {
        if (!method_.extend(y_, h)) return stop_singular(t_), false;
        counters.evaluations += static_cast<long>(tableau_.extra_c.size() + upto - next_sample_);
        Vector copy(y_.size()), slope(y_.size());
        for (std::size_t s = next_sample_; s < upto; ++s) {
            const double time = steps_.times[s];
            method_.at(y_, h, (time - t_) / h, copy);
            corrector_.anywhere(copy.data());
            if (!dynamics_.factor(Metric::mass)) return stop_singular(time), false;
            dynamics_.move(copy.data(), false);
            dynamics_.slope_at(copy.data(), slope.data(), lambda_.data());
            Counted counted = counted_;
            counter_.advance(counted, dynamics_.pose(), dynamics_.motion(), time - t_);
            sample(time, copy, slope, h, counted.turns);
        }
        return true;
    }

    // The state y_new after a step: projected, checked, counted, and its slope evaluated.
    bool accept(double t, bool with_multipliers) {
        if (!y_new_.allFinite()) return stop({Status::not_finite, t}), false;
        ++counters.steps;
        ++counters.evaluations;
        const Corrected done = corrector_.after_step(counters.steps, y_new_.data());
        counters.projections += done.projections;
        counters.projection_iterations += done.position_passes;
        counters.velocity_iterations += done.velocity_passes;
        counters.projection_failures += done.failures;
        if (!done.regular) return stop_singular(t), false;
        const double previous = t_;
        t_ = t;
        const double* C = dynamics_.constraint();
        dynamics_.move(y_new_.data(), true);
        watch(C, dynamics_.C_dot());
        t_ = previous;
        const double limit = done.failures ? open_limit : lost_limit;
        int worst = -1;
        double most = limit;
        for (int r = 0; r < model_.constraints.rows; ++r)
            if (const double part = std::abs(C[r]) / model_.row_scale[r]; !(part <= most)) {
                most = part;
                worst = r;
            }
        if (worst >= 0) {
            Outcome open{Status::open, t};
            open.row = worst;
            open.open_by = std::abs(C[worst]);
            open.passes = done.position_passes;
            open.projection_failed = done.failures > 0;
            return stop(open), false;
        }
        counter_.advance(counted_, dynamics_.pose(), dynamics_.motion(), t - t_);
        if (!evaluate(y_new_, with_multipliers)) return stop_singular(t), false;
        counters.factorisations = dynamics_.bordered().factorisations();
        return true;
    }

    bool evaluate(const Vector& y, bool with_multipliers) {
        if (!dynamics_.factor(Metric::mass)) return false;
        dynamics_.slope_at(y.data(), method_.first().data(), with_multipliers ? lambda_.data() : nullptr);
        return true;
    }

    void watch(const double* C, const double* C_dot) {
        position_peak.watch(C, model_.constraints.rows, t_);
        velocity_peak.watch(C_dot, model_.constraints.rows, t_);
    }

    void sample(double t, const Vector& y, const Vector& slope, double h, const std::vector<long>& turns) {
        block.t.push_back(t);
        block.y.insert(block.y.end(), y.data(), y.data() + y.size());
        for (int b = 0; b < model_.size(); ++b) {
            const double* a = slope.data() + S::state * b + S::pose;
            block.acceleration.insert(block.acceleration.end(), a, a + S::freedoms);
        }
        block.multipliers.insert(block.multipliers.end(), lambda_.begin(), lambda_.end());
        block.step_size.push_back(h);
        block.turns.insert(block.turns.end(), turns.begin(), turns.end());
        const auto counts = counters.list();
        block.counters.insert(block.counters.end(), counts.begin(), counts.end());
    }

    void stop(const Outcome& reached) { outcome = reached; }
    void stop_singular(double t) {
        outcome = {Status::singular, t};
        outcome.joint = dynamics_.bordered().singular_joint();
    }

    const Model<D> model_;
    const Tableau tableau_;
    const Projection projection_;
    const Steps steps_;
    Phases phases_;
    Dynamics<D> dynamics_;
    Corrector<D> corrector_;
    TurnCounter<D> counter_;
    RungeKutta<D> method_;
    Controller control_;
    double t_, h_ = 0.0;
    Vector y_, y_new_;
    std::vector<double> lambda_;
    Counted counted_;
    std::size_t next_sample_ = 0;
    bool started_ = false;
};

}  // namespace mbproj
