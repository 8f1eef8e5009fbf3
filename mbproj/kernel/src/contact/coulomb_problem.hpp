// Coulomb's law at an instant, for rows that may depend on each other: which contacts open, which stick, which slide.
//
// Forces y along the rows change accelerations b to a = b + B y. A stop opens or pushes: y_n >= 0, a_n >= 0, y_n a_n = 0. A
// friction at rest holds, a_t = 0, or exerts all that it can against its acceleration. Rigid rows that depend on each other leave
// y open, so each row gives way like a spring: a + c y takes the place of a, with a compliance c so small that the motion is that
// of rigid rows. Unlike `contact_problem`, which asks whether all can stick, this problem always moves as the bodies do.
#pragma once

#include "contact/contact_problem.hpp"

namespace mbproj {

// The forces y along all rows, and the accelerations a. False where Newton's method finds none.
bool coulomb_problem(const Eigen::MatrixXd& B, const Eigen::VectorXd& b, const std::vector<Cone>& cones,
                     const Thresholds& thresholds, Eigen::VectorXd& y, Eigen::VectorXd& a);

}  // namespace mbproj
