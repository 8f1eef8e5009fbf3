// The joints' rows: C, C' and γ of Eqs. 2-9, and their gradients as wrenches on the bodies.
#pragma once

#include "pose.hpp"
#include "primitives.hpp"

namespace mbproj {

// An instance's points and vectors in global axes.
template <int D> struct Slots {
    Point<D> x[most_slots];
    Slots(const Instance& p, const Pose<D>& pose) {
        for (int s = 0; s < p.slot_count; ++s) x[s] = pose.place(p.slots[s]);
    }
};

// How they move: their velocities, and the part ω × (ω × s) of their accelerations that holds no body's acceleration.
template <int D> struct MovingSlots : Slots<D> {
    Point<D> x_dot[most_slots], bias[most_slots];
    MovingSlots(const Model<D>& model, const Instance& p, const Pose<D>& pose, const Motion<D>& motion)
        : Slots<D>(p, pose) {
        for (int s = 0; s < p.slot_count; ++s) {
            const Attachment<D>& a = model.constraints.attachments[p.slots[s]];
            const Twist<D>& twist = motion[a.body];
            x_dot[s] = turned_by(twist.omega, pose.spoke(p.slots[s]));
            bias[s] = turned_by(twist.omega, x_dot[s]);
            if (a.is_point) x_dot[s] += twist.velocity;
        }
    }
};

template <int D> void constraint(const Model<D>& model, const Pose<D>& pose, double* C) {
    for (const Instance& p : model.constraints.instances) {
        if (p.kind == Kind::coincident) {
            Eigen::Map<Point<D>> rows(C + p.row);
            rows = pose.place(p.slots[1]) - pose.place(p.slots[0]);
            if (p.offset != 0.0) rows.array() -= p.offset;
        } else {
            C[p.row] = value<D>(p, Slots<D>(p, pose).x) - p.offset;
        }
    }
}

// C' and γ, with C'' = G a - γ; either may be left out.
template <int D>
void moving_rows(const Model<D>& model, const Pose<D>& pose, const Motion<D>& motion, double* C_dot, double* gamma) {
    for (const Instance& p : model.constraints.instances) {
        const MovingSlots<D> slots(model, p, pose, motion);
        if (p.kind == Kind::coincident) {
            if (C_dot) Eigen::Map<Point<D>>(C_dot + p.row) = slots.x_dot[1] - slots.x_dot[0];
            if (gamma) Eigen::Map<Point<D>>(gamma + p.row) = slots.bias[0] - slots.bias[1];
            continue;
        }
        Point<D> g[most_slots];
        gradient<D>(p, slots.x, g);
        if (C_dot) {
            double rate = 0.0;
            for (int s = 0; s < p.slot_count; ++s) rate += g[s].dot(slots.x_dot[s]);
            C_dot[p.row] = rate;
        }
        if (gamma) {
            double sum = -curvature<D>(p, slots.x, slots.x_dot);
            for (int s = 0; s < p.slot_count; ++s) sum -= g[s].dot(slots.bias[s]);
            gamma[p.row] = sum;
        }
    }
}

// A joint's rows of G in the columns (δr, δθ global) of one body: for each row the force and the moment about the
// centre of mass that a unit multiplier takes from the body. `G` has at least joint.rows rows.
template <int D, class Rows>
void jacobian(const Model<D>& model, const Pose<D>& pose, const Joint& joint, int body, Rows&& G) {
    G.topRows(joint.rows).setZero();
    for (int i = joint.begin; i < joint.end; ++i) {
        const Instance& p = model.constraints.instances[i];
        const int row = p.row - joint.row;
        const Slots<D> slots(p, pose);
        Point<D> g[most_slots];
        if (p.kind != Kind::coincident) gradient<D>(p, slots.x, g);
        for (int s = 0; s < p.slot_count; ++s) {
            const Attachment<D>& a = model.constraints.attachments[p.slots[s]];
            if (a.body != body) continue;
            if (p.kind == Kind::coincident) {
                const double sign = s == 1 ? 1.0 : -1.0;
                G.template block<D, D>(row, 0) += sign * Rotation<D>::Identity();
                for (int k = 0; k < D; ++k)
                    G.template block<1, Size<D>::turns>(row + k, D) +=
                        sign * moment(pose.spoke(p.slots[s]), Point<D>::Unit(k)).transpose();
            } else {
                if (a.is_point) G.template block<1, D>(row, 0) += g[s].transpose();
                G.template block<1, Size<D>::turns>(row, D) += moment(pose.spoke(p.slots[s]), g[s]).transpose();
            }
        }
    }
}

}  // namespace mbproj
