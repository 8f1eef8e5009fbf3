// Iterative refinement. S squares the condition number of Y. Where a pivot shows that this matters, the residual, computed from Y
// itself, restores the digits (Björck 1996, sect. 6.6.5: corrected seminormal equations).
#pragma once

#include <limits>
#include <vector>

#include "model/scalar.hpp"
#include "model/thresholds.hpp"

namespace mbproj {

// The size of the last step, and of the solution so far.
struct StepSize {
    double change = 0.0, size = 0.0;

    StepSize(const std::vector<double>& step, const std::vector<double>& lambda) {
        for (std::size_t r = 0; r < lambda.size(); ++r) {
            change = max(change, abs(step[r]));
            size = max(size, abs(lambda[r]));
        }
    }
};

// Calls `improve`, which adds a step to λ, as long as the steps decrease.
template <class Improve> void refine(const Thresholds& from, const std::vector<double>& step,
                                     const std::vector<double>& lambda, Improve&& improve) {
    double before = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < from.most_passes; ++pass) {
        improve();
        const StepSize made(step, lambda);
        if (!(made.change > from.no_digits * made.size && made.change < 0.5 * before)) return;
        before = made.change;
    }
}

}  // namespace mbproj
