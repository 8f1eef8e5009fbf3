// The projection of a state onto the constraints, and the rows of conserved quantities, as steps and runs see them.
#pragma once

#include <vector>

#include "solver/formulation.hpp"

namespace mbproj {

// The energy and momenta with which the balance began. How often the rows held, were skipped near rest, or were
// refused. The energy that they added: its signed sum, the sum of magnitudes, and the largest magnitude of the signed
// sum. Their largest correction, as a part of the velocity.
struct Kept {
    double energy = 0.0;
    std::vector<double> momenta;
    long held = 0, rested = 0, refused = 0;
    double given = 0.0, moved = 0.0, furthest = 0.0, largest = 0.0;
};

class Invariants {
public:
    Kept kept;

    Invariants(const Invariants&) = delete;
    Invariants& operator=(const Invariants&) = delete;
    virtual ~Invariants() = default;

    // A new balance begins at y at t.
    virtual void begin(double t, const double* y) = 0;

protected:
    Invariants() = default;
};

class Projector {
public:
    Projector(const Projector&) = delete;
    Projector& operator=(const Projector&) = delete;
    virtual ~Projector() = default;

    // Normalises the orientations of y after step number `step` (from 1), which led there from `before`, and projects y if the
    // schedule says so: every k-th step, and with a threshold only the levels that exceed it (velocities always after a
    // moved position). Afterwards the pose of y is in place.
    virtual Projected after_step(long step, double t, const double* before, double* y) = 0;
    // A state between two steps, moved to the constraints at the levels that are switched on.
    virtual Projected anywhere(double t, double* y) = 0;
    // From now on velocities satisfy the energy balance, and conserve the momenta along fields of rigid motion, each with as many
    // numbers as a body has freedoms: shift and turn. `tolerance`: that of the steps' errors; 0 where it is unknown.
    virtual void keep(bool energy, const std::vector<double>& fields, double tolerance) = 0;
    virtual Invariants* invariants() = 0;  // null where none are kept

protected:
    Projector() = default;
};

}  // namespace mbproj
