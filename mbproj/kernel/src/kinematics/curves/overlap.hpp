// Whether two curves that touch overlap elsewhere. The definition is that of mbproj.equations.curve_checks, which explains it.
#pragma once

#include "kinematics/angle.hpp"
#include "kinematics/curves/on_two_curves.hpp"

namespace mbproj {

// `x` are the points and vectors of a distance between two curves.
template <class D> bool overlaps(const Instance<D>& p, const Point<D>* x, double most) {
    const PlaneCurve &first = *p.line, &second = *p.other;
    const double side = value_of(p.parameters[0]), reach = value_of(p.parameters[2]);
    const bool round = first.runs.size() == 1 && second.runs.size() == 1;
    if (!first.closed || !second.closed ||
        (round && value_of(p.parameters[0] * first.side) < 0.0 && value_of(p.parameters[1] * second.side) < 0.0))
        return false;
    const Point<D> line = x[4] - x[3];
    const double angle = value_of(angle::value<D>(x)), cosine = std::cos(angle), sine = std::sin(angle);
    const double dx = value_of(x[0].dot(line)), dy = value_of(x[1].dot(line));
    for (const PlaneCurve::Place& place : second.places) {
        const double px = dx + cosine * place.x - sine * place.y, py = dy + sine * place.x + cosine * place.y;
        const Foot<double> foot = first.foot(px, py, PlaneCurve::free);
        const OnPiece<double> c = first.derivatives(foot.s, foot.piece);
        const double across = c.x[1] * (py - c.y[0]) - c.y[1] * (px - c.x[0]);
        if (side * across / std::hypot(c.x[1], c.y[1]) - reach < -most * first.places.back().length) return true;
    }
    return false;
}

}  // namespace mbproj
