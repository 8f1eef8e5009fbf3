// Forces of a scene as data: laws on coordinates, given forces on bodies, bushings.
#pragma once

#include "kinematics/bushings.hpp"

namespace mbproj {

// F = -stiffness (s - free) - damping s' + program(t, s, s', channels) on a coordinate s, which takes its turns from one of the
// joints' coordinates where it is an angle.
template <class D> struct Law {
    int coordinate;  // of the joints, or -1
    Scalar<D> stiffness, damping, free;
    int program;  // or -1
    bool loses;   // what the program gives is energy lost, as a damper's
    int bearing;  // whose load what the program gives is multiplied by, or -1
    int apart;    // the number of the integral of what it loses, or -1
    // Of friction in a plane, the law along the other tangent, or -1, and the direction of sliding along both: what the
    // program gives of the speed v is along v, as long as that has not turned round.
    int partner;
    Scalar<D> own, other;
};

// A force at a point, or a torque: `map` takes the three programs' values to the body's axes or to the global ones.
template <class D> struct BodyForce {
    int body;
    Point<D> point;
    bool is_torque, in_body;
    Matrix<D::axes, 3, Scalar<D>> force_map;
    Matrix<Size<D>::turns, 3, Scalar<D>> torque_map;
    int programs[3];
};

template <class D> struct Loads {
    PrimitiveSet<D> coordinates;  // of the laws, one each
    std::vector<Law<D>> laws;
    std::vector<BodyForce<D>> on_bodies;
    std::vector<Bushing<D>> bushings;

    // What forces act along: the coordinates of the laws, then six of each bushing.
    int size() const { return static_cast<int>(laws.size() + 6 * bushings.size()); }
};

// How a dry friction acts that is a law: against its own rate; along the velocity in the plane of two tangents; as it begins to
// slide, in a direction that it keeps; or with a force that is given.
enum class Acts : int { alone, in_plane, kept, given };

// A law at a state: ∂(-F)/∂s and ∂(-F)/∂s', the value s, the rate s', and the part of F that a function gives.
template <class D> struct LawSlopes { Scalar<D> of_value, of_rate, value, rate, given; };

// Whether a law's force changes with the state, not with time alone.
template <class D> bool depends_on_state(const ProgramsOf<Scalar<D>>& programs, const Law<D>& law) {
    return law.stiffness != 0.0 || law.damping != 0.0 || (law.program >= 0 && programs.names(law.program, 1));
}

}  // namespace mbproj
