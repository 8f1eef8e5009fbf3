// A coordinate at a state, of a joint, a force or a stop: a primitive with one value that is no row of the constraints.
#pragma once

#include "kinematics/pose.hpp"
#include "kinematics/primitives.hpp"

namespace mbproj {

// A coordinate of a set at a pose, with its gradient at each attachment.
template <class D> struct Coordinate {
    const PrimitiveSet<D>& set;
    const Instance<D>& p;
    Point<D> x[most_slots], spoke[most_slots], g[most_slots];

    Coordinate(const PrimitiveSet<D>& coordinates, int number, const Pose<D>& pose)
        : set(coordinates), p(set.instances[number]) {
        x[3].setZero();  // few instances have this slot
        for (int s = 0; s < p.slot_count; ++s) {
            const Attachment<D>& a = attachment(s);
            spoke[s] = pose[a.body].rotation * a.local;
            x[s] = a.is_point ? Point<D>(pose[a.body].position + spoke[s]) : spoke[s];
        }
        if (p.on_line()) touch_ = on_curve::touch<D>(p, x, pose.piece(p.follower), pose.piece(p.other_follower));
        gradient<D>(p, x, g, known());
    }
    // The parameter of the foot on the curve that it follows, or on the second of two curves.
    Scalar<D> foot(bool second) const { return second ? touch_.other.s : touch_.foot.s; }
    const Attachment<D>& attachment(int s) const { return set.attachments[p.slots[s]]; }
    Scalar<D> value() const { return mbproj::value<D>(p, x, known()); }
    // The value, for an angle with the whole turns that bring it nearest to the expected value.
    Scalar<D> value(Scalar<D> expected) const { return is_angle(p.kind) ? near(value(), expected) : value(); }
    template <class Velocity, class Omega> Scalar<D> rate(const Velocity& velocity, const Omega& omega) const {
        Scalar<D> sum = 0.0;
        for (int s = 0; s < p.slot_count; ++s) {
            const Attachment<D>& a = attachment(s);
            const Point<D> turning_velocity = turned_by(omega(a.body), spoke[s]);
            sum += g[s].dot(a.is_point ? Point<D>(velocity(a.body) + turning_velocity) : turning_velocity);
        }
        return sum;
    }
    Scalar<D> rate(const Motion<D>& motion) const {
        return rate([&](int b) { return motion[b].velocity; }, [&](int b) { return motion[b].omega; });
    }
    // The part of its second derivative that contains no accelerations of bodies.
    Scalar<D> bend(const Motion<D>& motion) const {
        Point<D> x_dot[most_slots];
        Scalar<D> sum = 0.0;
        for (int s = 0; s < p.slot_count; ++s) {
            const Attachment<D>& a = attachment(s);
            const Twist<D>& twist = motion[a.body];
            const Point<D> turning_velocity = turned_by(twist.omega, spoke[s]);
            sum += g[s].dot(turned_by(twist.omega, turning_velocity));
            x_dot[s] = a.is_point ? Point<D>(twist.velocity + turning_velocity) : turning_velocity;
        }
        return sum + curvature<D>(p, x, x_dot, known());
    }

private:
    const Touch<D>* known() const { return p.on_line() ? &touch_ : nullptr; }

    Touch<D> touch_;
};

// The angle of a joint coordinate that is one.
template <class D>
JointAngle<Scalar<D>> joint_angle(const Model<D>& model, const Pose<D>& pose, const Motion<D>& motion, int coordinate) {
    const Instance<D>& p = model.coordinates.instances[coordinate];
    if (p.kind == Kind::lap) {
        const Coordinate<D> lap(model.coordinates, coordinate, pose);
        return {cos(lap.value()), sin(lap.value()), lap.rate(motion)};
    }
    Point<D> x[3], x_dot[3];
    for (int s = 0; s < 3; ++s) {
        const Attachment<D>& a = model.coordinates.attachments[p.slots[s]];
        x[s] = pose[a.body].rotation * a.local;
        x_dot[s] = turned_by(motion[a.body].omega, x[s]);
    }
    const Scalar<D> cosine = x[2].dot(x[0]), sine = x[2].dot(x[1]);
    const Scalar<D> cosine_dot = x_dot[2].dot(x[0]) + x[2].dot(x_dot[0]);
    const Scalar<D> sine_dot = x_dot[2].dot(x[1]) + x[2].dot(x_dot[1]);
    return {cosine, sine, (cosine * sine_dot - sine * cosine_dot) / (cosine * cosine + sine * sine)};
}

}  // namespace mbproj
