// The joints' rows: C, C' and γ of Eqs. 2-9, and their gradients as wrenches on the bodies.
#pragma once

#include "kinematics/loads.hpp"
#include "kinematics/pose.hpp"
#include "kinematics/primitives.hpp"

namespace mbproj {

// An instance's points and vectors in global axes.
template <class D> struct Slots {
    Point<D> x[most_slots];
    Slots(const Instance<D>& p, const Pose<D>& pose) {
        x[3].setZero();  // few instances have this slot
        for (int s = 0; s < p.slot_count; ++s) x[s] = pose.place(p.slots[s]);
    }
};

// The motion of an attachment: its velocity, and the part ω × (ω × s) of its acceleration that contains no acceleration of the
// body. It is not stored: in trees each is used once.
template <class D> struct Moving {
    Point<D> x_dot, bias;
    [[gnu::always_inline]] Moving(const Model<D>& model, const Pose<D>& pose, const Motion<D>& motion, int attachment) {
        const Attachment<D>& a = model.constraints.attachments[attachment];
        const Twist<D>& twist = motion[a.body];
        x_dot = turned_by(twist.omega, pose.spoke(attachment));
        bias = turned_by(twist.omega, x_dot);
        if (a.is_point) x_dot += twist.velocity;
    }
};

// C of all rows. Rows that couple coordinates have angles without whole turns: see `Couplings`.
template <class D> void constraint(const Model<D>& model, const Pose<D>& pose, Scalar<D>* C) {
    for (const Instance<D>& p : model.constraints.instances) {
        if (p.kind == Kind::coincident)
            matrix_at<D::axes>(C + p.row) = pose.place(p.slots[1]) - pose.place(p.slots[0]);
        else if (p.kind == Kind::perpendicular)
            C[p.row] = pose.spoke(p.slots[0]).dot(pose.spoke(p.slots[1])) - p.offset;
        else
            C[p.row] = p.weight * value<D>(p, Slots<D>(p, pose).x, pose.touch(p)) - p.offset -
                       (p.curve < 0 ? 0.0 : pose.curve(p.curve).x) + (p.rows ? 0.0 : C[p.row]);
    }
}

// C' and γ of one instance, with C'' = G a - γ.
template <class D> struct RowRates {
    Scalar<D> C_dot, gamma;
};

template <class D>
RowRates<D> row_rates(const Model<D>& model, const Instance<D>& p, const Pose<D>& pose, const Motion<D>& motion) {
    if (p.kind == Kind::perpendicular) {  // the general case below, written out for the most frequent kind
        const Moving<D> first(model, pose, motion, p.slots[0]), second(model, pose, motion, p.slots[1]);
        const Point<D>&a = pose.spoke(p.slots[0]), &b = pose.spoke(p.slots[1]);
        return {b.dot(first.x_dot) + a.dot(second.x_dot),
                -b.dot(first.bias) - a.dot(second.bias) - 2.0 * first.x_dot.dot(second.x_dot)};
    }
    const Slots<D> slots(p, pose);
    Point<D> g[most_slots], x_dot[most_slots];
    gradient<D>(p, slots.x, g, pose.touch(p));
    RowRates<D> found{0.0, 0.0};
    for (int s = 0; s < p.slot_count; ++s) {
        const Moving<D> moving(model, pose, motion, p.slots[s]);
        x_dot[s] = moving.x_dot;
        found.C_dot += g[s].dot(moving.x_dot);
        found.gamma -= g[s].dot(moving.bias);
    }
    found.gamma -= curvature<D>(p, slots.x, x_dot, pose.touch(p));
    const Scalar<D> weight = pose.weight(p), bend = p.curve < 0 ? 0.0 : pose.curve(p.curve).dd;
    return {weight * found.C_dot, weight * found.gamma + bend * found.C_dot * found.C_dot};
}

// C' and γ of all rows; either pointer may be null.
template <class D> void moving_rows(const Model<D>& model, const Pose<D>& pose, const Motion<D>& motion,
                                    Scalar<D>* C_dot, Scalar<D>* gamma) {
    for (const Instance<D>& p : model.constraints.instances) {
        if (p.kind == Kind::coincident) {
            const Moving<D> first(model, pose, motion, p.slots[0]), second(model, pose, motion, p.slots[1]);
            if (C_dot) matrix_at<D::axes>(C_dot + p.row) = second.x_dot - first.x_dot;
            if (gamma) matrix_at<D::axes>(gamma + p.row) = first.bias - second.bias;
            continue;
        }
        const RowRates<D> rates = row_rates(model, p, pose, motion);
        if (C_dot) C_dot[p.row] = rates.C_dot + (p.rows ? 0.0 : C_dot[p.row]);
        if (gamma) gamma[p.row] = rates.gamma + (p.rows ? 0.0 : gamma[p.row]);
    }
}

// A joint's rows of G in the columns (δr, δθ global) of one body: for each row the force and the moment about the centre of mass
// that a unit multiplier takes from the body. `G` has at least joint.rows rows.
template <class D, class Rows>
void jacobian(const Model<D>& model, const Pose<D>& pose, const Joint& joint, int body, Rows&& G) {
    if (joint.bushing >= 0) {
        const auto gradient = Deflection<D>(model.loads->bushings[joint.bushing], pose).gradient(body);
        for (int c = 0; c < gradient.cols(); ++c)
            for (int r = 0; r < gradient.rows(); ++r) G(r, c) = gradient(r, c);
        return;
    }
    for (int r = 0; r < joint.rows; ++r)
        for (int c = 0; c < G.cols(); ++c) G(r, c) = 0.0;
    const auto body_of = [&](int attachment) { return model.constraints.attachments[attachment].body; };
    for (int i = joint.begin; i < joint.end; ++i) {
        const Instance<D>& p = model.constraints.instances[i];
        const int row = p.row - joint.row;
        if (p.kind == Kind::coincident) {
            for (int s = 0; s < 2; ++s)
                if (body_of(p.slots[s]) == body) {
                    const Scalar<D> sign = s == 1 ? 1.0 : -1.0;
                    for (int k = 0; k < D::axes; ++k) {
                        G(row + k, k) += sign;
                        G.template block<1, Size<D>::turns>(row + k, D::axes) +=
                            sign * moment(pose.spoke(p.slots[s]), Point<D>::Unit(k)).transpose();
                    }
                }
        } else if (p.kind == Kind::perpendicular) {
            for (int s = 0; s < 2; ++s)
                if (body_of(p.slots[s]) == body)
                    G.template block<1, Size<D>::turns>(row, D::axes) +=
                        moment(pose.spoke(p.slots[s]), pose.spoke(p.slots[1 - s])).transpose();
        } else {
            Point<D> g[most_slots];
            gradient<D>(p, Slots<D>(p, pose).x, g, pose.touch(p));
            for (int s = 0; s < p.slot_count; ++s) {
                if (body_of(p.slots[s]) != body) continue;
                g[s] *= pose.weight(p);
                if (model.constraints.attachments[p.slots[s]].is_point)
                    G.template block<1, D::axes>(row, 0) += g[s].transpose();
                G.template block<1, Size<D>::turns>(row, D::axes) += moment(pose.spoke(p.slots[s]), g[s]).transpose();
            }
        }
    }
}

}  // namespace mbproj
