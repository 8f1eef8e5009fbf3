// Forces of a scene as data: laws on coordinates, given forces on bodies, bushings.
#pragma once

#include "kinematics/acting_laws.hpp"
#include "kinematics/bushings.hpp"

namespace mbproj {

// F = -stiffness (s - free) - damping s' + program(t, s, s', channels) along a coordinate s. An angle takes its whole turns from
// one of the joint coordinates.
template <class D> struct Law {
    int coordinate;  // the joint coordinate, or -1
    Scalar<D> stiffness, damping, free;
    int program;  // or -1
    bool loses;   // the work of the program is lost energy, as a damper's
    int bearing;  // the bearing whose load multiplies the program, or -1
    int apart;    // the quadrature of its lost energy, or -1
    // For friction in a plane: the law along the other tangent, or -1, and the direction of sliding along both. The
    // program's force acts along the velocity v, and along -v once v has turned by more than 90° from there.
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

    // The number of coordinates along which forces act: those of the laws, then six for each bushing.
    int size() const { return static_cast<int>(laws.size() + 6 * bushings.size()); }
};

// A law at a state: ∂(-F)/∂s and ∂(-F)/∂s', the value s, the rate s', and the part of F from a function.
template <class D> struct LawSlopes {
    Scalar<D> of_value, of_rate, value, rate, given;
};

// Whether a law's force changes with the state, not with time alone.
template <class D> bool depends_on_state(const ProgramsOf<Scalar<D>>& programs, const Law<D>& law) {
    return law.stiffness != 0.0 || law.damping != 0.0 || (law.program >= 0 && programs.names(law.program, 1));
}

}  // namespace mbproj
