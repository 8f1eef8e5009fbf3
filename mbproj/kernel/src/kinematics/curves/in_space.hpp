// Points that follow a space curve: their distance beside the curve, and their arc length along it. The definitions are those of
// mbproj.joints.primitives.space_curves, which explains them.
#pragma once

#include "kinematics/curves/on_face.hpp"

namespace mbproj {
namespace in_space {

template <class D> Touch<D> touch(const Instance<D>& p, const Point<D>* x, int held) {
    const Point<D> line = x[4] - x[3];
    const Scalar<D> d[3] = {x[0].dot(line), x[1].dot(line), x[2].dot(line)};
    Touch<D> found{};
    found.foot = p.wire->foot(d, held);
    found.space = p.wire->derivatives(found.foot.s, found.foot.piece);
    for (int k = 0; k < 3; ++k) found.line[k] = d[k] - found.space.c[0][k];
    return found;
}

// A unit vector along n and its two derivatives, from those of n.
template <class S> struct Unit {
    S e[3][3];
    Unit(const S* n, const S* n1, const S* n2) {
        const S size = sqrt(inner(n, n));
        for (int k = 0; k < 3; ++k) e[0][k] = n[k] / size;
        const S grows = inner(e[0], n1);
        for (int k = 0; k < 3; ++k) e[1][k] = (n1[k] - e[0][k] * grows) / size;
        const S bends = inner(e[1], n1) + inner(e[0], n2);
        for (int k = 0; k < 3; ++k) e[2][k] = (n2[k] - 2.0 * e[1][k] * grows - e[0][k] * bends) / size;
    }
};

// The normal of an instance and its two derivatives by the curve's parameter.
template <class D> Unit<Scalar<D>> normal(const Instance<D>& p, const Touch<D>& at) {
    using S = Scalar<D>;
    const double* direction = p.wire->pieces[at.foot.piece].axis;
    const S a[3] = {direction[0], direction[1], direction[2]};
    S n[3][3];
    for (int k = 0; k < 3; ++k) cross(a, at.space.c[k + 1], n[k]);
    Unit<S> first(n[0], n[1], n[2]);
    if (p.kind == Kind::beside_first) return first;
    const Unit<S> t(at.space.c[1], at.space.c[2], at.space.c[3]);
    Unit<S> second = first;
    S one[3], other[3], last[3];
    cross(t.e[0], first.e[0], second.e[0]);
    cross(t.e[1], first.e[0], one);
    cross(t.e[0], first.e[1], other);
    for (int k = 0; k < 3; ++k) second.e[1][k] = one[k] + other[k];
    cross(t.e[2], first.e[0], one);
    cross(t.e[1], first.e[1], other);
    cross(t.e[0], first.e[2], last);
    for (int k = 0; k < 3; ++k) second.e[2][k] = one[k] + 2.0 * other[k] + last[k];
    return second;
}

// |c'|² - c''·line: s' = c'·d' / left.
template <class D> Scalar<D> left(const Touch<D>& at) {
    return inner(at.space.c[1], at.space.c[1]) - inner(at.space.c[2], at.line);
}

template <class D> Scalar<D> value(const Instance<D>& p, const Touch<D>& at) {
    if (p.kind == Kind::space_arc) return p.wire->length_at(at.foot);
    return inner(normal(p, at).e[0], at.line);
}

template <class D> void gradient(const Instance<D>& p, const Point<D>* x, const Touch<D>& at, Point<D>* g) {
    using S = Scalar<D>;
    S e[3];
    if (p.kind == Kind::space_arc) {
        const S speed = sqrt(inner(at.space.c[1], at.space.c[1]));
        for (int k = 0; k < 3; ++k) e[k] = speed / left(at) * at.space.c[1][k];
    } else {
        const Unit<S> n = normal(p, at);
        const S turns = inner(n.e[1], at.line) / left(at);
        for (int k = 0; k < 3; ++k) e[k] = n.e[0][k] + turns * at.space.c[1][k];
    }
    const Point<D> line = x[4] - x[3];
    for (int k = 0; k < 3; ++k) g[k] = e[k] * line;
    g[4] = e[0] * x[0] + e[1] * x[1] + e[2] * x[2];
    g[3] = -g[4];
}

template <class D> Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* v, const Touch<D>& at) {
    using S = Scalar<D>;
    const Point<D> line = x[4] - x[3], line_dot = v[4] - v[3];
    S rate[3], bias[3];
    for (int k = 0; k < 3; ++k) {
        rate[k] = v[k].dot(line) + x[k].dot(line_dot);
        bias[k] = 2.0 * v[k].dot(line_dot);
    }
    const auto& c = at.space.c;
    const S s_dot = inner(c[1], rate) / left(at);
    const S own = inner(c[1], bias) + 2.0 * s_dot * inner(c[2], rate);
    const S s_bias = (own + s_dot * s_dot * (inner(c[3], at.line) - 3.0 * inner(c[1], c[2]))) / left(at);
    if (p.kind == Kind::space_arc) {
        const S speed = sqrt(inner(c[1], c[1]));
        return speed * s_bias + inner(c[1], c[2]) / speed * s_dot * s_dot;
    }
    const Unit<S> n = normal(p, at);
    return inner(n.e[0], bias) + 2.0 * s_dot * inner(n.e[1], rate) + s_bias * inner(n.e[1], at.line) +
           s_dot * s_dot * (inner(n.e[2], at.line) - inner(n.e[1], c[1]));
}

}  // namespace in_space
}  // namespace mbproj
