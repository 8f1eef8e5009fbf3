// What a run is asked to do, as plain numbers: the tableau, the projection, the steps.
#pragma once

#include <limits>
#include <optional>
#include <tuple>
#include <vector>

#include <Eigen/Core>

#include "algebra/scalar.hpp"

namespace mbproj {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Butcher's tableau with error weights and continuous extension, as mbproj.integrate.steppers.tableau describes it. That of
// an implicit method (mbproj.integrate.steppers.implicit_tableau) begins with f at the start of the step and has no weight
// of f at its end, which is the last stage.
struct Tableau {
    int order, error_order;
    RowMajor a;
    std::vector<double> b, c;
    RowMajor error;
    RowMajor extra_a;
    std::vector<double> extra_c;
    RowMajor dense;
    double gamma = 0.0;      // of an implicit method: what filters the error, and the diagonal of `splitting`; else 0
    bool kinematic = false;  // whether bodies are closed at each stage, and what else is in y is integrated along them
    RowMajor splitting;      // the lower triangle with which stages are solved; a itself where none needs a later one
    bool is_implicit() const { return gamma > 0.0; }
    bool is_coupled() const { return is_implicit() && splitting != a; }
    int stages() const { return static_cast<int>(b.size()); }
    bool operator==(const Tableau& other) const {
        const auto parts = [](const Tableau& of) {
            return std::tie(of.order, of.error_order, of.b, of.c, of.extra_c, of.gamma, of.kinematic);
        };
        const auto same = [](const RowMajor& one, const RowMajor& two) {
            return one.rows() == two.rows() && one.cols() == two.cols() && one == two;
        };
        return parts(*this) == parts(other) && same(a, other.a) && same(error, other.error) &&
               same(extra_a, other.extra_a) && same(dense, other.dense) && same(splitting, other.splitting);
    }
};

enum class Correction { none, baumgarte, mass, coordinates, penalty };

struct ProjectionSettings {
    Correction correction;
    double alpha = 0.0, beta = 0.0;  // Baumgarte's; or α of the penalty
    bool paper_test = false;         // ΔqᵀMΔq <= tolerance in place of |C| <= tolerance
    double tolerance = -1.0;         // negative: from the size of the coordinates
    int every = 1;
    double threshold = -1.0;  // negative: none
    bool position = true, velocity = true;
    int max_iterations = 25;
    bool fallback = false;  // to the coordinates' metric, where a position does not converge
    std::optional<double> penalty() const {
        return correction == Correction::penalty ? std::optional(alpha) : std::nullopt;
    }
    bool operator==(const ProjectionSettings& other) const {
        const auto parts = [](const ProjectionSettings& of) {
            return std::tie(of.correction, of.alpha, of.beta, of.paper_test, of.tolerance, of.every, of.threshold,
                            of.position, of.velocity, of.max_iterations, of.fallback);
        };
        return parts(*this) == parts(other);
    }
    bool corrects() const { return correction != Correction::none && correction != Correction::baumgarte; }
};

// A time at which functions of time have a kink or a jump, so that a step ends there. Until then they are seen at `left` at
// the latest, from then on at `right` at the earliest, a few grains of time to either side. Or one at which controllers act, in
// this order: `actions` of the model; `asks`: the run waits there for what is given from outside.
struct Break {
    double time, left, right;
    std::vector<int> actions;
    bool asks;
};

// Between two breaks: functions of time are seen from within.
template <class Number> struct TimeWindowOf {
    Number first = -std::numeric_limits<double>::infinity(), last = std::numeric_limits<double>::infinity();
    Number seen(const Number& t) const { return where(t < first, first, where(t > last, last, t)); }
};
using TimeWindow = TimeWindowOf<double>;

// The times of samples between the first and the last of a run: origin + k interval, from the k after `offset` on. `count` are
// the samples with the first and the last.
struct SampleGrid {
    double origin = 0.0, interval = 0.0;
    long offset = 0;
    std::size_t count = 0;
    double time(std::size_t sample) const {
        // Rounded by itself, as outside of the kernel: a time is that of a sample where they are equal.
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
    double first = -1.0;  // step where the error controls the others; negative: chosen
    bool fixed() const { return step > 0.0; }
    double end() const { return start + duration; }
    // Between two samples.
    double interval() const { return fixed() ? step * static_cast<double>(every) : sample(1) - sample(0); }
    // When sample number k is due where the error controls the step.
    double sample(std::size_t k) const { return k == 0 ? start : k + 1 == samples.count ? end() : samples.time(k); }
};

}  // namespace mbproj
