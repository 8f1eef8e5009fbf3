// Plane curves: pieces with their derivatives, the foot of a point, arc length. The definitions are those of
// mbproj.functions.curves, which explains them.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "model/scalar.hpp"

namespace mbproj {

// A point and its derivatives by the parameter.
template <class S> struct OnPiece {
    S x[4], y[4];
};

template <class S> struct Foot {
    S s;
    int piece;
};

// The integral of a speed between two parameters, by Gauss-Legendre quadrature with eight nodes.
template <class S, class Speed> S gauss_length(double from, const S& to, const Speed& speed) {
    static constexpr double nodes[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    static constexpr double weights[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                         0.1012285362903763};
    const S half = 0.5 * (to - from), middle = from + half;
    S sum = 0.0;
    for (int k = 0; k < 4; ++k)
        for (const double side : {-1.0, 1.0}) sum += weights[k] * speed(S(middle + side * half * nodes[k]));
    return half * sum;
}

// The common base of plane and space curves. Each of the consecutive pieces has its start, its first and its last place. Each
// place has its parameter, its arc length from the start of the curve, and its piece.
template <class OnePiece, class OnePlace> struct PiecedCurve {
    using Piece = OnePiece;
    using Place = OnePlace;
    static constexpr int free = -1;

    std::vector<Piece> pieces;
    std::vector<Place> places;
    double end;
    bool closed;
    int passes;      // the most passes of Newton's method
    double settled;  // a smaller step ends Newton's method
    double reach;    // the largest step

    double start() const { return pieces.front().start; }

    int piece_at(double s) const {
        const auto after = std::upper_bound(pieces.begin(), pieces.end(), s,
                                            [](double value, const Piece& piece) { return value < piece.start; });
        return std::max(0, static_cast<int>(after - pieces.begin()) - 1);
    }
    // Moves a foot along the held piece, or along the whole curve.
    void move(Foot<double>& foot, double step, int held) const {
        foot.s += step;
        if (held != free) return;
        if (closed) foot.s -= (end - start()) * std::floor((foot.s - start()) / (end - start()));
        foot.piece = piece_at(foot.s);
    }
    template <class S> int place_before(const Foot<S>& foot) const {
        const Piece& piece = pieces[foot.piece];
        int before = piece.first;
        while (before + 1 < piece.last && places[before + 1].s <= foot.s) ++before;
        return before;
    }
};

// Two functions of u = s - origin, each a polynomial plus a sin(w u + p).
struct PlanePiece {
    static constexpr int terms = 8, numbers = terms + 3;
    enum class Form : int { cartesian, polar, support };
    double start, origin;
    Form form;
    double f[numbers], g[numbers];
    int f_terms, g_terms;
    int first, last;  // the numbers of its first and last place
};
// Points along a curve, with both ends of each piece; their arc lengths from the start, and the angles of their tangents, which
// count whole turns.
struct PlanePlace {
    double s, x, y, length, angle;
    int piece;
    double cosine, sine;  // cosine and sine of the angle
};

struct PlaneCurve : PiecedCurve<PlanePiece, PlanePlace> {
    static constexpr int terms = PlanePiece::terms, numbers = PlanePiece::numbers, orders = 5;
    using Form = PlanePiece::Form;
    // Consecutive places along which the tangent turns one way, to the left or to the right.
    struct Run {
        int first, last;
        bool left;
    };

    double straight;  // a smaller turn of the tangent counts as none
    double beyond;    // how far a piece may turn beyond its end, rad
    double stride;    // the largest distance from one place to the next
    double side;      // 1 for a closed curve that runs counterclockwise, else -1
    std::vector<Run> runs;

    template <class S> OnPiece<S> derivatives(const S& s, int number) const {
        const Piece& piece = pieces[number];
        const S u = s - piece.origin;
        S f[orders];
        evaluate(piece.f, piece.f_terms, u, f);
        if (piece.form == Form::cartesian) {
            S g[orders];
            evaluate(piece.g, piece.g_terms, u, g);
            return {{f[0], f[1], f[2], f[3]}, {g[0], g[1], g[2], g[3]}};
        }
        S n[4], t[4];  // along (cos s, sin s), and across it
        if (piece.form == Form::polar) {
            n[0] = f[0], n[1] = f[1], n[2] = f[2] - f[0], n[3] = f[3] - 3.0 * f[1];
            t[0] = 0.0, t[1] = f[0], t[2] = 2.0 * f[1], t[3] = 3.0 * f[2] - f[0];
        } else {
            const S bent = f[0] + f[2], change = f[1] + f[3];
            n[0] = f[0], n[1] = 0.0, n[2] = -bent, n[3] = -2.0 * change;
            t[0] = f[1], t[1] = bent, t[2] = change, t[3] = f[2] + f[4] - bent;
        }
        OnPiece<S> found;
        const auto [sine, cosine] = sine_and_cosine(s);
        for (int k = 0; k < 4; ++k) {
            found.x[k] = n[k] * cosine - t[k] * sine;
            found.y[k] = n[k] * sine + t[k] * cosine;
        }
        return found;
    }

    // The foot of a point: on the held piece or its continuation, or on the whole curve.
    Foot<double> foot(double x, double y, int held) const {
        return settled_from(nearest_place(x, y, held), held, [x, y](const OnPiece<double>& c) {
            const double dx = x - c.x[0], dy = y - c.y[0], speed2 = c.x[1] * c.x[1] + c.y[1] * c.y[1];
            const double slope = dx * c.x[2] + dy * c.y[2] - speed2;
            return -(dx * c.x[1] + dy * c.y[1]) / (slope < 0.0 ? slope : -speed2);
        });
    }
    // The foot at which the outward normal of a closed convex curve points along (a, b).
    Foot<double> facing(double a, double b, int held) const {
        return settled_from(turned_place(a, b, held), held, [a, b](const OnPiece<double>& c) {
            const double slope = a * c.x[2] + b * c.y[2];
            return -(a * c.x[1] + b * c.y[1]) / (slope < 0.0 ? slope : -(c.x[1] * c.x[1] + c.y[1] * c.y[1]));
        });
    }

    // Either foot with its derivatives: one more pass of Newton's method in numbers of type S.
    template <class S> Foot<S> foot(const S& x, const S& y, int held) const {
        const Foot<double> at = foot(value_of(x), value_of(y), held);
        const OnPiece<double> c = derivatives(at.s, at.piece);
        const S dx = x - c.x[0], dy = y - c.y[0];
        const double slope = value_of(dx) * c.x[2] + value_of(dy) * c.y[2] - c.x[1] * c.x[1] - c.y[1] * c.y[1];
        return {at.s - (dx * c.x[1] + dy * c.y[1]) / slope, at.piece};
    }
    template <class S> Foot<S> facing(const S& a, const S& b, int held) const {
        const Foot<double> at = facing(value_of(a), value_of(b), held);
        const OnPiece<double> c = derivatives(at.s, at.piece);
        const double slope = value_of(a) * c.x[2] + value_of(b) * c.y[2];
        return {at.s - (a * c.x[1] + b * c.y[1]) / slope, at.piece};
    }

    // The arc length from the start of the curve to a foot.
    template <class S> S length_at(const Foot<S>& foot) const {
        const int before = place_before(foot);
        return places[before].length + gauss_length<S>(places[before].s, foot.s, [&](const S& s) {
                   const OnPiece<S> c = derivatives<S>(s, foot.piece);
                   return S(sqrt(c.x[1] * c.x[1] + c.y[1] * c.y[1]));
               });
    }

    // All places, divided into runs.
    std::vector<Run> turning_runs() const {
        std::vector<Run> found;
        int first = 0;
        double way = 0.0;
        const int last = static_cast<int>(places.size()) - 1;
        for (int at = 0; at < last; ++at) {
            const double step = places[at + 1].angle - places[at].angle;
            if (std::abs(step) <= straight) continue;
            if (way * step < 0.0) {
                found.push_back({first, at, way > 0.0});
                first = at;
            }
            way = step;
        }
        found.push_back({first, last, way >= 0.0});
        return found;
    }

    // The angle by which the tangent has turned from the start to a foot with the tangent t.
    template <class S> S angle_at(const Foot<S>& foot, const S* t) const {
        const double angle = places[place_before(foot)].angle, cosine = std::cos(angle), sine = std::sin(angle);
        return angle - places.front().angle + atan((cosine * t[1] - sine * t[0]) / (cosine * t[0] + sine * t[1]));
    }

private:
    // The foot to which Newton's method leads from a place; `whole` gives its full step at a point of a piece.
    template <class Step> Foot<double> settled_from(int place, int held, const Step& whole) const {
        Foot<double> found{places[place].s, places[place].piece};
        for (int pass = 0; pass < passes; ++pass) {
            const double step = std::clamp(whole(derivatives(found.s, found.piece)), -reach, reach);
            move(found, step, held);
            if (!(std::abs(step) > settled)) break;
        }
        return found;
    }
    // The place whose outward normal is nearest to the direction (a, b). The curve is convex: the angles of its places are
    // monotonic.
    int turned_place(double a, double b, int held) const {
        const int first = held == free ? 0 : pieces[held].first;
        const int last = held == free ? static_cast<int>(places.size()) - 1 : pieces[held].last;
        const double middle = 0.5 * (places[first].angle + places[last].angle);
        double wanted = std::atan2(side * a, -side * b);
        wanted += 2.0 * M_PI * std::nearbyint((middle - wanted) / (2.0 * M_PI));
        const auto begin = places.begin() + first, end_of = places.begin() + last + 1;
        const auto after = std::lower_bound(begin, end_of, wanted, [this](const Place& place, double angle) {
            return side * place.angle < side * angle;
        });
        if (after == begin) return first;
        const int next = static_cast<int>(after - places.begin());
        if (after == end_of) return last;
        return side * (places[next].angle - wanted) < side * (wanted - places[next - 1].angle) ? next : next - 1;
    }
    // A function and its derivatives.
    template <class S> static void evaluate(const double* c, int count, const S& u, S* found) {
        std::fill_n(found, orders, S(0.0));
        for (int k = count - 1; k >= 0; --k) {
            for (int order = orders - 1; order > 0; --order) found[order] = found[order] * u + found[order - 1];
            found[0] = found[0] * u + c[k];
        }
        found[2] *= 2.0;
        found[3] *= 6.0;
        found[4] *= 24.0;
        const double a = c[terms], w = c[terms + 1];
        if (a == 0.0) return;
        const auto at = sine_and_cosine(w * u + c[terms + 2]);
        S sine = a * at.sine, cosine = a * at.cosine;
        for (int order = 0; order < orders; ++order) {
            found[order] += sine;
            const S last = sine;
            sine = w * cosine;
            cosine = -w * last;
        }
    }

    // The nearest place. From one place to the next a distance changes by `stride` at most: so some places can be
    // skipped.
    int nearest_place(double x, double y, int held) const {
        const int first = held == free ? 0 : pieces[held].first;
        const int last = held == free ? static_cast<int>(places.size()) - 1 : pieces[held].last;
        int best = first;
        double least = std::numeric_limits<double>::infinity();
        for (int at = first; at <= last;) {
            const double dx = x - places[at].x, dy = y - places[at].y;
            const double apart = std::sqrt(dx * dx + dy * dy);
            if (apart < least) {
                least = apart;
                best = at++;
            } else {
                const double skipped = std::floor((apart - least) / stride);
                at += skipped < last - at ? static_cast<int>(skipped) + 1 : last - at + 1;
            }
        }
        return best;
    }
};

}  // namespace mbproj
