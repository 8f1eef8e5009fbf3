// How the laws of forces act between two events, as contacts and switches have decided.
#pragma once

#include <set>
#include <vector>

namespace mbproj {

// How a dry friction acts whose force is a law: against its rate; along the velocity in the plane of two tangents; in a
// constant direction, as it begins to slide; or with a given force.
enum class Acts : int { alone, in_plane, kept, given };

struct ActingLaws {
    const double* held = nullptr;  // the branches of programs, or none
    std::vector<double> part;      // the part of each law's program that counts; empty: all of it
    std::vector<Acts> acts;        // how the part of each law acts; empty: alone
    std::vector<double> turning;  // the rate of the part of each law that is kept, 1/s; and the time at which it begins
    double since = 0.0;
    std::vector<double> pushed;  // the push of the stop on which each law rubs; empty: 1
    std::vector<double> pace;    // the factor of the rate in each law's program; empty: 1
    std::set<int> touching;      // the stops whose rows are held
};

}  // namespace mbproj
