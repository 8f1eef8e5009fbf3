// An angle of a joint, as the direction in which its vector stands, and how fast it turns.
#pragma once

#include "kinematics/coordinate.hpp"

namespace mbproj {

template <class D> struct JointAngle {
    Scalar<D> cosine = 1.0, sine = 0.0, speed = 0.0;
    Scalar<D> value() const { return atan2(sine, cosine); }
};

// Of a coordinate that is an angle.
template <class D>
JointAngle<D> joint_angle(const Model<D>& model, const Pose<D>& pose, const Motion<D>& motion, int coordinate) {
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
