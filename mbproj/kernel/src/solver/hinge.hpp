// A joint described by its free motions: the relative twist of its two bodies at the joint's point is N z + p. N is a basis of
// the motions that its rows allow, and p the smallest motion that meets its right-hand side.
#pragma once

#include <optional>

#include "kinematics/constraint_rows.hpp"

namespace mbproj {

// A joint whose rows act on the relative translation at one point (coincident; along; distance) and on the relative
// rotation (perpendicular), not on both at once. With a coincident primitive each body's arm ends in its own point, so
// that open joints are treated exactly; otherwise both arms end in p2.
template <class D> struct Hinge {
    int child, parent;  // the parent may be the ground
    double sign;        // +1 where p2 is on the child, -1 where it is on the parent
    int p1, p2;
    bool coincident;
    int translations[D::axes], rotations[Size<D>::turns];  // instances
    int translation_count = 0, rotation_count = 0;         // rows
    int free_translations() const { return D::axes - translation_count; }
    int free_rotations() const { return Size<D>::turns - rotation_count; }
    int taken() const { return translation_count + rotation_count; }
};

// A joint as a hinge with this child, or nothing where its rows do not fit.
template <class D> std::optional<Hinge<D>> as_hinge(const Model<D>& model, const Joint& joint, int child) {
    Hinge<D> hinge{};
    hinge.child = child;
    hinge.p1 = hinge.p2 = -1;
    int seen = 0;
    const auto body_of = [&](int attachment) { return model.constraints.attachments[attachment].body; };
    for (int i = joint.begin; i < joint.end; ++i) {
        const Instance<D>& p = model.constraints.instances[i];
        if (p.coupled) return std::nullopt;
        if (p.kind == Kind::perpendicular) {
            if (hinge.rotation_count == Size<D>::turns) return std::nullopt;
            hinge.rotations[hinge.rotation_count++] = i;
            continue;
        }
        const int first = p.kind == Kind::along ? 1 : 0;
        const bool known = p.kind == Kind::coincident || p.kind == Kind::distance ||
                           (p.kind == Kind::along && body_of(p.slots[0]) == body_of(p.slots[1]));
        const bool one_point = seen == 0 || (p.slots[first] == hinge.p1 && p.slots[first + 1] == hinge.p2);
        if (!known || !one_point || hinge.translation_count + p.rows > D::axes) return std::nullopt;
        hinge.p1 = p.slots[first];
        hinge.p2 = p.slots[first + 1];
        hinge.coincident = p.kind == Kind::coincident;
        hinge.translations[hinge.translation_count] = i;
        hinge.translation_count += p.rows;
        ++seen;
    }
    if (seen == 0) return std::nullopt;
    hinge.sign = body_of(hinge.p2) == child ? 1.0 : -1.0;
    hinge.parent = body_of(hinge.sign > 0.0 ? hinge.p1 : hinge.p2);
    return hinge;
}

// Completes a basis: the vectors normal to up to K rows, and the smallest P with rows · P = 1. False where the rows are parallel,
// judged by the square of their sine.
template <class S>
inline bool complement(const Column<1, S>* rows, int count, Matrix<1, 1, S>& basis, Matrix<1, 1, S>& P, double) {
    basis(0, 0) = 1.0;
    if (count == 1) P(0, 0) = 1.0 / rows[0][0];
    return count == 0 || rows[0][0] != 0.0;
}
template <class S> inline bool complement(const Column<2, S>* rows, int count, Matrix<2, 2, S>& basis,
                                          Matrix<2, 2, S>& P, double parallel) {
    basis.setIdentity();
    if (count == 0) return true;
    const S square = rows[0].squaredNorm();
    if (count == 1) {
        basis.col(0) << -rows[0].y(), rows[0].x();
        P.col(0) = rows[0] / square;
        return square > 0.0;
    }
    const S cross = rows[0].x() * rows[1].y() - rows[0].y() * rows[1].x();
    P << rows[1].y(), -rows[0].y(), -rows[1].x(), rows[0].x();
    P /= cross;
    return cross * cross > parallel * square * rows[1].squaredNorm();
}
// A unit vector normal to v; `parallel`: the square of the sine below which v lies along z.
template <class S> inline Column<3, S> normal_to(const Column<3, S>& v, double parallel) {
    if (v.template head<2>().squaredNorm() > parallel * v.z() * v.z()) {
        const S inverse = 1.0 / v.template head<2>().norm();
        return {-v.y() * inverse, v.x() * inverse, 0.0};
    }
    const S inverse = 1.0 / v.template tail<2>().norm();
    return {0.0, -v.z() * inverse, v.y() * inverse};
}
template <class S> inline bool complement(const Column<3, S>* rows, int count, Matrix<3, 3, S>& basis,
                                          Matrix<3, 3, S>& P, double parallel) {
    if (count == 0) {
        basis.setIdentity();
        return true;
    }
    const S square = rows[0].squaredNorm();
    if (count == 1) {
        basis.col(0) = normal_to(rows[0], parallel);
        basis.col(1) = rows[0].cross(basis.col(0)) / sqrt(square);
        P.col(0) = rows[0] / square;
        return square > 0.0;
    }
    const Column<3, S> normal = rows[0].cross(rows[1]);
    const S normal2 = normal.squaredNorm();
    if (count == 2) {
        basis.col(0) = normal;
        P.col(0) = rows[1].cross(normal) / normal2;
        P.col(1) = normal.cross(rows[0]) / normal2;
        return normal2 > parallel * square * rows[1].squaredNorm();
    }
    const S volume = normal.dot(rows[2]);
    P.col(0) = rows[1].cross(rows[2]) / volume;
    P.col(1) = rows[2].cross(rows[0]) / volume;
    P.col(2) = normal / volume;
    return volume * volume > parallel * normal2 * rows[2].squaredNorm();
}

// A hinge at a pose: arms from the two centres of mass, bases N of the free motions, and the particular motions P.
template <class D> struct HingeFrame {
    using S = Size<D>;
    Point<D> child_arm, parent_arm;
    Matrix<D::axes, D::axes> N_t,
        P_t;  // not set for a coincident joint, whose P_t is the identity
    Matrix<S::turns, S::turns> N_r, P_r;

    [[gnu::always_inline]] bool update(const Model<D>& model, const Hinge<D>& hinge, const Pose<D>& pose) {
        const int child_point = hinge.sign > 0.0 ? hinge.p2 : hinge.p1;
        const int parent_point = hinge.sign > 0.0 ? hinge.p1 : hinge.p2;
        child_arm = pose.spoke(child_point);
        parent_arm = pose.spoke(parent_point);
        bool regular = true;
        const double parallel = model.thresholds.half_digits * model.thresholds.half_digits;
        if (!hinge.coincident) {
            const Point<D> at = pose.place(hinge.p2);
            if (hinge.sign > 0.0)
                parent_arm = at - pose[hinge.parent].position;
            else
                child_arm = at - pose[hinge.child].position;
            Point<D> rows[D::axes];
            for (Point<D>& row : rows) row.setZero();
            for (int k = 0; k < hinge.translation_count; ++k) {
                const Instance<D>& p = model.constraints.instances[hinge.translations[k]];
                rows[k] =
                    p.kind == Kind::along ? pose.place(p.slots[0]) : Point<D>((at - pose.place(hinge.p1)).normalized());
            }
            regular = complement(rows, hinge.translation_count, N_t, P_t, parallel);
        }
        Turn<D> rows[S::turns];
        for (Turn<D>& row : rows) row.setZero();
        for (int k = 0; k < hinge.rotation_count; ++k) {
            const Instance<D>& p = model.constraints.instances[hinge.rotations[k]];
            const int on_child = model.constraints.attachments[p.slots[0]].body == hinge.child ? 0 : 1;
            // The relative rotation counts from body 1 to body 2, as the translation does.
            rows[k] = hinge.sign * moment(pose.place(p.slots[on_child]), pose.place(p.slots[1 - on_child]));
        }
        return complement(rows, hinge.rotation_count, N_r, P_r, parallel) && regular;
    }
};

}  // namespace mbproj
