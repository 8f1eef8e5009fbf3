// What the kernel computes with: double, or a type of ours that the same text computes with. Functions of one stand in this
// namespace, so that their names find those of the type at hand.
#pragma once

#include <algorithm>
#include <cmath>

namespace mbproj {

using std::abs, std::sqrt, std::cos, std::sin, std::tan, std::acos, std::asin, std::atan, std::atan2, std::hypot;
using std::cosh, std::sinh, std::tanh, std::exp, std::log, std::pow, std::floor, std::ceil, std::copysign;
using std::isfinite, std::isnan, std::max, std::min, std::nearbyint, std::remainder;

// What a number is without anything that goes with it.
inline double value_of(double x) { return x; }

}  // namespace mbproj
