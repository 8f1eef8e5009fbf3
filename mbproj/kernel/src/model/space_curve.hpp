// Space curves: cubic pieces with their derivatives, the foot of a point, arc length. The definitions are those of
// mbproj.functions.space_curve, which explains them.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "model/plane_curve.hpp"

namespace mbproj {

template <class S> S inner(const S* a, const S* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
template <class S> void cross(const S* a, const S* b, S* found) {
    for (int k = 0; k < 3; ++k) found[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

// A point and its derivatives by the parameter.
template <class S> struct OnSpacePiece {
    S c[4][3];
};

struct SpacePiece {
    double start, origin;
    double c[3][4];
    double axis[3];   // a direction to which no tangent of the piece is parallel
    int first, last;  // the numbers of its first and last place
};
struct SpacePlace {
    double s, point[3], length;
    int piece;
};

struct SpaceCurve : PiecedCurve<SpacePiece, SpacePlace> {
    template <class S> OnSpacePiece<S> derivatives(const S& s, int number) const {
        const Piece& piece = pieces[number];
        const S u = s - piece.origin;
        OnSpacePiece<S> found;
        for (int k = 0; k < 3; ++k) {
            const double* c = piece.c[k];
            found.c[0][k] = c[0] + u * (c[1] + u * (c[2] + u * c[3]));
            found.c[1][k] = c[1] + u * (2.0 * c[2] + u * (3.0 * c[3]));
            found.c[2][k] = 2.0 * c[2] + 6.0 * c[3] * u;
            found.c[3][k] = 6.0 * c[3];
        }
        return found;
    }

    // The foot of a point: on the held piece or its continuation, or on the whole curve.
    Foot<double> foot(const double* d, int held) const {
        const int first = held == free ? 0 : pieces[held].first;
        const int last = held == free ? static_cast<int>(places.size()) - 1 : pieces[held].last;
        int best = first;
        double least = std::numeric_limits<double>::infinity();
        for (int at = first; at <= last; ++at) {
            const double* p = places[at].point;
            const double apart[3] = {d[0] - p[0], d[1] - p[1], d[2] - p[2]};
            if (const double own = inner(apart, apart); own < least) least = own, best = at;
        }
        Foot<double> found{places[best].s, places[best].piece};
        for (int pass = 0; pass < passes; ++pass) {
            const OnSpacePiece<double> c = derivatives(found.s, found.piece);
            const double line[3] = {d[0] - c.c[0][0], d[1] - c.c[0][1], d[2] - c.c[0][2]};
            const double speed2 = inner(c.c[1], c.c[1]), slope = inner(line, c.c[2]) - speed2;
            const double step = std::clamp(-inner(line, c.c[1]) / (slope < 0.0 ? slope : -speed2), -reach, reach);
            move(found, step, held);
            if (!(std::abs(step) > settled)) break;
        }
        return found;
    }
    // The foot with its derivatives: one more pass of Newton's method in numbers of type S.
    template <class S> Foot<S> foot(const S* d, int held) const {
        const double real[3] = {value_of(d[0]), value_of(d[1]), value_of(d[2])};
        const Foot<double> at = foot(real, held);
        const OnSpacePiece<double> c = derivatives(at.s, at.piece);
        S along = 0.0;
        double slope = -inner(c.c[1], c.c[1]);
        for (int k = 0; k < 3; ++k) {
            along += (d[k] - c.c[0][k]) * c.c[1][k];
            slope += (real[k] - c.c[0][k]) * c.c[2][k];
        }
        return {at.s - along / slope, at.piece};
    }

    // The arc length from the start of the curve to a foot.
    template <class S> S length_at(const Foot<S>& foot) const {
        const int before = place_before(foot);
        return places[before].length + gauss_length<S>(places[before].s, foot.s, [&](const S& s) {
                   const OnSpacePiece<S> c = derivatives<S>(s, foot.piece);
                   return S(sqrt(inner(c.c[1], c.c[1])));
               });
    }
};

}  // namespace mbproj
