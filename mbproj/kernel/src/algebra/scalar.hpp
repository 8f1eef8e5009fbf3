// The numbers of the kernel: double, or a type of ours with the same functions. The functions of double stand in this
// namespace, so that a name finds the function of the type at hand.
#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "algebra/sine.hpp"

namespace mbproj {

using std::abs, std::sqrt, std::tan, std::acos, std::asin, std::atan, std::atan2, std::hypot;
using std::cosh, std::sinh, std::tanh, std::exp, std::log, std::pow, std::floor, std::ceil, std::copysign;
using std::isfinite, std::isnan, std::max, std::min, std::nearbyint, std::remainder;

// The value of a number, without derivatives; comparisons look at it.
inline double value_of(double x) { return x; }
template <class S> using ValueOf = std::decay_t<decltype(value_of(std::declval<S>()))>;

// a b + c, rounded once where the processor does that in one instruction. Elsewhere the compiler contracts nothing
// (-ffp-contract=off), so that doubles and packs have the same bits.
[[gnu::always_inline]] inline double multiply_add(double a, double b, double c) {
#ifdef __FMA__
    return __builtin_fma(a, b, c);
#else
    return a * b + c;
#endif
}

// Whether a number is a pack: the numbers of several cases side by side.
template <class S> constexpr bool is_pack = false;

// a where the condition holds, else b; for packs, lane by lane.
template <class S> inline S where(bool holds, const S& a, const S& b) { return holds ? a : b; }
inline bool any(bool holds) { return holds; }

// Number `at` of a list; in a pack, each lane has an `at` of its own.
template <class S> inline const S& pick(const std::vector<S>& numbers, int at) { return numbers[at]; }
// How many of some ascending numbers are not above a value.
inline int rank(const double* first, const double* last, double value) {
    return static_cast<int>(std::upper_bound(first, last, value) - first);
}

// x, less whole periods where |x| exceeds `most`.
inline double wrapped(double x, double most, double period) { return abs(x) <= most ? x : remainder(x, period); }

}  // namespace mbproj
