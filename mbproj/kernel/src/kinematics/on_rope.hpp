// Lengths and angles of a rope over points and circles in a plane. The definitions are those of mbproj.joints.primitives.rope, which
// explains them.
#pragma once

#include <cmath>

#include "model/model.hpp"

namespace mbproj {
namespace on_rope {

// A straight part of the rope: the line between two centres, its components in the plane, D², λ and h; and the slopes of b θ
// by the components.
template <class D> struct Span {
    int first, last;
    double a, b, cosine, sine, start;  // the weights of λ and θ; the direction from which turns are counted
    Point<D> line;
    Scalar<D> w, X, Y, D2, lambda, h, by_X, by_Y;

    Span() = default;
    Span(const RopePath& path, const Point<D>* x, int from, int to, double by_length, double by_angle)
        : first(from), last(to), a(by_length), b(by_angle), cosine(path.cosine[from]), sine(path.sine[from]),
          start(path.directions[from]), line(x[2 + to] - x[2 + from]), w(path.radii[from] - path.radii[to]),
          X(x[0].dot(line)), Y(x[1].dot(line)), D2(X * X + Y * Y), lambda(sqrt(line.squaredNorm() - w * w)),
          h(sqrt(D2 - w * w)) {
        const Scalar<D> out = b == 0.0 ? 0.0 : -b * w / (D2 * h), around = b == 0.0 ? 0.0 : b / D2;
        by_X = out * X - around * Y;
        by_Y = out * Y + around * X;
    }
    // Chooses the count of turns so that the rope runs in nearly this direction.
    void run(double direction) {
        start = direction - value_of(Scalar<D>(atan(w / h)));
        cosine = std::cos(start), sine = std::sin(start);
    }
    // The angle by which the line has turned from `start`, within (-π, π].
    Scalar<D> turned() const { return atan2(cosine * Y - sine * X, cosine * X + sine * Y); }
    // θ, the direction of the rope.
    Scalar<D> direction() const { return start + turned() + atan(w / h); }
};

// The spans of the rope at a pose. One span passes a circle that the rope has left.
template <class D> struct Spans {
    Span<D> list[most_centres];
    int count = 0;

    Spans(const RopePath& path, const Point<D>* x) {
        for (int s = 0; s < path.spans(); ++s) {
            list[count++] = Span<D>(path, x, s, s + 1, path.by_length[s], path.by_angle[s]);
            if (s == 0 || !path.lifts[s]) continue;
            const Span<D>&before = list[count - 2], &after = list[count - 1];
            const double from = value_of(before.direction());
            if ((value_of(after.direction()) - from) * path.radii[s] >= 0.0) continue;
            Span<D> past(path, x, s - 1, s + 1, before.a, before.b + after.b);
            past.run(from);
            list[--count - 1] = past;
        }
    }
    const Span<D>* begin() const { return list; }
    const Span<D>* end() const { return list + count; }
};

template <class D> Scalar<D> value(const Instance<D>& p, const Point<D>* x) {
    Scalar<D> total = -p.path->wound;
    for (const Span<D>& span : Spans<D>(*p.path, x)) {
        total += span.a * span.lambda;
        if (span.b != 0.0) total += span.b * span.direction();
    }
    return total;
}

template <class D> void gradient(const Instance<D>& p, const Point<D>* x, Point<D>* g) {
    for (int s = 0; s < p.slot_count; ++s) g[s].setZero();
    for (const Span<D>& span : Spans<D>(*p.path, x)) {
        const Point<D> along = span.a / span.lambda * span.line + span.by_X * x[0] + span.by_Y * x[1];
        g[0] += span.by_X * span.line;
        g[1] += span.by_Y * span.line;
        g[2 + span.first] -= along;
        g[2 + span.last] += along;
    }
}

template <class D> Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* v) {
    Scalar<D> total = 0.0;
    for (const Span<D>& span : Spans<D>(*p.path, x)) {
        const Point<D> rate = v[2 + span.last] - v[2 + span.first];
        const Scalar<D> stretch = span.line.dot(rate) / span.lambda;
        total += span.a * (rate.squaredNorm() - stretch * stretch) / span.lambda;
        if (span.b == 0.0) continue;
        total += 2.0 * (span.by_X * v[0].dot(rate) + span.by_Y * v[1].dot(rate));
        const Scalar<D> X_dot = v[0].dot(span.line) + x[0].dot(rate), Y_dot = v[1].dot(span.line) + x[1].dot(rate);
        const Scalar<D> out = span.X * X_dot + span.Y * Y_dot, around = span.X * Y_dot - span.Y * X_dot;
        const Scalar<D> part = span.b * span.w / (span.D2 * span.h);
        total += part * ((2.0 / span.D2 + 1.0 / (span.h * span.h)) * out * out - X_dot * X_dot - Y_dot * Y_dot);
        total -= 2.0 * span.b * around * out / (span.D2 * span.D2);
    }
    return total;
}

// Whether the rope lies on its circles.
template <class D> RopeTrouble trouble(const Instance<D>& p, const Point<D>* x, const Thresholds& thresholds) {
    if (p.path->by_length[0] == 0.0) return {};  // the length on one circle: the rope's own length is checked
    Scalar<D> before = 0.0;
    for (const Span<D>& span : Spans<D>(*p.path, x)) {
        const double radius = p.path->radii[span.first], both = std::abs(radius) + std::abs(p.path->radii[span.last]);
        if (both > 0.0 && !(span.D2 > both * both && abs(span.turned()) <= thresholds.most_turned))
            return {span.first, -1};
        const Scalar<D> direction = span.direction();
        if (span.first > 0 && radius != 0.0 &&
            !((direction - before) * std::copysign(1.0, radius) >= -thresholds.same_written))
            return {-1, span.first};
        before = direction;
    }
    return {};
}

}  // namespace on_rope
}  // namespace mbproj
