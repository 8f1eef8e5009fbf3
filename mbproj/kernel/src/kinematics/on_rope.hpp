// The length of a rope over points and circles in a plane. The definitions are those of mbproj.constraints.rope, where each is
// explained.
#pragma once

#include <cmath>

#include "model/model.hpp"

namespace mbproj {
namespace on_rope {

// A straight part of the rope: the line between two centres, its components in the plane, D², λ and h; and the slopes of w θ
// by the components.
template <class D> struct Span {
    Point<D> line;
    Scalar<D> w, X, Y, D2, lambda, h, by_X, by_Y;

    Span(const RopePath& path, const Point<D>* x, int number)
        : line(x[3 + number] - x[2 + number]), w(path.w(number)), X(x[0].dot(line)), Y(x[1].dot(line)),
          D2(X * X + Y * Y), lambda(sqrt(line.squaredNorm() - w * w)), h(sqrt(D2 - w * w)) {
        const Scalar<D> out = w == 0.0 ? 0.0 : -w * w / (D2 * h), around = w == 0.0 ? 0.0 : w / D2;
        by_X = out * X - around * Y;
        by_Y = out * Y + around * X;
    }
    // How far the line has turned since the scene's pose, within (-π, π].
    Scalar<D> turned(const RopePath& path, int number) const {
        const Scalar<D> c = path.cosine[number], s = path.sine[number];
        return atan2(c * Y - s * X, c * X + s * Y);
    }
    // θ, the direction of the rope.
    Scalar<D> direction(const RopePath& path, int number) const {
        return path.directions[number] + turned(path, number) + atan(w / h);
    }
};

template <class D> Scalar<D> value(const Instance<D>& p, const Point<D>* x) {
    Scalar<D> total = -p.path->wound;
    for (int s = 0; s < p.path->spans(); ++s) {
        const Span<D> span(*p.path, x, s);
        total += span.lambda;
        if (span.w != 0.0) total += span.w * span.direction(*p.path, s);
    }
    return total;
}

template <class D> void gradient(const Instance<D>& p, const Point<D>* x, Point<D>* g) {
    for (int s = 0; s < p.slot_count; ++s) g[s].setZero();
    for (int s = 0; s < p.path->spans(); ++s) {
        const Span<D> span(*p.path, x, s);
        const Point<D> along = span.line / span.lambda + span.by_X * x[0] + span.by_Y * x[1];
        g[0] += span.by_X * span.line;
        g[1] += span.by_Y * span.line;
        g[2 + s] -= along;
        g[3 + s] += along;
    }
}

template <class D> Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* v) {
    Scalar<D> total = 0.0;
    for (int s = 0; s < p.path->spans(); ++s) {
        const Span<D> span(*p.path, x, s);
        const Point<D> rate = v[3 + s] - v[2 + s];
        const Scalar<D> stretch = span.line.dot(rate) / span.lambda;
        total += (rate.squaredNorm() - stretch * stretch) / span.lambda;
        if (span.w == 0.0) continue;
        total += 2.0 * (span.by_X * v[0].dot(rate) + span.by_Y * v[1].dot(rate));
        const Scalar<D> X_dot = v[0].dot(span.line) + x[0].dot(rate), Y_dot = v[1].dot(span.line) + x[1].dot(rate);
        const Scalar<D> out = span.X * X_dot + span.Y * Y_dot, around = span.X * Y_dot - span.Y * X_dot;
        const Scalar<D> part = span.w * span.w / (span.D2 * span.h);
        total += part * ((2.0 / span.D2 + 1.0 / (span.h * span.h)) * out * out - X_dot * X_dot - Y_dot * Y_dot);
        total -= 2.0 * span.w * around * out / (span.D2 * span.D2);
    }
    return total;
}

// Whether the rope lies on its circles.
template <class D> RopeTrouble trouble(const Instance<D>& p, const Point<D>* x, const Thresholds& thresholds) {
    Scalar<D> before = 0.0;
    for (int s = 0; s < p.path->spans(); ++s) {
        const Span<D> span(*p.path, x, s);
        const bool turns = p.path->radii[s] != 0.0 || p.path->radii[s + 1] != 0.0;
        if (turns && !(span.h > 0.0 && abs(span.turned(*p.path, s)) <= thresholds.rope_turned)) return {s, -1};
        const Scalar<D> direction = span.direction(*p.path, s), radius = p.path->radii[s];
        if (s > 0 && radius != 0.0 && !((direction - before) * copysign(1.0, radius) >= -thresholds.off_sheave))
            return {-1, s};
        before = direction;
    }
    return {};
}

}  // namespace on_rope
}  // namespace mbproj
