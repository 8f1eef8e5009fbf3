// The angle of x2 about x0 × x1, from x0 towards x1, as in mbproj.joints.primitives.basic.
#pragma once

#include "model/dimension.hpp"

namespace mbproj {

// The angle plus the whole turns that bring it closest to the expected value.
template <class S> inline S near(const S& angle, const S& expected) {
    return angle + 2.0 * M_PI * nearbyint((expected - angle) / (2.0 * M_PI));
}

// A joint's angle as a direction (cosine, sine), and its rate.
template <class S> struct JointAngle {
    S cosine = 1.0, sine = 0.0, speed = 0.0;
    S value() const { return atan2(sine, cosine); }
};

namespace angle {
template <class D> Scalar<D> value(const Point<D>* x) { return atan2(x[2].dot(x[1]), x[2].dot(x[0])); }
template <class D> void gradient(const Point<D>* x, Point<D>* g) {
    const Scalar<D> cosine = x[2].dot(x[0]), sine = x[2].dot(x[1]);
    const Scalar<D> radius2 = cosine * cosine + sine * sine;
    const Scalar<D> s = sine / radius2, c = cosine / radius2;
    g[0] = -s * x[2];
    g[1] = c * x[2];
    g[2] = c * x[1] - s * x[0];
}
template <class D> Scalar<D> curvature(const Point<D>* x, const Point<D>* v) {
    const Scalar<D> cosine = x[2].dot(x[0]), sine = x[2].dot(x[1]);
    const Scalar<D> radius2 = cosine * cosine + sine * sine;
    const Scalar<D> cosine_dot = v[2].dot(x[0]) + x[2].dot(v[0]), sine_dot = v[2].dot(x[1]) + x[2].dot(v[1]);
    const Scalar<D> bend = 2.0 * (cosine * v[2].dot(v[1]) - sine * v[2].dot(v[0])) / radius2;
    const Scalar<D> rate = (cosine * sine_dot - sine * cosine_dot) / radius2;
    const Scalar<D> stretch = (cosine * cosine_dot + sine * sine_dot) / radius2;
    return bend - 2.0 * rate * stretch;
}
}  // namespace angle

}  // namespace mbproj
