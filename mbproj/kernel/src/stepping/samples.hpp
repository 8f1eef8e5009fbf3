// The results of a run: consecutive samples, counters and peaks, and its outcome.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "model/mechanism.hpp"
#include "model/rope_path.hpp"
#include "model/settings.hpp"

namespace mbproj {

enum class Status : int {
    running,
    finished,
    not_finite,
    singular,
    open,
    vanished,
    broken,
    branch,
    unresolved,
    untold,
    pushed_back,
    unsolved,
    halted,
    jammed,
    off_rope,
    overlap,
    undecided
};

// In the order of the fields of mbproj.integrate.reporting.tally.Tally.
struct Counters {
    long steps = 0, rejected_steps = 0, evaluations = 0, projections = 0, projection_iterations = 0,
         velocity_iterations = 0, projection_failures = 0, projection_fallbacks = 0, factorisations = 0;
    static constexpr int count = 9;
    std::array<long, count> list() const {
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
        return {list[0], list[1], list[2], list[3], list[4], list[5], list[6], list[7], list[8]};
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

    // Adds a sample: y and its slope, and λ of C's rows, the first of `lambda`.
    void add(double time, const Eigen::VectorXd& state, const Eigen::VectorXd& slope, const Mechanism& model,
             const std::vector<double>& lambda, double h, const std::vector<double>& turned, const Counters& counted) {
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
        const auto counts = counted.list();
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

// A step that is too coarse to tell the turns of a coordinate: how far it turns, how far from that the pose is (rad),
// and the part of the step that would be short enough.
struct Slip {
    int coordinate = -1;
    double turned = 0.0, off = 0.0;
    explicit operator bool() const { return coordinate >= 0; }
    double shorter() const { return turned > 0.0 ? std::min(0.5, M_PI / turned) : 0.5; }
};

// Why and where a run stopped.
struct Outcome {
    Status status = Status::running;
    double time = 0.0;
    int joint = -1;
    int row = -1;
    double open_by = 0.0;
    int passes = 0;
    bool projection_failed = false;
    double velocity_change = 0.0;
    Slip slip{};
    double step = 0.0;          // that would tell the turns, s
    int body = -1, force = -1;  // the cause that a step was not solved
    bool near_singular = false;
    RopeTrouble rope{};
    bool stops() const { return status != Status::running; }

    static Outcome left_open(double t, int row, double by, int passes, bool projection_failed) {
        Outcome found{Status::open, t};
        found.row = row;
        found.open_by = by;
        found.passes = passes;
        found.projection_failed = projection_failed;
        return found;
    }
    // The motion is on another branch, or on one of two that are not told apart; `near_singular`: branches are near.
    static Outcome at_branch(Status status, double t, double change, bool near_singular) {
        Outcome found{status, t};
        found.velocity_change = change;
        found.near_singular = near_singular;
        return found;
    }
    // Friction that leaves no unique solution: the number of its law.
    static Outcome jammed(double t, int law) {
        Outcome found{Status::jammed, t};
        found.row = law;
        return found;
    }
    // A rope has left its path: the number of its coordinate.
    static Outcome off_rope(double t, int coordinate, const RopeTrouble& found) {
        Outcome outcome{Status::off_rope, t};
        outcome.row = coordinate;
        outcome.rope = found;
        return outcome;
    }
    // Two curves overlap: those of this joint, or of this coordinate.
    static Outcome overlap(double t, int joint, int coordinate) {
        Outcome found{Status::overlap, t};
        found.joint = joint;
        found.row = coordinate;
        return found;
    }
    // On both sides of this switch the motion leads back onto it.
    static Outcome pushed_back(double t, int number) {
        Outcome found{Status::pushed_back, t};
        found.row = number;
        return found;
    }
    // An implicit step is not solved: for the accelerations of a body, or for a force if that is not -1.
    static Outcome unsolved(double t, int body, int force, bool near_singular) {
        Outcome found{Status::unsolved, t};
        found.body = body;
        found.force = force;
        found.near_singular = near_singular;
        return found;
    }
    // A step of size h does not tell the turns.
    static Outcome untold(const Slip& slip, double t, double h) {
        Outcome found{Status::untold, t};
        found.slip = slip;
        found.step = slip.shorter() * h;
        return found;
    }
};

}  // namespace mbproj
