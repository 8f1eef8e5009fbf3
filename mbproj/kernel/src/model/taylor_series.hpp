// Taylor arithmetic, truncated after the second order: a value with its first and second derivative in time. The rules
// are those of mbproj.functions.series.
#pragma once

#include "model/scalar.hpp"

namespace mbproj {

template <class S> struct Series {
    S x = 0.0, d = 0.0, dd = 0.0;
    bool finite() const { return isfinite(x) && isfinite(d) && isfinite(dd); }
};

// g(x(t)) from g, g' and g'' at x.
template <class S> inline Series<S> chain(const S& g, const S& g1, const S& g2, const Series<S>& x) {
    return {g, g1 * x.d, g2 * x.d * x.d + g1 * x.dd};
}

template <class S> inline Series<S> operator+(const Series<S>& a, const Series<S>& b) {
    return {a.x + b.x, a.d + b.d, a.dd + b.dd};
}
template <class S> inline Series<S> operator-(const Series<S>& a, const Series<S>& b) {
    return {a.x - b.x, a.d - b.d, a.dd - b.dd};
}
template <class S> inline Series<S> operator*(const Series<S>& a, const Series<S>& b) {
    return {a.x * b.x, a.d * b.x + a.x * b.d, a.dd * b.x + 2.0 * a.d * b.d + a.x * b.dd};
}
template <class S> inline Series<S> operator/(const Series<S>& a, const Series<S>& b) {
    const S q = a.x / b.x, q1 = (a.d - q * b.d) / b.x;
    return {q, q1, (a.dd - 2.0 * q1 * b.d - q * b.dd) / b.x};
}
template <class S> inline Series<S> exponential(const Series<S>& x) {
    const S value = exp(x.x);
    return chain(value, value, value, x);
}
template <class S> inline Series<S> logarithm(const Series<S>& x) {
    return chain(log(x.x), 1.0 / x.x, -1.0 / (x.x * x.x), x);
}
template <class S> inline Series<S> power_of(const Series<S>& a, const Series<S>& b) {
    Series<S> grown = exponential(b * logarithm(a));
    grown.x = pow(a.x, b.x);
    return grown;
}
template <class S> inline Series<S> arc_tangent(const Series<S>& y, const Series<S>& x) {
    const S r2 = x.x * x.x + y.x * y.x;
    const S rate = (x.x * y.d - y.x * x.d) / r2, bend = (x.x * y.dd - y.x * x.dd) / r2;
    return {atan2(y.x, x.x), rate, bend - 2.0 * rate * (x.x * x.d + y.x * y.d) / r2};
}
template <class S> inline Series<S> hypotenuse(const Series<S>& a, const Series<S>& b) {
    const S h = hypot(a.x, b.x), h1 = (a.x * a.d + b.x * b.d) / h;
    return {h, h1, (a.d * a.d + a.x * a.dd + b.d * b.d + b.x * b.dd - h1 * h1) / h};
}
// x ** exponent. Where a factor is zero its term is left out, even where the power of x is not defined.
template <class S> inline Series<S> power(const Series<S>& x, double exponent) {
    const double second = exponent * (exponent - 1.0);
    const S rate = exponent != 0.0 ? exponent * pow(x.x, exponent - 1.0) : 0.0;
    return chain(pow(x.x, exponent), rate, second != 0.0 ? second * pow(x.x, exponent - 2.0) : 0.0, x);
}
template <class S> inline Series<S> smooth_step(const Series<S>& s) {
    const S x = min(max(s.x, 0.0), 1.0), y = 1.0 - x;
    const S value = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
    return chain(value, 30.0 * x * x * y * y, 60.0 * x * y * (1.0 - 2.0 * x), s);
}

}  // namespace mbproj
