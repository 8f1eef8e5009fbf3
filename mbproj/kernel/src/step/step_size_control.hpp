// Step-size control as in mbproj.motion.numpy_loop (Hairer, Nørsett & Wanner 1993, sect. II.4).
#pragma once

#include <algorithm>
#include <cmath>

#include "model/thresholds.hpp"

namespace mbproj {

// The last error, and whether the current step was rejected before.
struct LastError {
    double previous = 0.0;
    bool rejected = false;
};

// PI controller: h_new = 0.9 h err^(-a) err_old^b with b = 0.2 / k, a = 1 / k - 0.75 b, k the estimate's order + 1.
class StepSizeControl {
public:
    StepSizeControl(int error_order, const Thresholds& thresholds, LastError& state)
        : thresholds_(thresholds), k_(error_order + 1), state_(state) {
        forget();
    }

    // Forgets the last error: after a jump it says nothing about the next step.
    void forget() { state_ = {thresholds_.least_error_before, false}; }
    // Whether the current step was rejected before, and there is an error of a step before it.
    bool is_again() const { return state_.rejected && state_.previous > thresholds_.least_error_before; }

    double after_accepted(double error, double h) {
        const double integral = 0.2 / k_;
        const double factor = thresholds_.safety *
                              std::pow(std::max(error, thresholds_.least_error), 0.75 * integral - 1.0 / k_) *
                              std::pow(state_.previous, integral);
        const double most = state_.rejected ? 1.0 : thresholds_.largest_change;
        state_ = {std::max(error, thresholds_.least_error_before), false};
        return h * std::min(std::max(factor, thresholds_.smallest_change), most);
    }
    double after_rejected(double error, double h) {
        state_.rejected = true;
        const double factor = std::isfinite(error) ? thresholds_.safety * std::pow(error, 0.15 / k_ - 1.0 / k_) : 0.0;
        return h * std::max(factor, thresholds_.smallest_change);
    }

private:
    const Thresholds& thresholds_;
    const double k_;
    LastError& state_;
};

// h, or the time left to the end, or half of it where one step more would be tiny.
inline double fitted(double h, double left) {
    if (h >= left) return left;
    return 2.0 * h > left && left > 1.01 * h ? 0.5 * left : h;
}

}  // namespace mbproj
