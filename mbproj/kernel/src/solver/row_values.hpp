// Numbers for each row: the values of the constraints, or their rates.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "kinematics/pose.hpp"

namespace mbproj {

// Sets the rows of flywheels to zero: they are never violated.
template <class D> void leave_flywheels(const Model<D>& model, std::vector<Scalar<D>>& rows) {
    std::fill(rows.begin() + model.constraints.rows, rows.end(), 0.0);
}

// The largest row, with lengths in parts of the mechanism's.
template <class D> Scalar<D> largest(const Model<D>& model, const std::vector<Scalar<D>>& rows) {
    Scalar<D> most = 0.0;
    for (std::size_t r = 0; r < rows.size(); ++r) most = larger(most, abs(rows[r]) / model.row_scale[r]);
    return most;
}

// The squared distance s² from the span of the others above which a row with the violation c is held.
inline double held_above(const Thresholds& thresholds, double c) {
    return std::pow(std::max(c, thresholds.least_violation), 2.0 / 3.0);
}

}  // namespace mbproj
