#include "stepping/state_events.hpp"

namespace mbproj {

StateEvents::StateEvents(Equations& equations, bool fixed)
    : model_(equations.mechanism()), equations_(equations), thresholds_(model_.thresholds), fixed_(fixed),
      count_(model_.switches.size()), search_(thresholds_), x_(count_), before_(count_), after_(count_) {
    if (count_ == 0) return;
    const double never = -std::numeric_limits<double>::infinity();
    const std::vector<double> zeros(count_, 0.0), free(count_, free_branch), last(count_, never);
    const std::vector<double> held(equations.programs().op.size(), free_branch);
    state_ = {held, last, std::vector<int>(count_), std::vector<int>(count_), zeros, std::vector<long>(count_), free};
    glanced_ = Vector::Zero(equations.layout().size());
}

bool StateEvents::resume(const SavedEvents& saved) {
    const bool fits = saved.held.size() == state_.held.size() && saved.last.size() == count_ &&
                      saved.at_once.size() == count_ && saved.in_a_row.size() == count_ &&
                      saved.first.size() == count_ && saved.times.size() == count_ && saved.told.size() == count_;
    if (fits) state_ = saved;
    return fits;
}

double StateEvents::excess(std::size_t k, double t, const Vector& y, const TimeWindow& window) {
    arguments_at(t, y, window, x_);
    return bounds()[k].excess(x_[k]);
}

int StateEvents::cross(const Crossing& crossing, double t, double grain, double duration) {
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

bool StateEvents::gives_up(int k, double t) {
    if (!fixed_) return false;
    held(k) = free_branch;
    state_.first[k] = t, state_.times[k] = 1;
    if (!direction_.empty()) direction_[k] = 0;
    return true;
}

void StateEvents::after_jump(double t, const Vector& y, const TimeWindow& window) {
    arguments_at(t, y, window, x_);
    const std::vector<Interval>& held_in = bounds();
    for (std::size_t k = 0; k < count_; ++k)
        if ((held_in[k].excess(x_[k]) > 0.0 && x_[k] != before_[k]) || lets_go(k)) held(k) = free_branch;
    settle();
}

void StateEvents::set_free_signs(double t, const Vector& y, const TimeWindow& window) {
    if (!any_free()) return;
    arguments_at(t, y, window, x_);
    settle();
}

bool StateEvents::any_free() const {
    for (std::size_t k = 0; k < count_; ++k)
        if (located(k) && !lets_go(k) && std::isnan(state_.held[model_.switches[k].at])) return true;
    return false;
}

void StateEvents::turn() {
    direction_.assign(count_, 0);
    for (std::size_t k = 0; k < count_; ++k) {
        if (!located(k) || !std::isnan(held(k)) || before_[k] == 0.0 || std::isnan(before_[k])) continue;
        direction_[k] = before_[k] > 0.0 ? 1 : -1;
        held(k) = direction_[k];
    }
}

int StateEvents::pushed_back() const {
    for (std::size_t k = 0; k < count_; ++k)
        if (direction_[k] * before_[k] > 0.0 && direction_[k] * after_[k] < 0.0) return static_cast<int>(k);
    return -1;
}

bool StateEvents::passes_over_back(double t) {
    const int back = pushed_back();
    return back >= 0 && gives_up(back, t);
}

void StateEvents::watch(double t, const Vector& y, const TimeWindow& window) {
    arguments_here(t, y, window, nullptr, x_);
    for (std::size_t k = 0; k < count_; ++k) {
        if (located(k)) continue;
        const double now = natural_branch(equations_.programs(), model_.switches[k].at, x_[k]);
        if (std::isnan(now)) continue;
        if (!std::isnan(state_.told[k]) && now != state_.told[k]) ++state_.times[k];
        state_.told[k] = now;
    }
}

std::vector<StateEvents::Passed> StateEvents::passed() const {
    std::vector<Passed> found;
    for (std::size_t k = 0; k < count_; ++k)
        if (state_.times[k]) found.emplace_back(static_cast<int>(k), state_.first[k], state_.times[k]);
    return found;
}

std::vector<StateEvents::Met> StateEvents::take_met() {
    std::vector<Met> found;
    found.swap(met_);
    return found;
}

const std::vector<Interval>& StateEvents::bounds() {
    bounds_.clear();
    for (const Switch& each : model_.switches)
        bounds_.push_back(interval(equations_.programs(), each.at, state_.held[each.at]));
    return bounds_;
}

void StateEvents::settle() {
    for (std::size_t k = 0; k < count_; ++k)
        if (located(k) && std::isnan(held(k)))
            held(k) = natural_branch(equations_.programs(), model_.switches[k].at, x_[k]);
}

void StateEvents::glance(double t, const Vector& y, const Vector& slope, double h, const TimeWindow& window,
                         std::vector<double>& moves) {
    arguments_at(t, y, window, x_);
    glanced_ = y + thresholds_.beside * h * slope;
    arguments_at(t, glanced_, window, moves);
    for (std::size_t k = 0; k < count_; ++k) moves[k] -= x_[k];
}

void StateEvents::arguments_at(double t, const Vector& y, const TimeWindow& window, std::vector<double>& x) {
    equations_.set_pose(t, y.data());
    equations_.set_velocities(y.data(), false);
    arguments_here(t, y, window, state_.held.data(), x);
}

void StateEvents::arguments_here(double t, const Vector& y, const TimeWindow& window, const double* branches,
                                 std::vector<double>& x) const {
    equations_.switch_arguments(window.clamped(t), y.data(), branches, x);
}

}  // namespace mbproj
