#include "stepping/step_trial.hpp"

namespace mbproj {

StepTrial::StepTrial(const Steps& steps, Standing& now, Equations& equations, Projector& projector, Stepper& stepper,
                     StepEnd& step_end, Schedule& schedule, Phases& phases)
    : steps_(steps), thresholds_(equations.mechanism().thresholds), now_(now), equations_(equations), stepper_(stepper),
      step_end_(step_end), schedule_(schedule), phases_(phases), doubling_(stepper, equations, projector),
      control_(stepper.error_order(), thresholds_), events_(equations, steps.fixed()), locates_(events_.any()),
      copy_(now.y) {
    if (locates_) events_.hold();
}

void StepTrial::resume(const StepSizeControl::Saved& control, int shortened, const std::vector<Halved>& halved) {
    control_.resume(control);
    halvings_.resume(halved);
    shortened_ = shortened;
}

bool StepTrial::stages() {
    equations_.begin_step();
    if (equations_.other()) equations_.other()->begin_step();
    const bool made = stepper_.attempt(now_.t, now_.y, now_.to.h, now_.y_new);
    now_.counters.evaluations += stepper_.attempt_cost();
    return made;
}

std::optional<double> StepTrial::stages_and_error() {
    now_.counters.evaluations += stepper_.error_cost();
    if (!stages()) return std::nullopt;
    return stepper_.error(now_.to.t, now_.y, now_.y_new, now_.to.h, steps_.tolerance, control_.is_again());
}

void StepTrial::reject(double h) {
    if (schedule_.follows()) now_.outcome = {Status::vanished, now_.t};  // that run has no shorter step
    ++now_.counters.rejected_steps;
    schedule_.leave();
    crossing_.reset();
    now_.h = h;
}

bool StepTrial::extend() {
    if (extended_) return true;
    now_.counters.evaluations += stepper_.extend_cost();
    if (!stepper_.extend(now_.t, now_.y, now_.to.h)) return stop_at(now_.t), false;
    return extended_ = true;
}

bool StepTrial::attempt() {
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
    if (!error || !std::isfinite(*error)) lost_ = error ? Outcome{Status::not_finite, now_.to.t} : failed_at(now_.to.t);
    error_ = error.value_or(not_a_number);
    const bool passes = schedule_.follows() ? std::isfinite(error_) : error_ <= 1.0;
    if (!passes) return reject(control_.after_rejected(error_, now_.to.h)), false;
    return true;
}

bool StepTrial::passes_branch() {
    if (!doubling_.is_near() || equations_.passed().smallest > 0.0) return false;
    equations_.set_pose(now_.to.t, now_.y_new.data());
    if (equations_.mechanism().open_by_more(equations_.constraint(), thresholds_.lost_limit) >= 0 ||
        !schedule_.halve(now_.t, now_.to.h, thresholds_.branch_halvings))
        return false;
    ++now_.counters.rejected_steps;
    return true;
}

void StepTrial::halve() {
    const auto unsolved = stepper_.unsolved();
    if (!unsolved || !schedule_.halve(now_.t, now_.to.h, thresholds_.most_halvings)) return stop_at(now_.to.t);
    halvings_.note(*unsolved, now_.t);
    ++now_.counters.rejected_steps;
    equations_.forget_broken_state();
}

bool StepTrial::end_at_crossing() {
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
        if (!(std::abs(excess) > rate * slack) || !(std::abs(excess) < thresholds_.widest_polishing * rate * h)) break;
        t = std::min(t - excess / rate, end);
    }
    return true;
}

bool StepTrial::agrees_with_halves() {
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

bool StepTrial::set_end_slope() {
    ++now_.counters.evaluations;
    slope_.resize(now_.y_new.size());
    if (!equations_.derivative(now_.to.t, now_.y_new.data(), slope_.data())) return stop_at(now_.to.t), false;
    return true;
}

bool StepTrial::halves_made() {
    const double h = now_.to.t - now_.t;
    return doubling_.repeat(now_.t, now_.y, stepper_.first(), h, now_.counters.evaluations);
}

double StepTrial::off() {
    stepper_.at(now_.y, now_.to.h, 0.5, copy_);
    return std::max(equations_.distance(doubling_.end(), now_.y_new, now_.to.h),
                    equations_.distance(doubling_.middle(), copy_, now_.to.h));
}

Outcome StepTrial::failed_at(double t) {
    const auto unsolved = stepper_.unsolved();
    if (!unsolved) return step_end_.failed_at(t);
    const bool near = equations_.passed().smallest < thresholds_.near_branch || equations_.is_near_singular();
    return Outcome::unsolved(t, unsolved->body, unsolved->force, near);
}

}  // namespace mbproj
