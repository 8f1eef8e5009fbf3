// The constraint primitives: value, gradient, and curvature as functions of the points and vectors x of an instance. The
// definitions are those of mbproj.joints.primitives.table, which explains them; a test holds this copy against them.
#pragma once

#include <algorithm>
#include <cmath>

#include "kinematics/angle.hpp"
#include "kinematics/curves/on_curve.hpp"
#include "kinematics/on_rope.hpp"
#include "kinematics/rolling.hpp"

namespace mbproj {

namespace along {
template <class D> Scalar<D> value(const Point<D>* x) { return x[0].dot(x[2] - x[1]); }
template <class D> void gradient(const Point<D>* x, Point<D>* g) {
    g[0] = x[2] - x[1];
    g[1] = -x[0];
    g[2] = x[0];
}
template <class D> Scalar<D> curvature(const Point<D>* x_dot) { return 2.0 * value<D>(x_dot); }
}  // namespace along

// The angle without its whole turns, within [-π, π].
template <class S> inline S nearest(const S& angle) { return angle - 2.0 * M_PI * nearbyint(angle / (2.0 * M_PI)); }

// The contact of an instance with its curve: the `known` one, or the one that follows from x.
template <class D> Touch<D> touched(const Instance<D>& p, const Point<D>* x, const Touch<D>* known) {
    return known ? *known : on_curve::touch<D>(p, x);
}

// The primitives of curves, ropes and rolling.
namespace outline {

template <class D> Scalar<D> value(const Instance<D>& p, const Point<D>* x, const Touch<D>* known) {
    if (p.on_line()) return on_curve::value<D>(p, x, touched<D>(p, x, known));
    return p.kind == Kind::rope ? on_rope::value<D>(p, x) : rolling::value<D>(p, x);
}
template <class D> void gradient(const Instance<D>& p, const Point<D>* x, Point<D>* g, const Touch<D>* known) {
    if (p.on_line()) return on_curve::gradient<D>(p, x, touched<D>(p, x, known), g);
    p.kind == Kind::rope ? on_rope::gradient<D>(p, x, g) : rolling::gradient<D>(p, x, g);
}
template <class D>
Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* x_dot, const Touch<D>* known) {
    if (p.on_line()) return on_curve::curvature<D>(p, x, x_dot, touched<D>(p, x, known));
    return p.kind == Kind::rope ? on_rope::curvature<D>(p, x, x_dot) : rolling::curvature<D>(p, x, x_dot);
}

}  // namespace outline

// Compiled once: few mechanisms have any.
extern template double outline::value<Plane<double>>(const Instance<Plane<double>>&, const Point<Plane<double>>*,
                                                     const Touch<Plane<double>>*);
extern template void outline::gradient<Plane<double>>(const Instance<Plane<double>>&, const Point<Plane<double>>*,
                                                      Point<Plane<double>>*, const Touch<Plane<double>>*);
extern template double outline::curvature<Plane<double>>(const Instance<Plane<double>>&, const Point<Plane<double>>*,
                                                         const Point<Plane<double>>*, const Touch<Plane<double>>*);
extern template Touch<Plane<double>> on_curve::touch<Plane<double>>(const Instance<Plane<double>>&,
                                                                    const Point<Plane<double>>*, int, int);
extern template double outline::value<Space<double>>(const Instance<Space<double>>&, const Point<Space<double>>*,
                                                     const Touch<Space<double>>*);
extern template void outline::gradient<Space<double>>(const Instance<Space<double>>&, const Point<Space<double>>*,
                                                      Point<Space<double>>*, const Touch<Space<double>>*);
extern template double outline::curvature<Space<double>>(const Instance<Space<double>>&, const Point<Space<double>>*,
                                                         const Point<Space<double>>*, const Touch<Space<double>>*);
extern template Touch<Space<double>> on_curve::touch<Space<double>>(const Instance<Space<double>>&,
                                                                    const Point<Space<double>>*, int, int);

// The value of a primitive with one row, before its offset. `known` is its contact with a curve.
template <class D> Scalar<D> value(const Instance<D>& p, const Point<D>* x, const Touch<D>* known = nullptr) {
    switch (p.kind) {
        case Kind::perpendicular: return x[0].dot(x[1]);
        case Kind::along: return along::value<D>(x);
        case Kind::distance: return (x[1] - x[0]).norm();
        case Kind::angle: return angle::value<D>(x);
        case Kind::coincident: return 0.0;
        default: return outline::value<D>(p, x, known);
    }
}

// Its gradient, a vector for each slot.
template <class D>
void gradient(const Instance<D>& p, const Point<D>* x, Point<D>* g, const Touch<D>* known = nullptr) {
    switch (p.kind) {
        case Kind::perpendicular:
            g[0] = x[1];
            g[1] = x[0];
            break;
        case Kind::along: along::gradient<D>(x, g); break;
        case Kind::distance:
            g[1] = (x[1] - x[0]).normalized();
            g[0] = -g[1];
            break;
        case Kind::angle: angle::gradient<D>(x, g); break;
        case Kind::coincident: break;
        default: outline::gradient<D>(p, x, g, known);
    }
}

// x'ᵀ C_xx x'.
template <class D>
Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* x_dot, const Touch<D>* known = nullptr) {
    switch (p.kind) {
        case Kind::perpendicular: return 2.0 * x_dot[0].dot(x_dot[1]);
        case Kind::along: return along::curvature<D>(x_dot);
        case Kind::distance: {
            const Point<D> line = x[1] - x[0], rate = x_dot[1] - x_dot[0];
            const Scalar<D> length = line.norm(), stretch = line.dot(rate) / length;
            return (rate.squaredNorm() - stretch * stretch) / length;
        }
        case Kind::angle: return angle::curvature<D>(x, x_dot);
        case Kind::coincident: return 0.0;
        default: return outline::curvature<D>(p, x, x_dot, known);
    }
}

}  // namespace mbproj
