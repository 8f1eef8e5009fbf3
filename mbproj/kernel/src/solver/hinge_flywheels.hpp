// Flywheels that a hinge's free motions turn, and stiff forces along them, which act as flywheels in an implicit stage.
// In the hinge's basis one free motion turns each flywheel, whose inertia adds to that of the motion.
#pragma once

#include "kinematics/compliant_rows.hpp"
#include "solver/hinge.hpp"

namespace mbproj {

template <class D> class HingeFlywheels final {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;
    using Twist = Column<F>;

    HingeFlywheels(const Hinge<D>& hinge, std::vector<int> joints) : hinge_(hinge), joints_(std::move(joints)) {
        turned_.resize(joints_.size());
    }

    // Whether a coordinate depends on a hinge's free motions alone: an angle, or a displacement between its own points.
    static bool fits(const Model<D>& model, const Hinge<D>& hinge, const Joint& flywheel) {
        if (flywheel.bushing >= 0) return false;
        const auto& attachments = model.constraints.attachments;
        const Instance<D>& p = model.constraints.instances[flywheel.begin];
        for (int s = 0; s < p.slot_count; ++s)
            if (const int body = attachments[p.slots[s]].body; body != hinge.child && body != hinge.parent)
                return false;
        const auto same = [&](int a, int b) {
            return attachments[a].body == attachments[b].body && attachments[a].local == attachments[b].local;
        };
        if (p.kind == Kind::angle) return hinge.free_rotations() == 1 || hinge.free_rotations() == 2;
        return p.kind == Kind::along && !hinge.coincident && hinge.free_translations() > 0 &&
               attachments[p.slots[0]].body == attachments[p.slots[1]].body && same(p.slots[1], hinge.p1) &&
               same(p.slots[2], hinge.p2);
    }
    // Whether each of these coordinates of a hinge can have a free motion of its own.
    static bool fit(const Model<D>& model, const Hinge<D>& hinge, const std::vector<int>& joints) {
        int angles = 0;
        for (const int j : joints) {
            if (!fits(model, hinge, model.joints[j])) return false;
            angles += model.constraints.instances[model.joints[j].begin].kind == Kind::angle;
        }
        return angles <= hinge.free_rotations() &&
               static_cast<int>(joints.size()) - angles <= hinge.free_translations();
    }

    // Sets the coordinates at a pose, as rates by the relative twist at the joint's point, and turns the basis of the free
    // motions. False where no free motion changes a coordinate. Without `compliance` there are no stiff forces.
    bool update(const Model<D>& model, const Pose<D>& pose, HingeFrame<D>& frame, const Compliance<D>* compliance) {
        Turned* angles[F];
        Turned* shifts[F];
        int angle_count = 0, shift_count = 0;
        for (std::size_t k = 0; k < turned_.size(); ++k) {
            const Joint& joint = model.joints[joints_[k]];
            Matrix<6, F> G;  // room for the most rows of a joint; this one has one
            jacobian<D>(model, pose, joint, hinge_.child, G);
            Turned& turned = turned_[k];
            turned.row = joint.row;
            turned.is_flywheel = !model.is_compliant(joints_[k]);
            if (turned.is_flywheel)
                turned.inertia = model.flywheels[joint.row - model.constraints.rows];
            else
                turned.inertia = compliance ? compliance->weight(joints_[k]) : 0.0;
            turned.rate = G.row(0).transpose();
            turned.rate.template tail<S::turns>() -=
                moment(frame.child_arm, Point<D>(turned.rate.template head<D::axes>()));
            const bool is_angle = model.constraints.instances[joint.begin].kind == Kind::angle;
            (is_angle ? angles[angle_count++] : shifts[shift_count++]) = &turned;
        }
        std::fill(added_, added_ + F, 0.0);
        return align<D::axes, 0>(frame.N_t, hinge_.free_translations(), shifts, shift_count, 0) &&
               align<S::turns, D::axes>(frame.N_r, hinge_.free_rotations(), angles, angle_count,
                                        hinge_.free_translations());
    }

    // The addition to nᵀ M n of each free motion.
    const double* added() const { return added_; }

    // The addition to nᵀ g of each free motion, from the right-hand sides c and the joint's particular motion p.
    void push(const double* c, const Twist& p, double* pushed) const {
        std::fill(pushed, pushed + F, 0.0);
        for (const Turned& t : turned_) pushed[t.motion] = t.inertia * t.ratio * (c[t.row] - t.rate.dot(p));
    }

    // The wrench of the flywheels on the child, Σ -μ rate. It is all of the wrench along the free motions, where joints
    // exert no force. Adds Σ I s'² = Σ μ² / I to `energy`, where δ is a velocity.
    Twist pull(const HingeFrame<D>& frame, const Twist& wrench, double* lambda, double& energy) const {
        Twist found = Twist::Zero();
        const int shifts = hinge_.free_translations();
        for (const Turned& t : turned_) {
            const double along = t.motion < shifts
                                     ? frame.N_t.col(t.motion).dot(wrench.template head<D::axes>())
                                     : frame.N_r.col(t.motion - shifts).dot(wrench.template tail<S::turns>());
            const double mu = -along / t.ratio;
            if (t.is_flywheel) energy += mu * mu / t.inertia;
            found -= mu * t.rate;
            if (lambda) lambda[t.row] = mu;
        }
        return found;
    }

private:
    struct Turned {
        Twist rate;  // the rate of the coordinate by the relative twist at the joint's point
        int row = 0, motion = 0;
        bool is_flywheel = true;
        double inertia = 0.0, ratio = 0.0;  // `ratio`: its rate over that of the free motion
    };

    // Changes the basis N: each of `count` coordinates gets a free motion that changes no other coordinate.
    template <int W, int Begin, class Basis> bool align(Basis& N, int free, Turned** turned, int count, int first) {
        if (count == 0) return true;
        const auto rate = [&](int k, int n) { return turned[k]->rate.template segment<W>(Begin).dot(N.col(n)); };
        if (free == 2) {
            const Column<W> a = N.col(0), b = N.col(1);
            const double u = rate(0, 0), v = rate(0, 1);
            const double x = count == 2 ? rate(1, 0) : -v, y = count == 2 ? rate(1, 1) : u;
            const double volume = u * y - v * x;
            if (!(volume != 0.0)) return false;
            N.col(0) = (y * a - x * b) / volume;
            N.col(1) = (u * b - v * a) / volume;
        }
        for (int k = 0; k < count; ++k) {
            turned[k]->motion = first + k;
            turned[k]->ratio = rate(k, k);
            if (!(turned[k]->ratio != 0.0)) return false;
            added_[first + k] = turned[k]->inertia * turned[k]->ratio * turned[k]->ratio;
        }
        return true;
    }

    Hinge<D> hinge_;
    std::vector<int> joints_;
    std::vector<Turned> turned_;
    double added_[F] = {};
};

}  // namespace mbproj
