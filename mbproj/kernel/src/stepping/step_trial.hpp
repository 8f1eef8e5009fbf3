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
              StepEnd& step_end, Schedule& schedule, Phases& phases)
        : steps_(steps), thresholds_(equations.mechanism().thresholds), now_(now), equations_(equations),
          stepper_(stepper), step_end_(step_end), schedule_(schedule), phases_(phases),
          doubling_(stepper, equations, projector), control_(stepper.error_order(), thresholds_),
          events_(equations, steps.fixed()), locates_(events_.any()), copy_(now.y) {
        if (locates_) events_.hold();
    }

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
    void resume(const StepSizeControl::Saved& control, int shortened, const std::vector<Halved>& halved) {
        control_.resume(control);
        halvings_.resume(halved);
        shortened_ = shortened;
    }

    // A step to `now.to`, or nearer. False where the run stops, or where the step is to be tried again; also where a switch
    // changes its branch at its very start: `crossing` is set then.
    bool make() { return attempt() && (!locates_ || end_at_crossing()) && agrees_with_halves(); }

    // The step to `now.to` once more, where it is known to end there. False where it is to be tried again.
    bool again() { return halved_ = false, attempt(); }
    // The stages of a step alone, with the rows that are held; false also where others would serve.
    bool stages() {
        equations_.begin_step();
        if (equations_.other()) equations_.other()->begin_step();
        const bool made = stepper_.attempt(now_.t, now_.y, now_.to.h, now_.y_new);
        now_.counters.evaluations += stepper_.attempt_cost();
        return made;
    }

    // The norm of the error of its stages; nothing where they fail.
    std::optional<double> stages_and_error() {
        now_.counters.evaluations += stepper_.error_cost();
        if (!stages()) return std::nullopt;
        return stepper_.error(now_.to.t, now_.y, now_.y_new, now_.to.h, steps_.tolerance, control_.is_again());
    }

    // Rejects the step that was made: the next one is tried with size h.
    void reject(double h) {
        if (schedule_.follows()) now_.outcome = {Status::vanished, now_.t};  // that run has no shorter step
        ++now_.counters.rejected_steps;
        schedule_.leave();
        crossing_.reset();
        now_.h = h;
    }

    // Sets the continuous extension: for samples after the projection, which uses the last factor; for events before.
    bool extend() {
        if (extended_) return true;
        now_.counters.evaluations += stepper_.extend_cost();
        if (!stepper_.extend(now_.t, now_.y, now_.to.h)) return stop_at(now_.t), false;
        return extended_ = true;
    }

