// The gap of a stop at the state in place.
#pragma once

#include "solver/equations.hpp"

namespace mbproj {

// On this side, with whole turns of the joints' coordinates.
inline double stop_gap(const Equations& equations, const std::vector<long>& turns, int stop, double side) {
    const Stops& stops = equations.mechanism().stops;
    const int coordinate = stops.joint_coordinate[stop];
    const double whole = coordinate < 0 ? 0.0 : 2.0 * M_PI * static_cast<double>(turns[coordinate]);
    return side * (equations.at_stop(stop).value + whole - stops.bound[stop]);
}

}  // namespace mbproj
