// Iterative refinement of several cases at once.
#pragma once

#include "ensembles/pack.hpp"
#include "loops/refinement.hpp"

namespace mbproj {

// `refine` in the lanes that are `open`, each as long as its steps decrease; `work` changes with λ.
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
