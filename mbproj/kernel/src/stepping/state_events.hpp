// Events in the state: the switches of the laws, their branches, and where a branch changes. The time loop makes the
// steps.
#pragma once

#include <tuple>

#include "steppers/stepper.hpp"
#include "stepping/crossing.hpp"

namespace mbproj {

// The state of events, on which the next step depends: a branch for each instruction of the loads' programs; when each
// switch has changed its branch, how often at that time, and how often in quick succession. Of the switches that fixed
// steps pass over: when first, how many times, and the current branch.
struct SavedEvents {
    std::vector<double> held, last;
    std::vector<int> at_once, in_a_row;
    std::vector<double> first;
    std::vector<long> times;
    std::vector<double> told;
};

class StateEvents {
public:
    using Vector = Eigen::VectorXd;
    using Met = std::tuple<double, int, int>;      // time, switch, direction
    using Passed = std::tuple<int, double, long>;  // switch, first time, how many times

    // `fixed`: whether steps are fixed: these pass over a switch once the motion was pushed back from it.
    StateEvents(Equations& equations, bool fixed)
        : model_(equations.mechanism()), equations_(equations), thresholds_(model_.thresholds), fixed_(fixed),
          count_(model_.switches.size()), search_(thresholds_), x_(count_), before_(count_), after_(count_) {
        if (count_ == 0) return;
        const double never = -std::numeric_limits<double>::infinity();
        const std::vector<double> zeros(count_, 0.0), free(count_, free_branch), last(count_, never);
        const std::vector<double> held(equations.programs().op.size(), free_branch);
        state_ = {held, last, std::vector<int>(count_), std::vector<int>(count_), zeros, std::vector<long>(count_),
                  free};
        glanced_ = Vector::Zero(equations.layout().size());
    }

    const SavedEvents& save() const { return state_; }
    // False where it is not of these laws.
    bool resume(const SavedEvents& saved) {
        const bool fits = saved.held.size() == state_.held.size() && saved.last.size() == count_ &&
                          saved.at_once.size() == count_ && saved.in_a_row.size() == count_ &&
                          saved.first.size() == count_ && saved.times.size() == count_ && saved.told.size() == count_;
        if (fits) state_ = saved;
        return fits;
    }

    // Whether the scene has switches.
    bool any() const { return count_ > 0; }
    // Whether steps pass over some switches.
    bool passes() const {
        return std::any_of(state_.times.begin(), state_.times.end(), [](long times) { return times > 0; });
    }
    // The laws and the rows are on the branches held from now on.
    void hold() { equations_.hold(state_.held.data()); }

    // The largest distance of a step's end from an event, s, for a step of size h.
    double slack(double h, double tolerance, double grain) const {
        return std::max(thresholds_.located * tolerance * h, 4.0 * grain);
    }

    // The first crossing of a step of size h from t; `state_at(θ, state)` gives the states within.
    template <class At> std::optional<Crossing> first(const At& state_at, double t, double h, const TimeWindow& window,
                                                      double slack, double grain) {
        const auto path = [&](double theta, std::vector<double>& x) {
            state_at(theta, glanced_);
            x.resize(count_);
            arguments_at(t + theta * h, glanced_, window, x);
        };
        return search_.first(path, bounds(), slack / h, 16.0 * grain / h);
    }

    // By how much an argument is outside its interval.
    double excess(std::size_t k, double t, const Vector& y, const TimeWindow& window) {
        arguments_at(t, y, window, x_);
        return bounds()[k].excess(x_[k]);
    }

