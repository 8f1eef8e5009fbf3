// The feet of two curves. The definitions are those of mbproj.functions.plane_curve, which explains them.
#pragma once

#include <vector>

#include "model/plane_curve.hpp"

namespace mbproj {

// The pose of the second curve: it is turned, then moved by (x, y). The tangents at the feet are opposite, or equal.
template <class S> struct SecondCurve {
    S x, y, cosine, sine;
    bool opposite;

    S turned_x(const S& a, const S& b) const { return cosine * a - sine * b; }
    S turned_y(const S& a, const S& b) const { return sine * a + cosine * b; }
};

template <class S> struct TwoFeet {
    Foot<S> first, second;
};

// Finds the pair of places nearest to the feet.
class NearestPlaces final {
public:
    NearestPlaces(const PlaneCurve& first, const PlaneCurve& second, const SecondCurve<double>& lies, int held,
                  int other_held)
        : first_(first), second_(second), lies_(lies) {
        turn_ = std::atan2(lies.sine, lies.cosine) + (lies.opposite ? M_PI : 0.0);
        for (const PlaneCurve::Run& one : first.runs)
            for (const PlaneCurve::Run& other : second.runs)
                walk(within(first, one, held), within(second, other, other_held));
        if (i < 0) take_closest(held, other_held);
    }
    int i = -1, j = -1;

private:
    // Consecutive places from `first` on, in the order of their angles.
    struct Row {
        int first, count, step;
        int at(int k) const { return first + step * k; }
    };
    static Row within(const PlaneCurve& curve, const PlaneCurve::Run& run, int held) {
        int low = run.first, high = run.last;
        if (held != PlaneCurve::free) {
            low = std::max(low, curve.pieces[held].first);
            high = std::min(high, curve.pieces[held].last);
        }
        return run.left ? Row{low, high - low + 1, 1} : Row{high, high - low + 1, -1};
    }
    double first_angle(const Row& row, int k) const { return first_.places[row.at(k)].angle; }
    double second_angle(const Row& row, int k) const { return second_.places[row.at(k)].angle + turn_; }

    void walk(const Row& one, const Row& other) {
        if (one.count < 2 || other.count < 2) return;
        const double low = first_angle(one, 0), high = first_angle(one, one.count - 1);
        const double from = second_angle(other, 0), to = second_angle(other, other.count - 1);
        const double last = std::floor((high - from + first_.beyond) / (2.0 * M_PI));
        for (double turns = std::ceil((low - to - first_.beyond) / (2.0 * M_PI)); turns <= last; ++turns)
            merge(one, other, 2.0 * M_PI * turns);
    }
    // Walks along both rows of places in the order of their angles, from where both have begun until one has ended.
    void merge(const Row& one, const Row& other, double more) {
        const auto a = [&](int k) { return first_angle(one, k); };
        const auto b = [&](int k) { return second_angle(other, k) + more; };
        const double end = std::min(a(one.count - 1), b(other.count - 1));
        int m = 0, n = 0;
        if (a(0) <= b(0))
            while (m + 1 < one.count && a(m + 1) <= b(0)) ++m;
        else
            while (n + 1 < other.count && b(n + 1) < a(0)) ++n;
        has_before_ = false;
        consider(one.at(m), other.at(n));
        take_end();
        while (m + 1 < one.count || n + 1 < other.count) {
            const bool of_first = m + 1 < one.count && (n + 1 >= other.count || a(m + 1) <= b(n + 1));
            if ((of_first ? a(m + 1) : b(n + 1)) > end) break;
            ++(of_first ? m : n);
            consider(one.at(m), other.at(n));
        }
        take_end();
    }
    // Looks at a pair of places. Their line's component along the tangent of the first changes its sign next to feet.
    void consider(int m, int n) {
        const PlaneCurve::Place &one = first_.places[m], &other = second_.places[n];
        const double dx = lies_.x + lies_.turned_x(other.x, other.y) - one.x;
        const double dy = lies_.y + lies_.turned_y(other.x, other.y) - one.y;
        const double forward = one.cosine * dx + one.sine * dy, apart = std::abs(one.cosine * dy - one.sine * dx);
        if (has_before_ && forward * forward_ <= 0.0) {
            const bool here = !(std::abs(forward_) < std::abs(forward));
            if (const double own = here ? apart : apart_; own < least_) {
                least_ = own;
                i = here ? m : m_;
                j = here ? n : n_;
            }
        }
        has_before_ = true;
        forward_ = forward, apart_ = apart, m_ = m, n_ = n;
    }
    // Considers the last place as an end: a held piece continues beyond it.
    void take_end() {
        const double distance = std::hypot(forward_, apart_);
        if (distance >= least_) return;
        least_ = distance;
        i = m_, j = n_;
    }
    void take_closest(int held, int other_held) {
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t m = 0; m < first_.places.size(); ++m) {
            if (held != PlaneCurve::free && first_.places[m].piece != held) continue;
            for (std::size_t n = 0; n < second_.places.size(); ++n) {
                if (other_held != PlaneCurve::free && second_.places[n].piece != other_held) continue;
                const PlaneCurve::Place &one = first_.places[m], &other = second_.places[n];
                const double dx = lies_.x + lies_.turned_x(other.x, other.y) - one.x;
                const double dy = lies_.y + lies_.turned_y(other.x, other.y) - one.y;
                if (const double own = dx * dx + dy * dy; i < 0 || own < least) {
                    least = own;
                    i = static_cast<int>(m), j = static_cast<int>(n);
                }
            }
        }
    }

