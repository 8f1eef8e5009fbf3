// The forces on the bodies at a state: gravity, gyroscopic moments, and the loads of the scene.
#pragma once

#include "kinematics/loads.hpp"
#include "solver/kkt_solver.hpp"

namespace mbproj {

// Sets the solver's forces, with the loads that were applied last.
template <class D> void set_forces(const Model<D>& model, const Pose<D>& pose, const Scalar<D>* y,
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

// Forces along coordinates: force and moment about the centre of mass of each body and the ground, global axes.
template <class D> struct ForcesAlong {
    std::vector<Point<D>> force;
    std::vector<Turn<D>> torque;

    explicit ForcesAlong(const Model<D>& model) : force(model.size() + 1), torque(model.size() + 1) {}
    void clear() {
        for (auto& f : force) f.setZero();
        for (auto& f : torque) f.setZero();
    }
    void add(const Coordinate<D>& along, double size) {
        for (int s = 0; s < along.p.slot_count && size != 0.0; ++s) {
            const Attachment<D>& a = along.attachment(s);
            const Point<D> pull = size * along.g[s];
            if (a.is_point) force[a.body] += pull;
            torque[a.body] += moment(along.spoke[s], pull);
        }
    }
    void give(KktSolver<D>& solver) const {
        for (std::size_t b = 0; b + 1 < force.size(); ++b) solver.set_force(static_cast<int>(b), force[b], torque[b]);
    }
    void give_more(KktSolver<D>& solver) const {
        for (std::size_t b = 0; b + 1 < force.size(); ++b) solver.add_force(static_cast<int>(b), force[b], torque[b]);
    }
};

}  // namespace mbproj
