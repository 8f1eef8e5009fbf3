// A gap at two times: the cubic through both values and rates, and its minima in between.
#pragma once

#include <algorithm>
#include <cmath>

#include "solver/equations.hpp"

namespace mbproj {

// The parts of a step, in eighths, that are looked at where a body may have gone through another one.
constexpr int through[] = {4, 2, 6, 3, 5};

// The gap between two times that lie h apart: value + a θ + c2 θ² + c3 θ³.
struct GapCubic {
    double h, value, end, a, b, c2, c3;

    GapCubic(const ValueAndRate& from, const ValueAndRate& to, double h)
        : h(h), value(from.value), end(to.value), a(h * from.rate), b(h * to.rate),
          c2(3.0 * (end - value) - 2.0 * a - b), c3(a + b - 2.0 * (end - value)) {}

    double at(double theta) const { return value + theta * (a + theta * (c2 + theta * c3)); }

    // The part θ at which it has a minimum inside; 0 where it has none.
    double lowest() const {
        const double root = c2 * c2 - 3.0 * c3 * a;
        if (!(a < 0.0 && root > 0.0)) return 0.0;
        const double theta = -a / (c2 + std::sqrt(root));
        return theta > 0.0 && theta < 1.0 ? theta : 0.0;
    }
    // The part at which its rate has a minimum, and the least rate.
    double slowest_at() const {
        const double theta = c3 > 0.0 ? -c2 / (3.0 * c3) : 0.0;
        return theta > 0.0 && theta < 1.0 ? theta : 0.0;
    }
    double slowest() const {
        const double ends = std::min(a, b) / h, theta = slowest_at();
        return theta == 0.0 ? ends : std::min(ends, (a + theta * (2.0 * c2 + 3.0 * theta * c3)) / h);
    }

    // Whether the gap is below zero if extrapolated over the step from its start, and also back from its end: a body
    // may have gone through a thin one.
    bool may_pass() const { return value > 0.0 && value + a < 0.0 && end - b < 0.0; }

    // An estimate of the last part at which it falls to zero; a half where it does not.
    double last_fall() const {
        constexpr int parts = 16;
        for (int k = parts; k-- > 0;) {
            double low = k / static_cast<double>(parts), high = (k + 1) / static_cast<double>(parts);
            if (!(at(low) > 0.0 && at(high) <= 0.0)) continue;
            for (int halving = 0; halving < 50; ++halving) {
                const double middle = 0.5 * (low + high);
                (at(middle) > 0.0 ? low : high) = middle;
            }
            return high;
        }
        return 0.5;
    }
};

}  // namespace mbproj