    const PlaneCurve &first_, &second_;
    const SecondCurve<double>& lies_;
    double turn_, least_ = std::numeric_limits<double>::infinity();
    bool has_before_ = false;
    double forward_ = 0.0, apart_ = 0.0;
    int m_ = 0, n_ = 0;
};

// The step of Newton's method from two parameters, with the matrix evaluated in doubles.
template <class S> void step_to_feet(const PlaneCurve& first, const PlaneCurve& second, const SecondCurve<S>& lies,
                                     const TwoFeet<double>& from, S* step) {
    const OnPiece<double> c = first.derivatives(from.first.s, from.first.piece);
    const OnPiece<double> own = second.derivatives(from.second.s, from.second.piece);
    const S x0 = lies.x + lies.turned_x(own.x[0], own.y[0]) - c.x[0],
            y0 = lies.y + lies.turned_y(own.x[0], own.y[0]) - c.y[0];
    const S x1 = lies.turned_x(own.x[1], own.y[1]), y1 = lies.turned_y(own.x[1], own.y[1]);
    const S x2 = lies.turned_x(own.x[2], own.y[2]), y2 = lies.turned_y(own.x[2], own.y[2]);
    const double speed2 = c.x[1] * c.x[1] + c.y[1] * c.y[1];
    const double a = value_of(c.x[2] * x0 + c.y[2] * y0) - speed2, b = value_of(c.x[1] * x1 + c.y[1] * y1);
    const double d = value_of(c.x[2] * y1 - c.y[2] * x1), e = value_of(c.x[1] * y2 - c.y[1] * x2);
    const S forward = c.x[1] * x0 + c.y[1] * y0, turn = c.x[1] * y1 - c.y[1] * x1;
    const double determinant = a * e - b * d;
    if (std::abs(determinant) <= first.straight * (std::abs(a * e) + std::abs(b * d))) {
        step[0] = forward / speed2;  // both parts are straight
        step[1] = 0.0 * forward;
        return;
    }
    step[0] = (b * turn - e * forward) / determinant;
    step[1] = (d * forward - a * turn) / determinant;
}

inline TwoFeet<double> touching(const PlaneCurve& first, const PlaneCurve& second, const SecondCurve<double>& lies,
                                int held, int other_held) {
    const NearestPlaces near(first, second, lies, held, other_held);
    TwoFeet<double> found{{first.places[near.i].s, first.places[near.i].piece},
                          {second.places[near.j].s, second.places[near.j].piece}};
    for (int pass = 0; pass < first.passes; ++pass) {
        double step[2];
        step_to_feet<double>(first, second, lies, found, step);
        step[0] = std::clamp(step[0], -first.reach, first.reach);
        step[1] = std::clamp(step[1], -second.reach, second.reach);
        first.move(found.first, step[0], held);
        second.move(found.second, step[1], other_held);
        if (!(std::abs(step[0]) > first.settled) && !(std::abs(step[1]) > second.settled)) break;
    }
    return found;
}

// Both feet with their derivatives: one more pass of Newton's method in numbers of type S.
template <class S> TwoFeet<S> touching(const PlaneCurve& first, const PlaneCurve& second, const SecondCurve<S>& lies,
                                       int held, int other_held) {
    const SecondCurve<double> real{value_of(lies.x), value_of(lies.y), value_of(lies.cosine), value_of(lies.sine),
                                   lies.opposite};
    const TwoFeet<double> at = touching(first, second, real, held, other_held);
    S step[2];
    step_to_feet<S>(first, second, lies, at, step);
    return {{at.first.s + step[0], at.first.piece}, {at.second.s + step[1], at.second.piece}};
}

}  // namespace mbproj
