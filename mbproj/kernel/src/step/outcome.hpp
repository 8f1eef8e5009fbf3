// How a run ended: why, and where.
#pragma once

#include <algorithm>
#include <cmath>

#include "model/rope_path.hpp"

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
