// The loads of joints' bearings, from the multipliers of their rows. Dry friction is proportional to them.
#pragma once

#include "kinematics/constraint_rows.hpp"

namespace mbproj {

// The forces on a bearing's two supports, and along its axis, or a contact's push; linear in the multipliers.
template <class D> struct Supports {
    Point<D> first = Point<D>::Zero(), second = Point<D>::Zero();
    Scalar<D> along = 0.0;

    Supports() = default;
    Supports(const Model<D>& model, const Pose<D>& pose, const Bearing<D>& bearing, const Scalar<D>* lambda) {
        for (const auto& [row, part] : bearing.parts) along += part * lambda[row];
        if (bearing.is_of_rows()) return;
        const Joint& joint = model.joints[bearing.joint];
        Matrix<6, Size<D>::freedoms, Scalar<D>> G;
        jacobian<D>(model, pose, joint, bearing.body, G);
        Column<Size<D>::freedoms, Scalar<D>> wrench = Column<Size<D>::freedoms, Scalar<D>>::Zero();
        for (int r = 0; r < joint.rows; ++r) wrench -= lambda[joint.row + r] * G.row(r).transpose();
        const Point<D> force = wrench.template head<D::axes>();
        first = second = 0.5 * force;
        if constexpr (D::axes == 3) {
            const Rotation<D>& A = pose[bearing.body].rotation;
            const Point<D> arm = A * bearing.point, z = A * bearing.axis;
            const Point<D> torque = wrench.template tail<3>() - arm.cross(force);
            along = force.dot(z);
            const Point<D> radial = 0.5 * (force - along * z), couple = torque.cross(z) / bearing.length;
            first = radial + couple;
            second = radial - couple;
        }
    }

    void add(const Supports& other, Scalar<D> part) {
        first += part * other.first;
        second += part * other.second;
        along += part * other.along;
    }
    // The load without the preload.
    Scalar<D> load(const Bearing<D>& bearing) const {
        if (bearing.is_push()) return along;
        return bearing.radial * (first.norm() + second.norm()) + bearing.axial * abs(along);
    }
    // The change of the load where the supports change by `change`.
    Scalar<D> slope(const Bearing<D>& bearing, const Supports& change) const {
        if (bearing.is_push()) return change.along;
        const auto part = [](const Point<D>& f, const Point<D>& by) {
            const Scalar<D> size = f.norm();
            return size > 0.0 ? f.dot(by) / size : by.norm();
        };
        return bearing.radial * (part(first, change.first) + part(second, change.second)) +
               bearing.axial * (along < 0.0 ? -change.along : change.along);
    }
};

// The load of a bearing with these multipliers.
template <class D> Scalar<D> load(const Model<D>& model, const Pose<D>& pose, int bearing, const Scalar<D>* lambda) {
    const Bearing<D>& own = model.bearings[bearing];
    return own.preload + Supports<D>(model, pose, own, lambda).load(own);
}

}  // namespace mbproj
