// A flat face on a closed convex curve: its distance, and where it touches. The definitions are those of
// mbproj.joints.primitives.plane_curves, which explains them.
#pragma once

#include "model/model.hpp"

namespace mbproj {

// The geometry at the foot of a point, or of a face: the curve's point c, the unit tangent t, the distance φ to the left, the
// curvature κ, and its derivative by the arc length.
template <class D> struct Touch {
    Foot<Scalar<D>> foot;
    Scalar<D> c[2], t[2], phi, kappa, kappa_sigma;
    // For two curves that touch, the second one: its foot, the components of its point along t and n, and its curvature.
    Foot<Scalar<D>> other;
    Scalar<D> q_t, q_n, other_kappa, other_kappa_sigma;
    // For a space curve: its derivatives at the foot, and the line to the point.
    OnSpacePiece<Scalar<D>> space;
    Scalar<D> line[3];

    Scalar<D> stretch() const { return 1.0 - kappa * phi; }
    Scalar<D> side() const { return kappa < 0.0 ? -1.0 : 1.0; }
};

// A slip whose slid distance is `way`: its value is 0, its derivatives are those of `way`.
template <class S> S slipped(const S& way) { return way - value_of(way); }

namespace on_face {

// (a, b) = (u·m, w·m), its size r, and c - d along the tangent and across it, with d = (u·ℓ, w·ℓ).
template <class D> struct Seen {
    Point<D> line;
    Scalar<D> a, b, r, along, across;

    Seen(const Point<D>* x, const Touch<D>& at)
        : line(x[4] - x[3]), a(x[0].dot(x[2])), b(x[1].dot(x[2])), r(sqrt(a * a + b * b)) {
        const Scalar<D> apart[2] = {at.c[0] - x[0].dot(line), at.c[1] - x[1].dot(line)};
        along = at.t[0] * apart[0] + at.t[1] * apart[1];
        across = at.t[0] * apart[1] - at.t[1] * apart[0];
    }
};

template <class D> Scalar<D> value(const Instance<D>& p, const Point<D>* x, const Touch<D>& at) {
    const Seen<D> seen(x, at);
    if (p.kind == Kind::face_place) return seen.along;
    if (p.kind == Kind::face_slip) return slipped(Scalar<D>(p.line->length_at(at.foot) - seen.along));
    return x[2].dot(seen.line) - at.c[0] * seen.a - at.c[1] * seen.b;
}

template <class D> void gradient(const Instance<D>& p, const Point<D>* x, const Touch<D>& at, Point<D>* g) {
    const Seen<D> seen(x, at);
    if (p.kind == Kind::face) {
        g[0] = -at.c[0] * x[2];
        g[1] = -at.c[1] * x[2];
        g[2] = seen.line - at.c[0] * x[0] - at.c[1] * x[1];
        g[3] = -x[2];
        g[4] = x[2];
        return;
    }
    const bool slips = p.kind == Kind::face_slip;
    const Scalar<D> turned = at.side() * (slips ? -seen.across : seen.across + 1.0 / at.kappa) / seen.r;
    const double sign = slips ? -1.0 : 1.0;
    const Point<D> own = turned * x[2] - sign * seen.line, along = at.t[0] * x[0] + at.t[1] * x[1];
    g[0] = at.t[0] * own;
    g[1] = at.t[1] * own;
    g[2] = turned * along;
    g[3] = sign * along;
    g[4] = -sign * along;
}

template <class D> Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* v, const Touch<D>& at) {
    const Seen<D> seen(x, at);
    const Scalar<D> a_dot = v[0].dot(x[2]) + x[0].dot(v[2]), b_dot = v[1].dot(x[2]) + x[1].dot(v[2]);
    const Scalar<D> omega = at.side() * (at.t[0] * a_dot + at.t[1] * b_dot) / seen.r;
    const Point<D> rate = v[4] - v[3];
    if (p.kind == Kind::face) {
        const Scalar<D> bent = 2.0 * v[2].dot(Point<D>(rate - at.c[0] * v[0] - at.c[1] * v[1]));
        return bent - seen.r * omega * omega / abs(at.kappa);
    }
    const Scalar<D> growth = (a_dot * seen.a + b_dot * seen.b) / seen.r;
    const Scalar<D> bent = 2.0 * at.side() * (at.t[0] * v[0].dot(v[2]) + at.t[1] * v[1].dot(v[2]));
    const Scalar<D> omega_bias = (bent - 2.0 * omega * growth) / seen.r;
    const Scalar<D> d_dot[2] = {v[0].dot(seen.line) + x[0].dot(rate), v[1].dot(seen.line) + x[1].dot(rate)};
    const Scalar<D> across = 2.0 * (at.t[0] * d_dot[1] - at.t[1] * d_dot[0]) + omega * seen.along;
    const Scalar<D> bias = 2.0 * (at.t[0] * v[0].dot(rate) + at.t[1] * v[1].dot(rate));
    if (p.kind == Kind::face_slip) return bias + omega * across - omega_bias * seen.across;
    const Scalar<D> kappa3 = at.kappa * at.kappa * at.kappa;
    return omega_bias * (seen.across + 1.0 / at.kappa) - omega * (across + omega * at.kappa_sigma / kappa3) - bias;
}

}  // namespace on_face
}  // namespace mbproj
