// The settings of a run as plain numbers: the tableau, the projection, the steps.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "model/scalar.hpp"

namespace mbproj {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Butcher's tableau with error weights and continuous extension, as in mbproj.motion.steppers.tableau. An implicit
// method (mbproj.motion.steppers.tableau) has f at the start of the step as its first stage. Its last stage
// is the end of the step, where f is not evaluated again.
struct Tableau {
    int order, error_order;
    RowMajor a;
    std::vector<double> b, c;
    RowMajor error;
    RowMajor extra_a;
    std::vector<double> extra_c;
    RowMajor dense;
    double gamma = 0.0;      // of an implicit method: the filter of the error, and the diagonal of `splitting`; else 0
    bool kinematic = false;  // whether each stage closes the bodies, and only the other numbers of y are integrated
    RowMajor splitting;  // the lower triangle with which stages are solved; a itself where no stage needs a later one
    bool is_implicit() const { return gamma > 0.0; }
    bool is_coupled() const { return is_implicit() && splitting != a; }
    int stages() const { return static_cast<int>(b.size()); }
};

enum class Correction { none, baumgarte, mass, coordinates, penalty };

struct ProjectionSettings {
    Correction correction;
    double alpha = 0.0, beta = 0.0;  // Baumgarte's; or α of the penalty
    bool paper_test = false;         // ΔqᵀMΔq <= tolerance in place of |C| <= tolerance
    double tolerance = -1.0;         // negative: computed from the size of the coordinates
    int every = 1;
    double threshold = -1.0;  // negative: none
    bool position = true, velocity = true;
    int max_iterations = 25;
    bool fallback = false;  // the metric of the coordinates follows where a position does not converge
    std::optional<double> penalty() const {
        return correction == Correction::penalty ? std::optional(alpha) : std::nullopt;
    }
    bool corrects() const { return correction != Correction::none && correction != Correction::baumgarte; }
};

// A time at which a step ends. Functions of time may have a kink or a jump there: before it they are evaluated at `left` at the
// latest, after it at `right` at the earliest, a few grains of time to either side. Controllers may act there, in the order of
// `actions` of the model. Where it `asks`, the run waits for values from outside.
struct Break {
    double time, left, right;
    std::vector<int> actions;
    bool asks;
};

// The time between two breaks, in which functions of time are evaluated.
struct TimeWindow {
    double first = -std::numeric_limits<double>::infinity(), last = std::numeric_limits<double>::infinity();
    double clamped(double t) const { return t < first ? first : t > last ? last : t; }
};

// The times of samples between the first and the last of a run: origin + k interval, for k after `offset`. `count` includes the
// first and the last sample.
struct SampleGrid {
    double origin = 0.0, interval = 0.0;
    long offset = 0;
    std::size_t count = 0;
    double time(std::size_t sample) const {
        // The product is rounded before the sum, as in Python: a time is a sample's only where their bits are equal.
        const volatile double since = static_cast<double>(offset + static_cast<long>(sample)) * interval;
        return origin + since;
    }
};

struct Steps {
    double start, duration;
    double step;         // fixed, or negative
    double tolerance;    // where the error controls the step
    long count;          // fixed steps
    long every;          // fixed steps between two samples
    SampleGrid samples;  // where the error controls the step
    std::vector<Break> breaks;
    bool fixed() const { return step > 0.0; }
    double end() const { return start + duration; }
    // The time between two samples.
    double interval() const { return fixed() ? step * static_cast<double>(every) : sample(1) - sample(0); }
    // The time of sample number k where the error controls the step.
    double sample(std::size_t k) const { return k == 0 ? start : k + 1 == samples.count ? end() : samples.time(k); }
};

}  // namespace mbproj
