// What acts on the bodies at a state: gravity, what turns with them, and the loads of the scene.
#pragma once

#include "dynamics/kkt_solver.hpp"
#include "kinematics/loads.hpp"

namespace mbproj {

// The solver's forces, with loads as they were applied last.
template <class D> void set_forces(const Model<D>& model, const Pose<D>& pose, const double* y,
                                   const Applied<D>& applied, KktSolver<D>& solver) {
    for (int b = 0; b < model.size(); ++b) {
        Point<D> force = model.bodies[b].mass * model.gravity;
        Turn<D> torque = Turn<D>::Zero();
        if constexpr (D::axes == 3) {
            const Turn<D> omega = Part<D>(y, b).omega();
            const Turn<D> momentum = model.bodies[b].inertia * omega;
            torque = pose[b].rotation * momentum.cross(omega);
        }
        if (model.loads) {
            force += applied.force[b];
            torque += applied.torque[b];
        }
        solver.set_force(b, force, torque);
    }
}

}  // namespace mbproj
