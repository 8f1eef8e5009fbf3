// Iterative refinement. S squares the condition number of Y. Where a pivot shows that this matters, the residual, computed from Y
// itself, restores the digits (Björck 1996, sect. 6.6.5: corrected seminormal equations).
#pragma once

#include <limits>
#include <vector>

#include "algebra/pack.hpp"
#include "model/thresholds.hpp"

namespace mbproj {

// The size of the last step, and of the solution so far.
template <class Scalar> struct StepSize {
    Scalar change = 0.0, size = 0.0;

    StepSize(const std::vector<Scalar>& step, const std::vector<Scalar>& lambda) {
        for (std::size_t r = 0; r < lambda.size(); ++r) {
            change = max(change, abs(step[r]));
            size = max(size, abs(lambda[r]));
        }
    }
};

// `improve` adds a step to λ, as long as the steps decrease.
template <class Scalar, class Improve> void refine(const Thresholds& from, const std::vector<Scalar>& step,
                                                   const std::vector<Scalar>& lambda, Improve&& improve) {
    Scalar before = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < from.most_passes; ++pass) {
        improve();
        const StepSize<Scalar> made(step, lambda);
        if (!(made.change > from.no_digits * made.size && made.change < 0.5 * before)) return;
        before = made.change;
    }
}

// The same in the lanes that are `open`, each as long as its steps decrease; `work` changes with λ.
template <class Twist, class Improve> void refine_lanes(Mask open, const Thresholds& from,
                                                        const std::vector<Pack>& step, std::vector<Pack>& lambda,
                                                        std::vector<Twist>& work, Improve&& improve) {
    Pack before = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < from.most_passes && (open & Lanes::in()).any(); ++pass) {
        const auto old_lambda = lambda;
        const auto old_work = work;
        improve();
        const StepSize<Pack> made(step, lambda);
        for (std::size_t r = 0; r < lambda.size(); ++r) lambda[r] = where(open, lambda[r], old_lambda[r]);
        for (std::size_t b = 0; b < work.size(); ++b)
            for (int i = 0; i < Twist::size(); ++i) work[b][i] = where(open, work[b][i], old_work[b][i]);
        open &= (made.change > from.no_digits * made.size) & (made.change < 0.5 * before);
        before = made.change;
    }
}

}  // namespace mbproj
