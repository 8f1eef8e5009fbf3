// Finds leaves that would cost their parents digits. The articulated inertia of a leaf is a difference: the child's
// inertia about its free axes cancels up to round-off, which must be small beside the parent's own inertia.
#pragma once

#include "model/decompositions.hpp"
#include "solver/articulated_body.hpp"

namespace mbproj {

template <class D> class InertiaCancellation final {
public:
    using S = Size<D>;
    using Turning = Matrix<S::turns, S::turns>;

    explicit InertiaCancellation(const Model<D>& model) : model_(model), turned_(model.size(), 0.0) {
        for (const Body<D>& body : model.bodies) carried_.push_back(body.mass);
    }

    // Whether the child's round-off takes more than half of its parent's digits.
    bool cancels_parent_inertia(const Hinge<D>& hinge) const {
        if (hinge.parent == model_.size() || model_.bodies[hinge.parent].is_light) return false;
        const double most = 1.0 / model_.thresholds.half_digits;
        const bool slides = hinge.free_translations() > 0, turns = hinge.free_rotations() > 0;
        return (slides && carried_[hinge.child] > most * carried_[hinge.parent]) ||
               (turns && about_joint(hinge) > most * left_to_parent(hinge));
    }
    // The leaf is eliminated: its parent carries it.
    void take_over(const Hinge<D>& hinge) {
        if (hinge.parent == model_.size()) return;
        turned_[hinge.parent] += about_joint(hinge);
        carried_[hinge.parent] += carried_[hinge.child];
    }

private:
    // The moments of inertia at the joint: a body's own, and that of a mass at its centre.
    Turning moments(int body, double mass, int point) const {
        Inertia<D> M;
        M.set(mass, model_.bodies[body].inertia, model_.constraints.attachments[point].local);
        return M.C;
    }
    double about_joint(const Hinge<D>& hinge) const {
        const int point = hinge.sign > 0.0 ? hinge.p2 : hinge.p1;
        return turned_[hinge.child] + moments(hinge.child, carried_[hinge.child], point).norm();
    }
    // The smallest inertia of the parent about the axes that can turn, with the mass that it has to move there.
    double left_to_parent(const Hinge<D>& hinge) const {
        const int point = hinge.sign > 0.0 ? hinge.p1 : hinge.p2;
        const Turning M = moments(hinge.parent, carried_[hinge.child], point);
        if constexpr (D::axes == 3)
            if (hinge.rotation_count == 2) {
                const Point<D> axis = free_axis(hinge);
                return axis.dot(M * axis);
            }
        return 1.0 / norm_of_inverse(values_of(M));
    }
    // The free axis of a revolute in the parent's axes: its vector, if common to both rows, or the normal to its two.
    Point<D> free_axis(const Hinge<D>& hinge) const {
        Point<D> vectors[2];
        int slots[2];
        for (int k = 0; k < 2; ++k) {
            const Instance<D>& row = model_.constraints.instances[hinge.rotations[k]];
            slots[k] = row.slots[model_.constraints.attachments[row.slots[0]].body == hinge.parent ? 0 : 1];
            vectors[k] = model_.constraints.attachments[slots[k]].local;
        }
        return slots[0] == slots[1] ? vectors[0].normalized() : vectors[0].cross(vectors[1]).normalized();
    }

    const Model<D>& model_;
    std::vector<double> carried_, turned_;  // masses and moments, with those of the leaves eliminated
};

}  // namespace mbproj
