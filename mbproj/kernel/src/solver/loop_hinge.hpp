// A hinge inside the loops by which its child moves, from the ground or from a parent: δ = X δ_parent + N z + p. N are the few
// free motions, so the hinge's rows need not be rows of the loops. All is about centres of mass.
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

    // The fewest freedoms that a hinge to the ground has to take away.
    static constexpr int fewest_taken = (F + 1) / 2;

    int joint() const { return joint_; }
    int child() const { return hinge_.child; }
    int parent() const { return hinge_.parent; }  // the number of bodies: the ground
    int freedoms() const { return hinge_.free_translations() + hinge_.free_rotations(); }

    // False where the joint's rows are dependent at this pose.
    bool set_pose(const Model<D>& model, const Pose<D>& pose) { return frame_.update(model, hinge_, pose); }

    // The free motion N_k.
    Twist motion(int k) const {
        Twist n = Twist::Zero();
        if (k < hinge_.free_translations())
            n.template head<D::axes>() = frame_.N_t.col(k);
        else
            n.template tail<S::turns>() = frame_.N_r.col(k - hinge_.free_translations());
        return at_centre(n);
    }
    // The smallest motion at the joint's point that meets right-hand sides.
    Twist particular(const Model<D>& model, const double* c) const {
        return at_centre(mbproj::particular(model, hinge_, frame_, c));
    }
    // X δ: the child moves with its parent.
    Twist carried(Twist parent) const {
        parent.template head<D::axes>() += turned_by(Turn<D>(parent.template tail<S::turns>()), link());
        return parent;
    }
    // Xᵀ f, and Xᵀ M X.
    Twist at_parent(Twist force) const {
        force.template tail<S::turns>() += moment(link(), Point<D>(force.template head<D::axes>()));
        return force;
    }
    Inertia<D> at_parent(Inertia<D> M) const {
        M.move(link());
        return M;
    }
    // λ of the joint's rows from the joint's wrench on the body, -Gᵀλ.
    void multipliers(const Model<D>& model, Twist wrench, double* lambda) const {
        wrench.template tail<S::turns>() -= moment(frame_.child_arm, Point<D>(wrench.template head<D::axes>()));
        hinge_multipliers<D>(model, hinge_, frame_, wrench, lambda);
    }

private:
    // From the parent's centre to the child's, as if the joint were closed.
    Point<D> link() const { return frame_.parent_arm - frame_.child_arm; }
    Twist at_centre(Twist at_joint) const {
        at_joint.template head<D::axes>() -= turned_by(Turn<D>(at_joint.template tail<S::turns>()), frame_.child_arm);
        return at_joint;
    }

    int joint_;
    Hinge<D> hinge_;
    HingeFrame<D> frame_;
};

}  // namespace mbproj
