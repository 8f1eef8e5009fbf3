// What follows a curve: where it touches, its distance from the curve, and how far along it is. The definitions are those
// of mbproj.constraints.profile, where each is explained.
#pragma once

#include "kinematics/on_face.hpp"

namespace mbproj {

namespace on_curve {

template <class D> Touch<D> touch(const Instance<D>& p, const Point<D>* x, int held = PlaneCurve::free) {
    const PlaneCurve& curve = *p.line;
    const bool faces = is_on_face(p.kind);
    const Point<D> line = faces ? x[2] : Point<D>(x[3] - x[2]);
    const Scalar<D> d[2] = {x[0].dot(line), x[1].dot(line)};
    Touch<D> found{faces ? curve.facing(d[0], d[1], held) : curve.foot(d[0], d[1], held), {}, {}, 0.0, 0.0, 0.0};
    const OnPiece<Scalar<D>> c = curve.derivatives(found.foot.s, found.foot.piece);
    const Scalar<D> speed2 = c.x[1] * c.x[1] + c.y[1] * c.y[1], speed = sqrt(speed2);
    found.c[0] = c.x[0];
    found.c[1] = c.y[0];
    found.t[0] = c.x[1] / speed;
    found.t[1] = c.y[1] / speed;
    const Scalar<D> turn = c.x[1] * c.y[2] - c.y[1] * c.x[2], turn_s = c.x[1] * c.y[3] - c.y[1] * c.x[3];
    const Scalar<D> stretch = c.x[1] * c.x[2] + c.y[1] * c.y[2];
    found.phi = found.t[0] * (d[1] - c.y[0]) - found.t[1] * (d[0] - c.x[0]);
    found.kappa = turn / (speed2 * speed);
    found.kappa_sigma = (turn_s - 3.0 * turn * stretch / speed2) / (speed2 * speed2);
    return found;
}

// The gradient of e·d with e fixed.
template <class D> void gradient_along(const Point<D>* x, Scalar<D> first, Scalar<D> second, Point<D>* g) {
    const Point<D> line = x[3] - x[2];
    g[0] = first * line;
    g[1] = second * line;
    g[3] = first * x[0] + second * x[1];
    g[2] = -g[3];
}

template <class D> Scalar<D> value(const Instance<D>& p, const Point<D>* x, const Touch<D>& at) {
    if (is_on_face(p.kind)) return on_face::value<D>(p, x, at);
    if (p.kind == Kind::profile) return p.parameters[0] * at.phi - p.parameters[1];
    const Scalar<D> length = p.line->length_at(at.foot);
    if (p.kind == Kind::arc) return length;
    const Scalar<D> lap = p.parameters[1] * (length - p.parameters[0] * p.line->angle_at(at.foot, at.t));
    return p.line->closed ? lap - 2.0 * M_PI * nearbyint(lap / (2.0 * M_PI)) : lap;
}

// By how much the value of what counts along the curve grows with the arc length.
template <class D> Scalar<D> way_factor(const Instance<D>& p, const Touch<D>& at) {
    return p.kind == Kind::arc ? 1.0 : p.parameters[1] * (1.0 - p.parameters[0] * at.kappa);
}

template <class D> void gradient(const Instance<D>& p, const Point<D>* x, const Touch<D>& at, Point<D>* g) {
    if (is_on_face(p.kind))
        on_face::gradient<D>(p, x, at, g);
    else if (p.kind == Kind::profile)
        gradient_along<D>(x, -p.parameters[0] * at.t[1], p.parameters[0] * at.t[0], g);
    else {
        const Scalar<D> factor = way_factor(p, at) / at.stretch();
        gradient_along<D>(x, factor * at.t[0], factor * at.t[1], g);
    }
}

template <class D>
Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* x_dot, const Touch<D>& at) {
    if (is_on_face(p.kind)) return on_face::curvature<D>(p, x, x_dot, at);
    const Point<D> line = x[3] - x[2], line_dot = x_dot[3] - x_dot[2];
    Scalar<D> rate[2], bias[2];
    for (int k = 0; k < 2; ++k) {
        rate[k] = x_dot[k].dot(line) + x[k].dot(line_dot);
        bias[k] = 2.0 * x_dot[k].dot(line_dot);
    }
    const Scalar<D> along = at.t[0] * rate[0] + at.t[1] * rate[1], across = at.t[0] * rate[1] - at.t[1] * rate[0];
    if (p.kind == Kind::profile) {
        const Scalar<D> bent = at.t[0] * bias[1] - at.t[1] * bias[0];
        return p.parameters[0] * (bent - at.kappa / at.stretch() * along * along);
    }
    const Scalar<D> sigma = along / at.stretch();
    const Scalar<D> own = (2.0 * at.kappa * across + at.kappa_sigma * at.phi * sigma) * sigma;
    const Scalar<D> bent = (at.t[0] * bias[0] + at.t[1] * bias[1] + own) / at.stretch();
    if (p.kind == Kind::arc) return bent;
    return way_factor(p, at) * bent - p.parameters[1] * p.parameters[0] * at.kappa_sigma * sigma * sigma;
}

}  // namespace on_curve
}  // namespace mbproj
