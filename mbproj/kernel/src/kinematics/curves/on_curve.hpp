// Points that follow a plane curve, or the surface of revolution of which it is the meridian: the contact point, the distance, and
// the arc length. The definitions are those of mbproj.joints.primitives.plane_curves and surfaces, which explain them.
#pragma once

#include <limits>

#include "kinematics/curves/in_space.hpp"
#include "kinematics/curves/on_face.hpp"
#include "kinematics/curves/on_two_curves.hpp"

namespace mbproj {

namespace on_curve {

// The slots z, p1, p2 of a point on a surface about the axis z. In the plane of x and y it has x, y, p1, p2.
constexpr int slots_about_axis = 3;
// Whether a primitive has this many slots; a rope has as many as its path needs.
constexpr bool takes(Kind kind, int slots) {
    const bool turns = slots == slots_about_axis && (kind == Kind::profile || kind == Kind::arc);
    return turns || kind == Kind::rope || slots == form_of(kind).slots;
}
template <class D> bool is_about_axis(const Instance<D>& p) { return D::axes == 3 && p.slot_count == slots_about_axis; }

// The place (ρ, h) of a point about an axis: ρ = |c| with c = z × ℓ, h = z·ℓ.
template <class D> struct AboutAxis {
    Point<D> line, c;
    Scalar<D> rho, height;

    explicit AboutAxis(const Point<D>* x)
        : line(x[2] - x[1]), c(x[0].cross(line)), rho(sqrt(c.squaredNorm())), height(x[0].dot(line)) {}
    // A number over ρ; 0 on the axis.
    Scalar<D> over_rho(const Scalar<D>& number) const {
        return value_of(rho) > 0.0 ? Scalar<D>(number / rho) : Scalar<D>(0.0);
    }
    // The component along ρ of the normal (-t₁, t₀) over ρ; near the axis the limit of a smooth surface.
    Scalar<D> normal_share(const Touch<D>& at) const {
        const double small = std::sqrt(std::numeric_limits<double>::epsilon());
        const bool near = std::abs(value_of(at.t[1])) <= small && std::abs(value_of(at.kappa * rho)) <= small;
        return near ? Scalar<D>(-at.kappa * at.t[0] * at.t[0] / at.stretch()) : over_rho(-at.t[1]);
    }
};

template <class D> Touch<D> touch(const Instance<D>& p, const Point<D>* x, int held = PlaneCurve::free,
                                  int other_held = PlaneCurve::free) {
    if (is_of_two(p.kind)) return on_two_curves::touch<D>(p, x, held, other_held);
    if (is_in_space(p.kind)) return in_space::touch<D>(p, x, held);
    const PlaneCurve& curve = *p.line;
    const bool faces = is_on_face(p.kind);
    Scalar<D> d[2];
    if constexpr (D::axes == 3)
        if (is_about_axis(p)) {
            const AboutAxis<D> place(x);
            d[0] = place.rho, d[1] = place.height;
        }
    if (!is_about_axis(p)) {
        const Point<D> line = faces ? x[2] : Point<D>(x[3] - x[2]);
        for (int k = 0; k < 2; ++k) d[k] = x[k].dot(line);
    }
    Touch<D> found{};
    found.foot = faces ? curve.facing(d[0], d[1], held) : curve.foot(d[0], d[1], held);
    const OnPiece<Scalar<D>> c = curve.derivatives(found.foot.s, found.foot.piece);
    const Bend<Scalar<D>> bend(c);
    found.c[0] = c.x[0];
    found.c[1] = c.y[0];
    found.t[0] = c.x[1] / bend.speed;
    found.t[1] = c.y[1] / bend.speed;
    found.phi = found.t[0] * (d[1] - c.y[0]) - found.t[1] * (d[0] - c.x[0]);
    found.kappa = bend.kappa;
    found.kappa_sigma = bend.kappa_sigma;
    return found;
}

// The gradient of e·d with e fixed. `share` is e₀/ρ about an axis.
template <class D> void gradient_along(const Instance<D>& p, const Point<D>* x, Scalar<D> first, Scalar<D> second,
                                       Scalar<D> share, Point<D>* g) {
    if constexpr (D::axes == 3)
        if (is_about_axis(p)) {
            const AboutAxis<D> place(x);
            g[0] = second * place.line + share * place.line.cross(place.c);
            g[2] = second * x[0] + share * place.c.cross(x[0]);
            g[1] = -g[2];
            return;
        }
    const Point<D> line = x[3] - x[2];
    g[0] = first * line;
    g[1] = second * line;
    g[3] = first * x[0] + second * x[1];
    g[2] = -g[3];
}

template <class D> Scalar<D> value(const Instance<D>& p, const Point<D>* x, const Touch<D>& at) {
    if (is_on_face(p.kind)) return on_face::value<D>(p, x, at);
    if (is_of_two(p.kind)) return on_two_curves::value<D>(p, at);
    if (is_in_space(p.kind)) return in_space::value<D>(p, at);
    if (p.kind == Kind::profile) return p.parameters[0] * at.phi - p.parameters[1];
    const Scalar<D> length = p.line->length_at(at.foot);
    if (p.kind == Kind::arc) return length;
    const Scalar<D> lap = p.parameters[1] * (length - p.parameters[0] * p.line->angle_at(at.foot, at.t));
    return p.line->closed ? lap - 2.0 * M_PI * nearbyint(lap / (2.0 * M_PI)) : lap;
}

// The derivative by the arc length of a value that counts along the curve.
template <class D> Scalar<D> way_factor(const Instance<D>& p, const Touch<D>& at) {
    return p.kind == Kind::arc ? 1.0 : p.parameters[1] * (1.0 - p.parameters[0] * at.kappa);
}

template <class D> void gradient(const Instance<D>& p, const Point<D>* x, const Touch<D>& at, Point<D>* g) {
    if (is_on_face(p.kind))
        on_face::gradient<D>(p, x, at, g);
    else if (is_of_two(p.kind))
        on_two_curves::gradient<D>(p, x, at, g);
    else if (is_in_space(p.kind))
        in_space::gradient<D>(p, x, at, g);
    else if (p.kind == Kind::profile) {
        Scalar<D> share = 0.0;
        if constexpr (D::axes == 3)
            if (is_about_axis(p)) share = p.parameters[0] * AboutAxis<D>(x).normal_share(at);
        gradient_along<D>(p, x, -p.parameters[0] * at.t[1], p.parameters[0] * at.t[0], share, g);
    } else {
        const Scalar<D> factor = way_factor(p, at) / at.stretch();
        Scalar<D> share = 0.0;
        if constexpr (D::axes == 3)
            if (is_about_axis(p)) share = AboutAxis<D>(x).over_rho(factor * at.t[0]);
        gradient_along<D>(p, x, factor * at.t[0], factor * at.t[1], share, g);
    }
}

template <class D>
Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* x_dot, const Touch<D>& at) {
    if (is_on_face(p.kind)) return on_face::curvature<D>(p, x, x_dot, at);
    if (is_of_two(p.kind)) return on_two_curves::curvature<D>(p, x, x_dot, at);
    if (is_in_space(p.kind)) return in_space::curvature<D>(p, x, x_dot, at);
    Scalar<D> rate[2], bias[2], normal_bias;  // d', what is left of d'' without x'', and its part along ρ or x times n₀
    if constexpr (D::axes == 3)
        if (is_about_axis(p)) {
            const AboutAxis<D> place(x);
            const Point<D> line_dot = x_dot[2] - x_dot[1];
            const Point<D> c_dot = x_dot[0].cross(place.line) + x[0].cross(line_dot);
            rate[0] = place.over_rho(place.c.dot(c_dot));
            rate[1] = x_dot[0].dot(place.line) + x[0].dot(line_dot);
            const Scalar<D> spread =
                c_dot.squaredNorm() + 2.0 * place.c.dot(x_dot[0].cross(line_dot)) - rate[0] * rate[0];
            bias[0] = place.over_rho(spread);
            bias[1] = 2.0 * x_dot[0].dot(line_dot);
            normal_bias = place.normal_share(at) * spread;
        }
    if (!is_about_axis(p)) {
        const Point<D> line = x[3] - x[2], line_dot = x_dot[3] - x_dot[2];
        for (int k = 0; k < 2; ++k) {
            rate[k] = x_dot[k].dot(line) + x[k].dot(line_dot);
            bias[k] = 2.0 * x_dot[k].dot(line_dot);
        }
        normal_bias = -at.t[1] * bias[0];
    }
    const Scalar<D> along = at.t[0] * rate[0] + at.t[1] * rate[1], across = at.t[0] * rate[1] - at.t[1] * rate[0];
    if (p.kind == Kind::profile) {
        const Scalar<D> bent = at.t[0] * bias[1] + normal_bias;
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
