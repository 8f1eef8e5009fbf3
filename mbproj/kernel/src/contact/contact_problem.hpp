// All contacts and frictions that hold at an instant, as one problem on the Delassus operator B of their rows.
//
// Forces y along the rows change accelerations b to b + B y. Each foot is a spring, and all have one stiffness; the
// cone of the foot limits the force: y = P(u), with P the projection onto the cones, and -u the springs' deflections.
// For rigid feet u is in the range of B, and the rows that are held do not accelerate. No row is preferred; rows may
// depend on each other. Where all stick, y is the least-norm share within the cones. Where all slide, it is the limit
// of (B + ε I) y + b = 0 for ε -> 0.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "model/thresholds.hpp"

namespace mbproj {

// The forces that one contact may have: its normal row, -1 for a joint's friction, and its friction rows. It sticks
// with up to `most`, a coefficient or a force; or it slides, with the parts `slides` of the push along the tangents.
struct Cone {
    int push = -1;
    std::vector<int> tangents;
    double most = 0.0;
    std::vector<double> slides;
};

// The forces y along all rows with which no held row accelerates: pushes, and tangents that stick. False where no forces within
// the cones do that. B is symmetric.
bool contact_problem(const Eigen::MatrixXd& B, const Eigen::VectorXd& b, const std::vector<Cone>& cones,
                     const Thresholds& thresholds, Eigen::VectorXd& y);

}  // namespace mbproj