private:
    // A step from y to y_new, by the stepper alone.
    bool attempt() {
        extended_ = false;
        if (steps_.fixed()) {
            const bool made = stages() || (equations_.hold_others() && stages());
            phases_.mark(Phase::evaluation);
            if (made && !passes_branch()) return true;
            crossing_.reset();
            if (!made) halve();
            return false;
        }
        equations_.forget_broken_state();
        std::optional<double> error = stages_and_error();
        if (!error && equations_.hold_others()) error = stages_and_error();
        phases_.mark(Phase::evaluation);
        lost_ = {};
        if (!error || !std::isfinite(*error))
            lost_ = error ? Outcome{Status::not_finite, now_.to.t} : failed_at(now_.to.t);
        error_ = error.value_or(not_a_number);
        const bool passes = schedule_.follows() ? std::isfinite(error_) : error_ <= 1.0;
        if (!passes) return reject(control_.after_rejected(error_, now_.to.h)), false;
        return true;
    }

    // Whether a fixed step is to be made in halves: it passes a singular pose, so that stages have left rows out. Only
    // one half has such an error, of the third power of its size. A step that ends beyond the reach of its joints
    // passes none.
    bool passes_branch() {
        if (!doubling_.is_near() || equations_.passed().smallest > 0.0) return false;
        equations_.set_pose(now_.to.t, now_.y_new.data());
        if (equations_.mechanism().open_by_more(equations_.constraint(), thresholds_.lost_limit) >= 0 ||
            !schedule_.halve(now_.t, now_.to.h, thresholds_.branch_halvings))
            return false;
        ++now_.counters.rejected_steps;
        return true;
    }

    // A fixed step whose equations were not solved is tried again in halves.
    void halve() {
        const auto unsolved = stepper_.unsolved();
        if (!unsolved || !schedule_.halve(now_.t, now_.to.h, thresholds_.most_halvings)) return stop_at(now_.to.t);
        halvings_.note(*unsolved, now_.t);
        ++now_.counters.rejected_steps;
        equations_.forget_broken_state();
    }

    // Where a switch changes its branch within the step that was tried, the step is made again, so that it ends there:
    // first where its extension shows the crossing, then by Newton's method on the ends of the steps themselves.
    bool end_at_crossing() {
        const bool cubic = steps_.fixed() && !stepper_.carries_slope();
        if (!(cubic ? set_end_slope() : extend())) return false;
        const Target whole = now_.to;
        const double h = whole.h, end = whole.t, tolerance = steps_.fixed() ? 0.0 : steps_.tolerance;
        const double slack = events_.slack(h, tolerance, schedule_.grain(end));
        const CubicStep step{h, now_.y, stepper_.first(), now_.y_new, slope_};
        const auto state_at = [&](double theta, Eigen::VectorXd& found) {
            cubic ? step.at(theta, found) : stepper_.at(now_.y, h, theta, found);
        };
        crossing_ = events_.first(state_at, now_.t, h, schedule_.window(), slack, schedule_.grain(end));
        if (!crossing_) return true;
        if (crossing_->at_once) return false;
        const Crossing found = *crossing_;
        const double rate = found.rate / h;
        double t = now_.t + found.theta * h;
        for (int tried = 0; end - t > slack && tried < thresholds_.most_polishing; ++tried) {
            now_.to = schedule_.to(now_.t, t);
            now_.to.shaped = whole.shaped;
            if (!attempt()) return false;
            const double excess = events_.excess(found.leader, t, now_.y_new, schedule_.window());
            if (!(std::abs(excess) > rate * slack) || !(std::abs(excess) < thresholds_.widest_polishing * rate * h))
                break;
            t = std::min(t - excess / rate, end);
        }
        return true;
    }

    // Near a singular pose, the same step in two halves. False where these cannot be made, or where they are so far off
    // that the step is to be tried again.
    bool agrees_with_halves() {
        halved_ = doubling_.is_near();
        if (halved_) {
            if (!halves_made() && !(equations_.hold_others() && halves_made())) return stop_at(now_.to.t), false;
            if (!steps_.fixed() && !schedule_.follows()) {
                if (!extend()) return false;
                if (shortened_ < thresholds_.most_shorter && off() > thresholds_.agreed_tolerances * steps_.tolerance)
                    return ++shortened_, reject(thresholds_.shorter * now_.to.h), false;
            }
        }
        shortened_ = 0;
        return true;
    }

    // The slope at the end of a step whose error is not estimated: the cubic through both ends shows where events are.
    bool set_end_slope() {
        ++now_.counters.evaluations;
        slope_.resize(now_.y_new.size());
        if (!equations_.derivative(now_.to.t, now_.y_new.data(), slope_.data())) return stop_at(now_.to.t), false;
        return true;
    }

    bool halves_made() {
        const double h = now_.to.t - now_.t;
        return doubling_.repeat(now_.t, now_.y, stepper_.first(), h, now_.counters.evaluations);
    }

    // How far the step and its extension are from its halves.
    double off() {
        stepper_.at(now_.y, now_.to.h, 0.5, copy_);
        return std::max(equations_.distance(doubling_.end(), now_.y_new, now_.to.h),
                        equations_.distance(doubling_.middle(), copy_, now_.to.h));
    }

    // Why a step could not be made.
    Outcome failed_at(double t) {
        const auto unsolved = stepper_.unsolved();
        if (!unsolved) return step_end_.failed_at(t);
        const bool near = equations_.passed().smallest < thresholds_.near_branch || equations_.is_near_singular();
        return Outcome::unsolved(t, unsolved->body, unsolved->force, near);
    }
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
