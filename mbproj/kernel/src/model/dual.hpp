// Dual numbers: a value and its derivatives along a few directions at once. Code for doubles gives derivatives with
// them, exact but for round-off (Griewank & Walther, Evaluating Derivatives, 2008, ch. 3).
#pragma once

#include "model/scalar.hpp"

namespace mbproj {

struct Dual {
    static constexpr int directions = 4;
    using Tangent = double __attribute__((vector_size(8 * directions), aligned(8)));

    double value;
    Tangent tangent;

    Dual() = default;
    Dual(double constant) : value(constant), tangent{} {}
    Dual(double at, const Tangent& along) : value(at), tangent(along) {}

    Dual& operator+=(const Dual& b) { return *this = *this + b; }
    Dual& operator-=(const Dual& b) { return *this = *this - b; }
    Dual& operator*=(const Dual& b) { return *this = *this * b; }
    Dual& operator/=(const Dual& b) { return *this = *this / b; }

    friend Dual operator-(const Dual& a) { return {-a.value, -a.tangent}; }
    friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.tangent + b.tangent}; }
    friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.tangent - b.tangent}; }
    friend Dual operator*(const Dual& a, const Dual& b) {
        return {a.value * b.value, a.tangent * b.value + a.value * b.tangent};
    }
    friend Dual operator/(const Dual& a, const Dual& b) {
        const double quotient = a.value / b.value;
        return {quotient, (a.tangent - quotient * b.tangent) / b.value};
    }

    // Comparisons look at values alone: code takes the branches that it takes for doubles.
    friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
    friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
    friend bool operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
    friend bool operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }
    friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
    friend bool operator!=(const Dual& a, const Dual& b) { return a.value != b.value; }
};

inline Dual multiply_add(const Dual& a, const Dual& b, const Dual& c) { return a * b + c; }
inline double value_of(const Dual& x) { return x.value; }

// f(x) from its value and its slope at x.
inline Dual chain(double value, double slope, const Dual& x) { return {value, slope * x.tangent}; }

inline Dual sqrt(const Dual& x) {
    const double root = std::sqrt(x.value);
    return chain(root, 0.5 / root, x);
}
inline SineAndCosine<Dual> sine_and_cosine(const Dual& x) {
    const auto [sine, cosine] = sine_and_cosine(x.value);
    return {chain(sine, cosine, x), chain(cosine, -sine, x)};
}
inline Dual sin(const Dual& x) { return sine_and_cosine(x).sine; }
inline Dual cos(const Dual& x) { return sine_and_cosine(x).cosine; }
inline Dual tan(const Dual& x) {
    const double value = std::tan(x.value);
    return chain(value, 1.0 + value * value, x);
}
inline Dual asin(const Dual& x) { return chain(std::asin(x.value), 1.0 / std::sqrt(1.0 - x.value * x.value), x); }
inline Dual acos(const Dual& x) { return chain(std::acos(x.value), -1.0 / std::sqrt(1.0 - x.value * x.value), x); }
inline Dual atan(const Dual& x) { return chain(std::atan(x.value), 1.0 / (1.0 + x.value * x.value), x); }
inline Dual atan2(const Dual& y, const Dual& x) {
    const double square = x.value * x.value + y.value * y.value;
    return {std::atan2(y.value, x.value), (x.value * y.tangent - y.value * x.tangent) / square};
}
inline Dual hypot(const Dual& x, const Dual& y) {
    const double length = std::hypot(x.value, y.value);
    return {length, (x.value * x.tangent + y.value * y.tangent) / length};
}
inline Dual sinh(const Dual& x) { return chain(std::sinh(x.value), std::cosh(x.value), x); }
inline Dual cosh(const Dual& x) { return chain(std::cosh(x.value), std::sinh(x.value), x); }
inline Dual tanh(const Dual& x) {
    const double value = std::tanh(x.value);
    return chain(value, 1.0 - value * value, x);
}
inline Dual exp(const Dual& x) {
    const double value = std::exp(x.value);
    return chain(value, value, x);
}
inline Dual log(const Dual& x) { return chain(std::log(x.value), 1.0 / x.value, x); }
// With the exponent 0 the slope is 0, even where 1 / x is not defined.
inline Dual pow(const Dual& x, double exponent) {
    return chain(std::pow(x.value, exponent), exponent == 0.0 ? 0.0 : exponent * std::pow(x.value, exponent - 1.0), x);
}
inline Dual pow(const Dual& x, const Dual& exponent) {
    const Dual by_base = pow(x, exponent.value);
    const double grown = by_base.value * std::log(x.value);
    return {by_base.value, std::isfinite(grown) ? by_base.tangent + grown * exponent.tangent : by_base.tangent};
}
inline Dual abs(const Dual& x) { return x.value < 0.0 ? -x : x; }
inline Dual max(const Dual& a, const Dual& b) { return a.value < b.value ? b : a; }
inline Dual min(const Dual& a, const Dual& b) { return b.value < a.value ? b : a; }

// Functions that jump have the slope 0 between their jumps.
inline Dual floor(const Dual& x) { return std::floor(x.value); }
inline Dual ceil(const Dual& x) { return std::ceil(x.value); }
inline Dual nearbyint(const Dual& x) { return std::nearbyint(x.value); }
inline Dual remainder(const Dual& x, double period) { return {std::remainder(x.value, period), x.tangent}; }
inline Dual wrapped(const Dual& x, double most, double period) { return {wrapped(x.value, most, period), x.tangent}; }

inline bool isnan(const Dual& x) { return std::isnan(x.value); }
inline bool isfinite(const Dual& x) {
    bool finite = std::isfinite(x.value);
    for (int k = 0; k < Dual::directions; ++k) finite = finite && std::isfinite(x.tangent[k]);
    return finite;
}

}  // namespace mbproj
