// What the laws of contacts ask of rows and their forces.
#pragma once

#include <cstddef>
#include <limits>

#include <Eigen/Core>

namespace mbproj {

constexpr double tiny = std::numeric_limits<double>::min();

// The place of a row in a list.
inline std::size_t of(Eigen::Index k) { return static_cast<std::size_t>(k); }
inline double largest(const Eigen::VectorXd& x) { return x.size() ? x.cwiseAbs().maxCoeff() : 0.0; }

}  // namespace mbproj
