// The loads of joints' bearings, from the multipliers of their rows. Dry friction is proportional to them.
#pragma once

#include "kinematics/constraint_rows.hpp"
#include "kinematics/supports.hpp"

namespace mbproj {

// Of one bearing, with these multipliers.
template <class D>
Supports supports_of(const Model<D>& model, const Pose<D>& pose, const Bearing<D>& bearing, const double* lambda) {
    Supports found;
    for (const auto& [row, part] : bearing.parts) found.along += part * lambda[row];
    if (bearing.is_of_rows()) return found;
    const Joint& joint = model.joints[bearing.joint];
    Matrix<6, Size<D>::freedoms> G;
    jacobian<D>(model, pose, joint, bearing.body, G);
    Column<Size<D>::freedoms> wrench = Column<Size<D>::freedoms>::Zero();
    for (int r = 0; r < joint.rows; ++r) wrench -= lambda[joint.row + r] * G.row(r).transpose();
    const Point<D> force = wrench.template head<D::axes>();
    Point<D> first = 0.5 * force, second = first;
    if constexpr (D::axes == 3) {
        const Rotation<D>& A = pose[bearing.body].rotation;
        const Point<D> arm = A * bearing.point, z = A * bearing.axis;
        const Point<D> torque = wrench.template tail<3>() - arm.cross(force);
        found.along = force.dot(z);
        const Point<D> radial = 0.5 * (force - found.along * z), couple = torque.cross(z) / bearing.length;
        first = radial + couple;
        second = radial - couple;
    }
    found.first.template head<D::axes>() = first;
    found.second.template head<D::axes>() = second;
    return found;
}

}  // namespace mbproj
