// The numbers of the kernel: double, or a type of ours with the same functions. The functions of double stand in this
// namespace, so that a name finds the function of the type at hand.
#pragma once

#include <algorithm>
#include <cmath>

#include "model/sine.hpp"

namespace mbproj {

using std::abs, std::sqrt, std::tan, std::acos, std::asin, std::atan, std::atan2, std::hypot;
using std::cosh, std::sinh, std::tanh, std::exp, std::log, std::pow, std::floor, std::ceil, std::copysign;
using std::isfinite, std::isnan, std::max, std::min, std::nearbyint, std::remainder;

// The value of a number, without derivatives; comparisons look at it.
inline double value_of(double x) { return x; }

// a b + c, rounded once where the processor does that in one instruction. Elsewhere the compiler contracts nothing
// (-ffp-contract=off).
[[gnu::always_inline]] inline double multiply_add(double a, double b, double c) {
#ifdef __FMA__
    return __builtin_fma(a, b, c);
#else
    return a * b + c;
#endif
}

// x, less whole periods where |x| exceeds `most`.
inline double wrapped(double x, double most, double period) { return abs(x) <= most ? x : remainder(x, period); }

}  // namespace mbproj
