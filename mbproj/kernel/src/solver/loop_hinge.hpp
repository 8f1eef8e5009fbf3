// The joint by which a body of a loop moves, from the ground or from another body of the loops, its parent:
//     δ = X δ_parent + N z + p.
// X moves the child as a part of the parent, the k columns of N are the motions that the joint leaves free, with the
// unknowns z, and p meets the right-hand sides of the joint's rows. So these rows need not be rows of S = G W⁻¹ Gᵀ.
//
// Motions are columns (F,), a translation and a rotation: displacements (m, rad), velocities or accelerations. F is 6 in
// space and 3 in a plane. Forces are wrenches (F,), a force and a moment. Both are about the centre of mass of their
// body, in global axes.
#pragma once

#include "solver/articulated_body.hpp"
#include "solver/hinge_multipliers.hpp"

namespace mbproj {

template <class D> class LoopHinge final {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;
    using Twist = Column<F>;

    LoopHinge(int joint, const Hinge<D>& hinge) : joint_(joint), hinge_(hinge) {}

    // The fewest freedoms that a hinge to the ground has to take away to be worth it: half of them.
    static constexpr int fewest_taken = (F + 1) / 2;

    int joint() const { return joint_; }
    int child() const { return hinge_.child; }
    int parent() const { return hinge_.parent; }  // the number of bodies: the ground
    // The number of columns of N.
    int freedoms() const { return hinge_.free_translations() + hinge_.free_rotations(); }

    // Sets the pose of all that follows. False where the joint's rows are dependent there.
    bool set_pose(const Model<D>& model, const Pose<D>& pose) { return frame_.update(model, hinge_, pose); }

    // Column k of N: first the free translations, then the free rotations about the joint's point.
    Twist free_motion(int k) const {
        Twist n = Twist::Zero();
        if (k < hinge_.free_translations())
            n.template head<D::axes>() = frame_.N_t.col(k);
        else
            n.template tail<S::turns>() = frame_.N_r.col(k - hinge_.free_translations());
        return at_centre(n);
    }
    // The motion p for the right-hand sides c of all rows of the model: the smallest one at the joint's point.
    Twist particular(const Model<D>& model, const double* c) const {
        return at_centre(mbproj::particular(model, hinge_, frame_, c));
    }
    // X δ_parent: the motion of the child as a part of its parent.
    Twist with_parent(Twist parent) const {
        parent.template head<D::axes>() += turned_by(Turn<D>(parent.template tail<S::turns>()), link());
        return parent;
    }
    // Xᵀ f and Xᵀ M X: a wrench on the child, and its inertia, as its parent feels them.
    Twist at_parent(Twist force) const {
        force.template tail<S::turns>() += moment(link(), Point<D>(force.template head<D::axes>()));
        return force;
    }
    Inertia<D> at_parent(Inertia<D> M) const {
        M.move(link());
        return M;
    }
    // Writes λ of the joint's rows into `lambda`, which has all rows, from the wrench -Gᵀλ of the joint on the child.
    void multipliers(const Model<D>& model, Twist wrench, double* lambda) const {
        wrench.template tail<S::turns>() -= moment(frame_.child_arm, Point<D>(wrench.template head<D::axes>()));
        hinge_multipliers<D>(model, hinge_, frame_, wrench, lambda);
    }

private:
    // From the parent's centre of mass to the child's, by way of the joint's point. Where the joint is a little open
    // the gap does not count: X is that of the closed joint.
    Point<D> link() const { return frame_.parent_arm - frame_.child_arm; }
    // A motion at the joint's point as one at the child's centre of mass.
    Twist at_centre(Twist at_joint) const {
        at_joint.template head<D::axes>() -= turned_by(Turn<D>(at_joint.template tail<S::turns>()), frame_.child_arm);
        return at_joint;
    }

    int joint_;
    Hinge<D> hinge_;
    HingeFrame<D> frame_;
};

}  // namespace mbproj
