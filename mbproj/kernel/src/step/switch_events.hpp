// Events of switches: the branches of the laws, and where a step changes them. `cut_at_switch` of step.hpp makes the steps.
#pragma once

#include <tuple>

#include "step/crossing.hpp"
#include "step/stepper.hpp"

namespace mbproj {

// The state of events, on which the next step depends: a branch for each instruction of the loads' programs; when each
// switch has changed its branch, how often at that time, and how often in quick succession. Of the switches that fixed
// steps pass over: when first, how many times, and the current branch.
struct Branches {
    std::vector<double> held, last;
    std::vector<int> at_once, in_a_row;
    std::vector<double> first;
    std::vector<long> times;
    std::vector<double> told;
};

class SwitchEvents {
public:
    using Vector = Eigen::VectorXd;
    using Met = std::tuple<double, int, int>;      // time, switch, direction
    using Passed = std::tuple<int, double, long>;  // switch, first time, how many times

    // `fixed`: whether steps are fixed: these pass over a switch once the motion was pushed back from it.
    SwitchEvents(Equations& equations, Branches& state, bool fixed);
    // Whether branches are of these laws.
    bool fits(const Branches& saved) const;

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
    double excess(std::size_t k, double t, const Vector& y, const TimeWindow& window);

    // Holds the branches beyond a crossing. Returns a switch that changes its branch too often at one time, or -1;
    // fixed steps pass over such a switch from here on.
    int cross(const Crossing& crossing, double t, double grain, double duration);
    // Whether steps pass over switch k from now on, which pushes the motion back; with error control they do not.
    bool gives_up(int k, double t);

    // Before a jump in time, and after it: switches whose arguments have jumped out of their intervals take the branch
    // there. Signs of 0 stay free.
    void before_jump(double t, const Vector& y, const TimeWindow& window) { arguments_at(t, y, window, before_); }
    void after_jump(double t, const Vector& y, const TimeWindow& window);
    // Sets signs that were free before a step, where the step has moved their arguments from 0.
    void set_free_signs(double t, const Vector& y, const TimeWindow& window);
    bool any_free() const;

    // The changes of arguments along a slope, over a small part of a step: before a change of branches, and after.
    void glance_before(double t, const Vector& y, const Vector& slope, double h, const TimeWindow& window) {
        glance(t, y, slope, h, window, before_);
    }
    void glance_after(double t, const Vector& y, const Vector& slope, double h, const TimeWindow& window) {
        glance(t, y, slope, h, window, after_);
    }
    // Sets free signs to the direction in which their arguments moved before the jump.
    void turn();
    // A switch whose branch has changed, and from which the motion leads back, or -1.
    int pushed_back() const;

    // Whether steps pass over the switch from which the motion leads back, from now on.
    bool passes_over_back(double t);

    // At the end of a fixed step, whose pose and velocities are in place: counts the switches that are passed over and
    // have changed their branch.
    void watch(double t, const Vector& y, const TimeWindow& window);
    std::vector<Passed> passed() const;
    // The events since the last call.
    std::vector<Met> take_met();

private:
    static constexpr int most_at_once = 3;

    // Whether a switch belongs to a follower that does not touch its curve at the last look.
    bool lets_go(std::size_t k) const { return model_.switches[k].curve >= 0 && std::isnan(x_[k]); }
    bool located(std::size_t k) const { return state_.times[k] == 0; }
    double& held(std::size_t k) { return state_.held[model_.switches[k].at]; }

    const std::vector<Interval>& bounds();
    void settle();
    void glance(double t, const Vector& y, const Vector& slope, double h, const TimeWindow& window,
                std::vector<double>& moves);

    void arguments_at(double t, const Vector& y, const TimeWindow& window, std::vector<double>& x);
    void arguments_here(double t, const Vector& y, const TimeWindow& window, const double* branches,
                        std::vector<double>& x) const;

    const Mechanism& model_;
    Equations& equations_;
    const Thresholds& thresholds_;
    const bool fixed_;
    const std::size_t count_;
    Branches& state_;
    std::vector<Interval> bounds_;
    CrossingSearch search_;
    std::vector<double> x_, before_, after_;
    std::vector<int> direction_;
    std::vector<Met> met_;
    Vector glanced_;
};

}  // namespace mbproj
