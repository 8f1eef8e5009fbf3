// Fixed steps whose equations Newton's method has not solved, by what kept it from doing so.
#pragma once

#include <vector>

#include "steppers/stepper.hpp"

namespace mbproj {

// For want of the same body's accelerations, or the same force: how often, and of which step's start first.
struct Halved {
    Unsolved cause;
    double first;
    long times;
};

class Halvings {
public:
    void note(const Unsolved& cause, double t) {
        for (Halved& each : found_)
            if (each.cause.force == cause.force && (cause.force >= 0 || each.cause.body == cause.body)) {
                ++each.times;
                return;
            }
        found_.push_back({cause, t, 1});
    }
    const std::vector<Halved>& all() const { return found_; }
    void resume(std::vector<Halved> saved) { found_ = std::move(saved); }

private:
    std::vector<Halved> found_;
};

}  // namespace mbproj