    // Holds the branches beyond a crossing. Returns a switch that changes its branch too often at one time, or -1;
    // fixed steps pass over such a switch from here on.
    int cross(const Crossing& crossing, double t, double grain, double duration) {
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
    // Whether steps pass over switch k from now on, which pushes the motion back; with error control they do not.
    bool gives_up(int k, double t) {
        if (!fixed_) return false;
        held(k) = free_branch;
        state_.first[k] = t, state_.times[k] = 1;
        if (!direction_.empty()) direction_[k] = 0;
        return true;
    }

    // Before a jump in time, and after it: switches whose arguments have jumped out of their intervals take the branch
    // there. Signs of 0 stay free.
    void before_jump(double t, const Vector& y, const TimeWindow& window) { arguments_at(t, y, window, before_); }
    void after_jump(double t, const Vector& y, const TimeWindow& window) {
        arguments_at(t, y, window, x_);
        const std::vector<Interval>& held_in = bounds();
        for (std::size_t k = 0; k < count_; ++k)
            if ((held_in[k].excess(x_[k]) > 0.0 && x_[k] != before_[k]) || lets_go(k)) held(k) = free_branch;
        settle();
    }
    // Sets signs that were free before a step, where the step has moved their arguments from 0.
    void set_free_signs(double t, const Vector& y, const TimeWindow& window) {
        if (!any_free()) return;
        arguments_at(t, y, window, x_);
        settle();
    }
    bool any_free() const {
        for (std::size_t k = 0; k < count_; ++k)
            if (located(k) && !lets_go(k) && std::isnan(state_.held[model_.switches[k].at])) return true;
        return false;
    }

    // The changes of arguments along a slope, over a small part of a step: before a change of branches, and after.
    void glance_before(double t, const Vector& y, const Vector& slope, double h, const TimeWindow& window) {
        glance(t, y, slope, h, window, before_);
    }
    void glance_after(double t, const Vector& y, const Vector& slope, double h, const TimeWindow& window) {
        glance(t, y, slope, h, window, after_);
    }
    // Sets free signs to the direction in which their arguments moved before the jump.
    void turn() {
        direction_.assign(count_, 0);
        for (std::size_t k = 0; k < count_; ++k) {
            if (!located(k) || !std::isnan(held(k)) || before_[k] == 0.0 || std::isnan(before_[k])) continue;
            direction_[k] = before_[k] > 0.0 ? 1 : -1;
            held(k) = direction_[k];
        }
    }
    // A switch whose branch has changed, and from which the motion leads back, or -1.
    int pushed_back() const {
        for (std::size_t k = 0; k < count_; ++k)
            if (direction_[k] * before_[k] > 0.0 && direction_[k] * after_[k] < 0.0) return static_cast<int>(k);
        return -1;
    }

    // Whether steps pass over the switch from which the motion leads back, from now on.
    bool passes_over_back(double t) {
        const int back = pushed_back();
        return back >= 0 && gives_up(back, t);
    }

    // At the end of a fixed step, whose pose and velocities are in place: counts the switches that are passed over and
    // have changed their branch.
    void watch(double t, const Vector& y, const TimeWindow& window) {
        arguments_here(t, y, window, nullptr, x_);
        for (std::size_t k = 0; k < count_; ++k) {
            if (located(k)) continue;
            const double now = natural_branch(equations_.programs(), model_.switches[k].at, x_[k]);
            if (std::isnan(now)) continue;
            if (!std::isnan(state_.told[k]) && now != state_.told[k]) ++state_.times[k];
            state_.told[k] = now;
        }
    }
    std::vector<Passed> passed() const {
        std::vector<Passed> found;
        for (std::size_t k = 0; k < count_; ++k)
            if (state_.times[k]) found.emplace_back(static_cast<int>(k), state_.first[k], state_.times[k]);
        return found;
    }
    // The events since the last call.
    std::vector<Met> take_met() {
        std::vector<Met> found;
        found.swap(met_);
        return found;
    }

private:
    static constexpr int most_at_once = 3;

    // Whether a switch belongs to a follower that does not touch its curve at the last look.
    bool lets_go(std::size_t k) const { return model_.switches[k].curve >= 0 && std::isnan(x_[k]); }
    bool located(std::size_t k) const { return state_.times[k] == 0; }
    double& held(std::size_t k) { return state_.held[model_.switches[k].at]; }

    const std::vector<Interval>& bounds() {
        bounds_.clear();
        for (const Switch& each : model_.switches)
            bounds_.push_back(interval(equations_.programs(), each.at, state_.held[each.at]));
        return bounds_;
    }

    void settle() {
        for (std::size_t k = 0; k < count_; ++k)
            if (located(k) && std::isnan(held(k)))
                held(k) = natural_branch(equations_.programs(), model_.switches[k].at, x_[k]);
    }

    void glance(double t, const Vector& y, const Vector& slope, double h, const TimeWindow& window,
                std::vector<double>& moves) {
        arguments_at(t, y, window, x_);
        glanced_ = y + thresholds_.beside * h * slope;
        arguments_at(t, glanced_, window, moves);
        for (std::size_t k = 0; k < count_; ++k) moves[k] -= x_[k];
    }

    void arguments_at(double t, const Vector& y, const TimeWindow& window, std::vector<double>& x) {
        equations_.set_pose(t, y.data());
        equations_.set_velocities(y.data(), false);
        arguments_here(t, y, window, state_.held.data(), x);
    }
    void arguments_here(double t, const Vector& y, const TimeWindow& window, const double* branches,
                        std::vector<double>& x) const {
        equations_.switch_arguments(window.clamped(t), y.data(), branches, x);
    }

    const Mechanism& model_;
    Equations& equations_;
    const Thresholds& thresholds_;
    const bool fixed_;
    const std::size_t count_;
    SavedEvents state_;
    std::vector<Interval> bounds_;
    CrossingSearch search_;
    std::vector<double> x_, before_, after_;
    std::vector<int> direction_;
    std::vector<Met> met_;
    Vector glanced_;
};

}  // namespace mbproj
