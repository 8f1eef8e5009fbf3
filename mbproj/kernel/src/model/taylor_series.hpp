// Taylor arithmetic, truncated after the second order: a value with its first and second derivative in time. The rules
// are those of mbproj.functions.taylor.
#pragma once

#include <algorithm>
#include <cmath>

namespace mbproj {

struct Series {
    double x = 0.0, d = 0.0, dd = 0.0;
    bool finite() const { return std::isfinite(x) && std::isfinite(d) && std::isfinite(dd); }
};

// g(x(t)) from g, g' and g'' at x. A factor that is zero keeps a term out of what is constant in time.
inline Series chain(double g, double g1, double g2, const Series& x) {
    return {g, g1 * x.d, g2 * x.d * x.d + g1 * x.dd};
}

inline Series operator+(const Series& a, const Series& b) { return {a.x + b.x, a.d + b.d, a.dd + b.dd}; }
inline Series operator-(const Series& a, const Series& b) { return {a.x - b.x, a.d - b.d, a.dd - b.dd}; }
inline Series operator*(const Series& a, const Series& b) {
    return {a.x * b.x, a.d * b.x + a.x * b.d, a.dd * b.x + 2.0 * a.d * b.d + a.x * b.dd};
}
inline Series operator/(const Series& a, const Series& b) {
    const double q = a.x / b.x, q1 = (a.d - q * b.d) / b.x;
    return {q, q1, (a.dd - 2.0 * q1 * b.d - q * b.dd) / b.x};
}
inline Series exponential(const Series& x) {
    const double value = std::exp(x.x);
    return chain(value, value, value, x);
}
inline Series logarithm(const Series& x) { return chain(std::log(x.x), 1.0 / x.x, -1.0 / (x.x * x.x), x); }
inline Series power_of(const Series& a, const Series& b) {
    Series grown = exponential(b * logarithm(a));
    grown.x = std::pow(a.x, b.x);
    return grown;
}
inline Series arc_tangent(const Series& y, const Series& x) {
    const double r2 = x.x * x.x + y.x * y.x;
    const double rate = (x.x * y.d - y.x * x.d) / r2, bend = (x.x * y.dd - y.x * x.dd) / r2;
    return {std::atan2(y.x, x.x), rate, bend - 2.0 * rate * (x.x * x.d + y.x * y.d) / r2};
}
inline Series hypotenuse(const Series& a, const Series& b) {
    const double h = std::hypot(a.x, b.x), h1 = (a.x * a.d + b.x * b.d) / h;
    return {h, h1, (a.d * a.d + a.x * a.dd + b.d * b.d + b.x * b.dd - h1 * h1) / h};
}
// x ** exponent; a factor that is zero keeps the term out, be the power of x defined or not.
inline Series power(const Series& x, double exponent) {
    const double second = exponent * (exponent - 1.0);
    const double rate = exponent != 0.0 ? exponent * std::pow(x.x, exponent - 1.0) : 0.0;
    return chain(std::pow(x.x, exponent), rate, second != 0.0 ? second * std::pow(x.x, exponent - 2.0) : 0.0, x);
}
inline Series smooth_step(const Series& s) {
    const double x = std::min(std::max(s.x, 0.0), 1.0), y = 1.0 - x;
    const double value = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
    return chain(value, 30.0 * x * x * y * y, 60.0 * x * y * (1.0 - 2.0 * x), s);
}

}  // namespace mbproj
