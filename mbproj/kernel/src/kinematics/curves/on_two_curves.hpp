// Two curves that touch: their distance, and the arc length of the contact along each. The definitions are those of
// mbproj.joints.primitives.plane_curves, which explains them.
#pragma once

#include "kinematics/angle.hpp"
#include "kinematics/curves/on_face.hpp"

namespace mbproj {

// At a place of a curve: its speed, its curvature, and the derivative of the curvature by the arc length.
template <class S> struct Bend {
    S speed, kappa, kappa_sigma;
    explicit Bend(const OnPiece<S>& c) {
        const S speed2 = c.x[1] * c.x[1] + c.y[1] * c.y[1];
        const S turn = c.x[1] * c.y[2] - c.y[1] * c.x[2], turn_s = c.x[1] * c.y[3] - c.y[1] * c.x[3];
        const S stretch = c.x[1] * c.x[2] + c.y[1] * c.y[2];
        speed = sqrt(speed2);
        kappa = turn / (speed2 * speed);
        kappa_sigma = (turn_s - 3.0 * turn * stretch / speed2) / (speed2 * speed2);
    }
};

namespace on_two_curves {

template <class D> Scalar<D> sense(const Instance<D>& p) { return -p.parameters[0] * p.parameters[1]; }

template <class D> Touch<D> touch(const Instance<D>& p, const Point<D>* x, int held, int other_held) {
    using S = Scalar<D>;
    const Point<D> line = x[4] - x[3];
    const S across = x[2].dot(x[1]), along = x[2].dot(x[0]), size = sqrt(across * across + along * along);
    const SecondCurve<S> lies{x[0].dot(line), x[1].dot(line), along / size, across / size,
                              value_of(p.parameters[0] * p.parameters[1]) > 0.0};
    const TwoFeet<S> feet = touching(*p.line, *p.other, lies, held, other_held);
    Touch<D> found{};
    found.foot = feet.first;
    found.other = feet.second;
    const OnPiece<S> c = p.line->derivatives(feet.first.s, feet.first.piece);
    const OnPiece<S> other = p.other->derivatives(feet.second.s, feet.second.piece);
    const Bend<S> bend(c), second(other);
    const S qx = lies.turned_x(other.x[0], other.y[0]), qy = lies.turned_y(other.x[0], other.y[0]);
    found.c[0] = c.x[0];
    found.c[1] = c.y[0];
    found.t[0] = c.x[1] / bend.speed;
    found.t[1] = c.y[1] / bend.speed;
    found.phi = found.t[0] * (lies.y + qy - c.y[0]) - found.t[1] * (lies.x + qx - c.x[0]);
    found.kappa = bend.kappa;
    found.kappa_sigma = bend.kappa_sigma;
    found.q_t = found.t[0] * qx + found.t[1] * qy;
    found.q_n = found.t[0] * qy - found.t[1] * qx;
    found.other_kappa = second.kappa;
    found.other_kappa_sigma = second.kappa_sigma;
    return found;
}

// The rates of both feet, from the rates that drive them.
template <class D> struct Moves {
    Scalar<D> first, second;
    Moves(const Instance<D>& p, const Touch<D>& at, const Scalar<D>& drive, const Scalar<D>& turn) {
        const Scalar<D> lever = at.kappa * at.phi - 1.0;
        const Scalar<D> determinant = -at.other_kappa * lever - sense(p) * at.kappa;
        first = (-at.other_kappa * drive - sense(p) * turn) / determinant;
        second = (lever * turn - at.kappa * drive) / determinant;
    }
    Scalar<D> of(const Instance<D>& p) const {
        if (p.kind == Kind::slip_of_two) return first - sense(p) * second;
        return p.kind == Kind::place_on_first ? first : second;
    }
};

template <class D> Scalar<D> value(const Instance<D>& p, const Touch<D>& at) {
    if (p.kind == Kind::two_curves) return p.parameters[0] * at.phi - p.parameters[2];
    const Scalar<D> first = p.line->length_at(at.foot), second = p.other->length_at(at.other);
    if (p.kind == Kind::slip_of_two) return slipped(Scalar<D>(first - sense(p) * second));
    return p.kind == Kind::place_on_first ? first : second;
}

template <class D> void gradient(const Instance<D>& p, const Point<D>* x, const Touch<D>& at, Point<D>* g) {
    Scalar<D> e[2], by_angle;
    if (p.kind == Kind::two_curves) {
        e[0] = -p.parameters[0] * at.t[1];
        e[1] = p.parameters[0] * at.t[0];
        by_angle = p.parameters[0] * at.q_t;
    } else {
        const Scalar<D> by_place = Moves<D>(p, at, -1.0, 0.0).of(p);
        e[0] = by_place * at.t[0];
        e[1] = by_place * at.t[1];
        by_angle = Moves<D>(p, at, at.q_n, 1.0).of(p);
    }
    const Point<D> line = x[4] - x[3];
    angle::gradient<D>(x, g);
    g[0] = by_angle * g[0] + e[0] * line;
    g[1] = by_angle * g[1] + e[1] * line;
    g[2] = by_angle * g[2];
    g[4] = e[0] * x[0] + e[1] * x[1];
    g[3] = -g[4];
}

template <class D> Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* v, const Touch<D>& at) {
    using S = Scalar<D>;
    const Point<D> line = x[4] - x[3], line_dot = v[4] - v[3];
    S rate[2], bias[2];
    for (int k = 0; k < 2; ++k) {
        rate[k] = v[k].dot(line) + x[k].dot(line_dot);
        bias[k] = 2.0 * v[k].dot(line_dot);
    }
    Point<D> g[3];
    angle::gradient<D>(x, g);
    const S omega = g[0].dot(v[0]) + g[1].dot(v[1]) + g[2].dot(v[2]), omega_bias = angle::curvature<D>(x, v);
    const S slides = at.t[0] * rate[0] + at.t[1] * rate[1] - omega * at.q_n;
    const Moves<D> moves(p, at, -slides, omega);
    const S along_bias = at.t[0] * bias[0] + at.t[1] * bias[1], across_bias = at.t[0] * bias[1] - at.t[1] * bias[0];
    if (p.kind == Kind::two_curves) {
        const S own = across_bias + omega_bias * at.q_t + omega * (sense(p) * moves.second - omega * at.q_n);
        return p.parameters[0] * (own - at.kappa * moves.first * slides);
    }
    const S apart = at.t[0] * rate[1] - at.t[1] * rate[0] + omega * at.q_t;
    const S own = (2.0 * at.kappa * apart + at.kappa_sigma * at.phi * moves.first) * moves.first + along_bias -
                  omega_bias * at.q_n - omega * omega * at.q_t;
    const S turn =
        omega_bias - at.kappa_sigma * moves.first * moves.first + at.other_kappa_sigma * moves.second * moves.second;
    return Moves<D>(p, at, -own, turn).of(p);
}

}  // namespace on_two_curves
}  // namespace mbproj
