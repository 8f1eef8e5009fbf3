// The results of a run: consecutive samples, counters and peaks.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "model/mechanism.hpp"
#include "model/settings.hpp"

namespace mbproj {

// What a run has done besides its steps, in the order of the fields of mbproj.motion.report.Tally. Work that led to no
// step counts, too.
struct Counters {
    long rejected_steps = 0, evaluations = 0, projections = 0, projection_iterations = 0, velocity_iterations = 0,
         projection_failures = 0, projection_fallbacks = 0, factorisations = 0;
    static constexpr int count = 9;  // with the steps
    std::array<long, count> list(long steps) const {
        return {steps,
                rejected_steps,
                evaluations,
                projections,
                projection_iterations,
                velocity_iterations,
                projection_failures,
                projection_fallbacks,
                factorisations};
    }
    static Counters from(const std::vector<long>& list) {
        return {list[1], list[2], list[3], list[4], list[5], list[6], list[7], list[8]};
    }
};

// The largest value so far, its row, and when.
struct Peak {
    double value = 0.0;
    long row = 0;
    double time = 0.0;
    void watch(const double* rows, std::size_t count, double t) {
        for (std::size_t r = 0; r < count; ++r)
            if (const double size = rows[r] < 0.0 ? -rows[r] : rows[r]; size > value) {
                value = size;
                row = static_cast<long>(r);
                time = t;
            }
    }
};

// The peaks of violations: of all positions, of those without motions, and of velocities.
struct Peaks {
    Peak position, joint, velocity;
    void watch(const double* C, const double* C_dot, std::size_t rows, std::size_t driven, double t) {
        position.watch(C, rows, t);
        if (driven == 0)
            joint = position;
        else
            joint.watch(C, rows - driven, t);
        velocity.watch(C_dot, rows, t);
    }
};

// Samples one after another, row-major: y, accelerations (global r'', ω' in body axes), multipliers, angles with turns.
// Where the loop decides contacts: the force along each coordinate of stops and frictions, the direction in which each
// friction slides, and the work and the losses at impacts.
struct SampleBlock {
    std::vector<double> t, y, acceleration, multipliers, angles, step_size, pushes, slides, jumps;
    std::vector<long> counters;
    void clear() {
        for (auto* numbers : {&t, &y, &acceleration, &multipliers, &angles, &step_size, &pushes, &slides, &jumps})
            numbers->clear();
        counters.clear();
    }

    // Adds a sample: y and its slope, and λ of C's rows, the first of `lambda`; `counts` are the counters' list.
    void add(double time, const Eigen::VectorXd& state, const Eigen::VectorXd& slope, const Mechanism& model,
             const std::vector<double>& lambda, double h, const std::vector<double>& turned,
             const std::array<long, Counters::count>& counts) {
        const BodySizes sizes = model.sizes();
        t.push_back(time);
        y.insert(y.end(), state.begin(), state.end());
        for (int b = 0; b < model.size(); ++b) {
            const double* a = slope.data() + sizes.state * b + sizes.pose;
            acceleration.insert(acceleration.end(), a, a + sizes.freedoms);
        }
        multipliers.insert(multipliers.end(), lambda.begin(), lambda.begin() + model.row_count());
        step_size.push_back(h);
        angles.insert(angles.end(), turned.begin(), turned.end());
        counters.insert(counters.end(), counts.begin(), counts.end());
    }
};

// The steps that were made: the times of their ends, their sizes, and the states there, one after another.
struct StepPath {
    std::vector<double> t, h, y;
    void add(double end, double size, const Eigen::VectorXd& state) {
        t.push_back(end), h.push_back(size);
        y.insert(y.end(), state.begin(), state.end());
    }
};

}  // namespace mbproj
