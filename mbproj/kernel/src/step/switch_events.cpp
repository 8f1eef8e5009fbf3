#include "step/step.hpp"

namespace mbproj {

SwitchEvents::SwitchEvents(Equations& equations, Branches& state, bool fixed)
    : model_(equations.mechanism()), equations_(equations), thresholds_(model_.thresholds), fixed_(fixed),
      count_(model_.switches.size()), state_(state), search_(thresholds_), x_(count_), before_(count_), after_(count_) {
    if (count_ == 0) return;
    const double never = -std::numeric_limits<double>::infinity();
    const std::vector<double> zeros(count_, 0.0), free(count_, free_branch), last(count_, never);
    const std::vector<double> held(equations.programs().op.size(), free_branch);
    state_ = {held, last, std::vector<int>(count_), std::vector<int>(count_), zeros, std::vector<long>(count_), free};
    glanced_ = Vector::Zero(equations.layout().size());
    hold();
}

bool SwitchEvents::fits(const Branches& saved) const {
    return saved.held.size() == state_.held.size() && saved.last.size() == count_ && saved.at_once.size() == count_ &&
           saved.in_a_row.size() == count_ && saved.first.size() == count_ && saved.times.size() == count_ &&
           saved.told.size() == count_;
}

double SwitchEvents::excess(std::size_t k, double t, const Vector& y, const TimeWindow& window) {
    arguments_at(t, y, window, x_);
    return bounds()[k].excess(x_[k]);
}

int SwitchEvents::cross(const Crossing& crossing, double t, double grain, double duration) {
    for (std::size_t k = 0; k < count_; ++k) {
        if (!crossing.leaving[k]) continue;
        state_.at_once[k] = t - state_.last[k] <= 4.0 * grain ? state_.at_once[k] + 1 : 1;
        state_.in_a_row[k] = t - state_.last[k] <= thresholds_.chatter * duration ? state_.in_a_row[k] + 1 : 1;
        state_.last[k] = t;
        if (state_.at_once[k] >= most_at_once || state_.in_a_row[k] >= thresholds_.most_chatter) {
            if (!gives_up(static_cast<int>(k), t)) return static_cast<int>(k);
            continue;
        }
        met_.emplace_back(t, static_cast<int>(k), crossing.leaving[k]);
        held(k) = branch_beyond(equations_.programs(), model_.switches[k].at, held(k), crossing.leaving[k]);
    }
    direction_ = crossing.leaving;
    for (std::size_t k = 0; k < count_; ++k)
        if (!located(k)) direction_[k] = 0;
    return -1;
}

bool SwitchEvents::gives_up(int k, double t) {
    if (!fixed_) return false;
    held(k) = free_branch;
    state_.first[k] = t, state_.times[k] = 1;
    if (!direction_.empty()) direction_[k] = 0;
    return true;
}

void SwitchEvents::after_jump(double t, const Vector& y, const TimeWindow& window) {
    arguments_at(t, y, window, x_);
    const std::vector<Interval>& held_in = bounds();
    for (std::size_t k = 0; k < count_; ++k)
        if ((held_in[k].excess(x_[k]) > 0.0 && x_[k] != before_[k]) || lets_go(k)) held(k) = free_branch;
    settle();
}

void SwitchEvents::set_free_signs(double t, const Vector& y, const TimeWindow& window) {
    if (!any_free()) return;
    arguments_at(t, y, window, x_);
    settle();
}

bool SwitchEvents::any_free() const {
    for (std::size_t k = 0; k < count_; ++k)
        if (located(k) && !lets_go(k) && std::isnan(state_.held[model_.switches[k].at])) return true;
    return false;
}

void SwitchEvents::turn() {
    direction_.assign(count_, 0);
    for (std::size_t k = 0; k < count_; ++k) {
        if (!located(k) || !std::isnan(held(k)) || before_[k] == 0.0 || std::isnan(before_[k])) continue;
        direction_[k] = before_[k] > 0.0 ? 1 : -1;
        held(k) = direction_[k];
    }
}

int SwitchEvents::pushed_back() const {
    for (std::size_t k = 0; k < count_; ++k)
        if (direction_[k] * before_[k] > 0.0 && direction_[k] * after_[k] < 0.0) return static_cast<int>(k);
    return -1;
}

bool SwitchEvents::passes_over_back(double t) {
    const int back = pushed_back();
    return back >= 0 && gives_up(back, t);
}

void SwitchEvents::watch(double t, const Vector& y, const TimeWindow& window) {
    arguments_here(t, y, window, nullptr, x_);
    for (std::size_t k = 0; k < count_; ++k) {
        if (located(k)) continue;
        const double now = natural_branch(equations_.programs(), model_.switches[k].at, x_[k]);
        if (std::isnan(now)) continue;
        if (!std::isnan(state_.told[k]) && now != state_.told[k]) ++state_.times[k];
        state_.told[k] = now;
    }
}

std::vector<SwitchEvents::Passed> SwitchEvents::passed() const {
    std::vector<Passed> found;
    for (std::size_t k = 0; k < count_; ++k)
        if (state_.times[k]) found.emplace_back(static_cast<int>(k), state_.first[k], state_.times[k]);
    return found;
}

std::vector<SwitchEvents::Met> SwitchEvents::take_met() {
    std::vector<Met> found;
    found.swap(met_);
    return found;
}

const std::vector<Interval>& SwitchEvents::bounds() {
    bounds_.clear();
    for (const Switch& each : model_.switches)
        bounds_.push_back(interval(equations_.programs(), each.at, state_.held[each.at]));
    return bounds_;
}

void SwitchEvents::settle() {
    for (std::size_t k = 0; k < count_; ++k)
        if (located(k) && std::isnan(held(k)))
            held(k) = natural_branch(equations_.programs(), model_.switches[k].at, x_[k]);
}

void SwitchEvents::glance(double t, const Vector& y, const Vector& slope, double h, const TimeWindow& window,
                          std::vector<double>& moves) {
    arguments_at(t, y, window, x_);
    glanced_ = y + thresholds_.beside * h * slope;
    arguments_at(t, glanced_, window, moves);
    for (std::size_t k = 0; k < count_; ++k) moves[k] -= x_[k];
}

void SwitchEvents::arguments_at(double t, const Vector& y, const TimeWindow& window, std::vector<double>& x) {
    equations_.set_pose(t, y.data());
    equations_.set_velocities(y.data(), false);
    arguments_here(t, y, window, state_.held.data(), x);
}

void SwitchEvents::arguments_here(double t, const Vector& y, const TimeWindow& window, const double* branches,
                                  std::vector<double>& x) const {
    equations_.switch_arguments(window.clamped(t), y.data(), branches, x);
}

bool cut_at_switch(Run& run) {
    if (!run.locates()) return true;
    // Without an estimate of the error there is no extension: the cubic through both ends shows where events are.
    const bool cubic = run.steps.fixed() && !run.stepper.carries_slope();
    if (cubic) {
        ++run.state.counters.evaluations;
        if (!run.equations.derivative(run.to.t, run.next.y.data(), run.next.slope.data()))
            return stop_unsolved(run, run.to.t), false;
    } else if (!extend(run)) {
        return false;
    }
    const Target whole = run.to;
    const double h = whole.h, end = whole.t, start = run.now.t,
                 tolerance = run.steps.fixed() ? 0.0 : run.steps.tolerance;
    const double slack = run.switches.slack(h, tolerance, run.schedule.grain(end));
    const CubicStep step{h, run.now.y, run.now.slope, run.next.y, run.next.slope};
    const auto state_at = [&](double theta, Eigen::VectorXd& found) {
        cubic ? step.at(theta, found) : run.stepper.at(run.now.y, h, theta, found);
    };
    run.crossing = run.switches.first(state_at, start, h, run.window(), slack, run.schedule.grain(end));
    if (!run.crossing) return true;
    if (run.crossing->at_once) {
        if (cross_switch(run)) choose_step_anew(run);
        return false;
    }
    const Crossing found = *run.crossing;
    const double rate = found.rate / h;
    double t = start + found.theta * h;
    for (int tried = 0; end - t > slack && tried < run.thresholds.most_polishing; ++tried) {
        run.to = run.schedule.to(start, t);
        run.to.shaped = whole.shaped;
        if (!attempt(run)) return false;
        const double excess = run.switches.excess(found.leader, t, run.next.y, run.window());
        if (!(std::abs(excess) > rate * slack) || !(std::abs(excess) < run.thresholds.widest_polishing * rate * h))
            break;
        t = std::min(t - excess / rate, end);
    }
    return true;
}

}  // namespace mbproj
