#include "stepping/stop_events.hpp"

namespace mbproj {

StopEvents::StopEvents(const Steps& steps, Standing& now, Equations& equations, Stepper& stepper, StepEnd& step_end,
                       Schedule& schedule, StepTrial& trial)
    : steps_(steps), now_(now), equations_(equations), stepper_(stepper), step_end_(step_end), schedule_(schedule),
      trial_(trial), watch_(equations), policy_(equations), slope_(now.y), inside_(now.y),
      lambda_(equations.mechanism().all_multipliers()) {}

bool StopEvents::begin(std::vector<StopLaw> laws, std::vector<FrictionLaw> frictions, ImpactLaw impacts,
                       ContactState state, double spacing, LoadedJoints joints_in_space) {
    spacing_ = spacing;
    if (!policy_.begin(std::move(laws), std::move(frictions), impacts, std::move(state), std::move(joints_in_space)))
        return false;
    policy_.watch(watch_, spacing_);
    return true;
}

void StopEvents::resume(const ContactState& state) {
    policy_.resume(state);
    policy_.watch(watch_, spacing_);
}

bool StopEvents::loses_contacts(const Outcome& outcome) {
    const bool lost = outcome.status == Status::singular || outcome.status == Status::vanished;
    return lost && inside() && equations_.contacts().any() && !equations_.contacts().cholesky().full();
}

bool StopEvents::meets(const Vector& slope, const std::vector<long>& turns, const std::vector<double>& lambda) {
    const CubicStep step{now_.to.h, now_.y, stepper_.first(), now_.y_new, slope};
    equations_.variables_at(now_.to.t, now_.y_new.data());
    const bool at_end = watch_.met(step, turns, lambda);
    rests_ = watch_.rests(now_.to.h);
    const auto solve = [&](double x, std::vector<double>& found) { return solve_inside(step, x, found); };
    if (!watch_.gives_way_inside(now_.to.h, solve) && !at_end && rests_ < 0) return watch_.pass(), false;
    if (halts()) return true;
    lambda_ = lambda;
    return last_known_ = margins(now_.to.t, now_.y_new, turns, last_), true;
}

StopEvents::Found StopEvents::locate(const Counted& counted, const Vector& slope) {
    const Target whole = now_.to;
    if (!last_known_) return Found::none;
    const CubicStep step{whole.h, now_.y, stepper_.first(), now_.y_new, slope};
    const double grain = 4.0 * schedule_.grain(now_.t);
    MeetingSearch search(watch_.slacks());
    MeetingSearch::Margins first = watch_.first_margins();
    Meeting expected;
    if (rests_ < 0 && !watch_.rows().empty()) {  // a look within the step is cheaper than a step to there
        const auto along = [&](double h, MeetingSearch::Margins& found) {
            if (!solve_inside(step, h / whole.h, lambda_)) return false;
            return watch_.margins(counted.turns, lambda_, found), true;
        };
        if (!along(0.0, first)) return Found::none;
        expected = search.first(along, first, last_, watch_.parts(), whole.h,
                                equations_.mechanism().thresholds.same_written * whole.h);
    }
    if (!back(counted)) return Found::none;
    policy_.record_speed(now_.y);
    if (rests_ >= 0) return stop_ = rests_, released_ = false, meeting_ = true, Found::at_once;
    const auto at = [&](double h, MeetingSearch::Margins& found) { return reach(h, counted, found); };
    const Meeting met = search.first(at, first, last_, watch_.parts(), whole.h, grain, expected);
    if (!met.made || !back(counted)) return Found::none;
    now_.to = whole;
    if (met.which < 0) return Found::nothing;
    const auto gaps = static_cast<int>(watch_.gaps().size());
    const bool is_force = met.which >= gaps;
    released_ = is_force || watch_.gaps()[met.which].begins;
    stop_ = is_force ? watch_.rows()[met.which - gaps].row - equations_.mechanism().all_rows()
                     : watch_.gaps()[met.which].stop;
    meeting_ = true;
    trial_.crossing().reset();
    if (met.h < 4.0 * grain) return Found::at_once;
    const bool ends_there =
        whole.h - met.h <= (steps_.fixed() ? equations_.mechanism().thresholds.on_grid * steps_.step : 0.0);
    if (!ends_there) now_.to = schedule_.to(now_.t, now_.t + met.h);
    if (!ends_there) now_.to.shaped = whole.shaped;
    return Found::ahead;
}

bool StopEvents::start(const std::vector<long>& turns) {
    if (!meet(turns, -1, false)) return false;
    equations_.set_pose(now_.t, now_.y.data());
    equations_.set_velocities(now_.y.data(), true);
    return true;
}

void StopEvents::shorten(const Vector& slope) {
    if (!inside() || policy_.state().sliding.empty()) return;
    if (const double h = watch_.longest(now_.y, slope, now_.to.h); h < now_.to.h)
        now_.to = schedule_.to(now_.t, now_.t + h);
}

bool StopEvents::meet(const std::vector<long>& turns) {
    meeting_ = false;
    return meet(turns, stop_, released_);
}

void StopEvents::set_start(double t, const Vector& y, const std::vector<long>& turns) {
    equations_.set_pose(t, y.data());
    equations_.set_velocities(y.data(), false);
    watch_.begin(turns);
}

void StopEvents::record(SampleBlock& block, const std::vector<double>& lambda) {
    const ContactState& state = policy_.state();
    const double* y = block.y.data() + block.y.size() - now_.y.size();
    const std::vector<double> forces = policy_.forces(block.t.back(), y, lambda);
    block.pushes.insert(block.pushes.end(), forces.begin(), forces.end());
    const std::vector<double> slides = policy_.slides(forces);
    block.slides.insert(block.slides.end(), slides.begin(), slides.end());
    block.jumps.push_back(state.work);
    block.jumps.push_back(state.lost);
    for (std::size_t k = 0; k + policy_.stops() < forces.size(); ++k)
        block.jumps.push_back(k < state.rubbed.size() ? state.rubbed[k] : 0.0);
}

bool StopEvents::meet(const std::vector<long>& turns, int stop, bool released) {
    if (!policy_.meet(now_.t, now_.y, turns, stop, released, steps_.interval())) return false;
    policy_.watch(watch_, spacing_);
    return true;
}

bool StopEvents::back(const Counted&) {
    equations_.set_pose(now_.t, now_.y.data());
    return equations_.start();
}

bool StopEvents::reach(double h, const Counted& counted, MeetingSearch::Margins& found) {
    now_.to = schedule_.to(now_.t, now_.t + h);
    if (!trial_.stages() && !(equations_.hold_others() && trial_.stages())) return false;
    Counted there = counted;
    Counters counters = now_.counters;
    ++counters.steps;
    Peaks peaks;
    const bool stops = step_end_.close(now_.t, now_.y, now_.to.t, now_.y_new, there, nullptr, counters, peaks).stops();
    step_end_.take_back();
    if (stops) return false;
    if (stepper_.carries_slope()) stepper_.arrive(now_.y_new, slope_, lambda_.data());
    return margins(now_.to.t, now_.y_new, there.turns, found);
}

bool StopEvents::solve_inside(const CubicStep& step, double x, std::vector<double>& lambda) {
    const double t = now_.t + x * step.h;
    bool solved = false;
    if (stepper_.carries_slope()) {
        stepper_.at(now_.y, step.h, x, inside_);
        solved = stepper_.inside(t, step.h, x, inside_, slope_, lambda.data());
    } else {
        step.at(x, inside_);
        solved = equations_.own_derivative(t, inside_.data(), slope_.data(), lambda.data());
    }
    if (solved) equations_.variables_at(t, inside_.data());
    return solved;
}

bool StopEvents::margins(double t, const Vector& y, const std::vector<long>& turns, MeetingSearch::Margins& found) {
    if (watch_.rows().empty() || stepper_.carries_slope()) {
        equations_.set_pose(t, y.data());
        equations_.set_velocities(y.data(), false);
    } else if (!equations_.own_derivative(t, y.data(), slope_.data(), lambda_.data())) {
        return false;
    }
    equations_.variables_at(t, y.data());
    watch_.margins(turns, lambda_, found);
    return true;
}

}  // namespace mbproj
