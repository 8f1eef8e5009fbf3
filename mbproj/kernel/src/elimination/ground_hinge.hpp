// A body of the loops that a hinge joins to the ground: it moves by δ = N z + p with the few free motions N of that hinge,
// so that its rows need not be among those of the loops. All about the body's centre of mass.
#pragma once

#include "elimination/articulated_body.hpp"
#include "elimination/hinge_multipliers.hpp"

namespace mbproj {

template <int D> class GroundHinge final {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;
    using Twist = Column<F>;

    GroundHinge(int joint, const Hinge<D>& hinge) : joint_(joint), hinge_(hinge) {}

    // Whether a body is joined to the ground so, and whether half of its freedoms at least are taken.
    static bool is_one(const Model<D>& model, const std::optional<Hinge<D>>& hinge) {
        return hinge && hinge->parent == model.size() && 2 * (hinge->translation_count + hinge->rotation_count) >= F;
    }

    int joint() const { return joint_; }
    int body() const { return hinge_.child; }
    int freedoms() const { return hinge_.free_translations() + hinge_.free_rotations(); }

    // False where the joint's rows are dependent at this pose.
    bool set_pose(const Model<D>& model, const Pose<D>& pose) { return frame_.update(model, hinge_, pose); }

    // The free motion N_k.
    Twist motion(int k) const {
        Twist n = Twist::Zero();
        if (k < hinge_.free_translations())
            n.template head<D>() = frame_.N_t.col(k);
        else
            n.template tail<S::turns>() = frame_.N_r.col(k - hinge_.free_translations());
        return at_centre(n);
    }
    // The smallest motion at the joint's point that meets right-hand sides.
    Twist particular(const Model<D>& model, const double* c) const {
        return at_centre(mbproj::particular(model, hinge_, frame_, c));
    }
    // λ of the joint's rows from the wrench that it exerts on the body, -Gᵀλ.
    void multipliers(const Model<D>& model, Twist wrench, double* lambda) const {
        wrench.template tail<S::turns>() -= moment(frame_.child_arm, Point<D>(wrench.template head<D>()));
        hinge_multipliers<D>(model, hinge_, frame_, wrench, lambda);
    }

private:
    Twist at_centre(Twist at_joint) const {
        at_joint.template head<D>() -= turned_by(Turn<D>(at_joint.template tail<S::turns>()), frame_.child_arm);
        return at_joint;
    }

    int joint_;
    Hinge<D> hinge_;
    HingeFrame<D> frame_;
};

}  // namespace mbproj
