// The path of a rope: the radii of its circles and the directions of its spans. See mbproj.joints.primitives.rope.
#pragma once

#include <vector>

namespace mbproj {

struct RopePath {
    std::vector<double> radii;       // of the k centres: positive where the rope bends left, 0 for points
    std::vector<double> directions;  // of the k - 1 lines of centres, at the scene's pose, in rad
    std::vector<double> cosine, sine;
    double wound = 0.0;                       // the length that is subtracted, m
    std::vector<double> by_length, by_angle;  // a and b of each span, in C = Σ a λ + b θ
    std::vector<double> lifts;                // 1 of circles that the rope may leave, else 0

    int spans() const { return static_cast<int>(directions.size()); }
};

// A fault of the path. Either a span, from 0, is lost: its circles overlap, or it has turned too far. Or the rope has left a
// circle, from 0.
struct RopeTrouble {
    int span = -1, centre = -1;
    explicit operator bool() const { return span >= 0 || centre >= 0; }
};

// The most centres that a rope may have, and its most slots, with the two vectors of its plane.
constexpr int most_centres = 14, most_rope_slots = most_centres + 2;

}  // namespace mbproj
