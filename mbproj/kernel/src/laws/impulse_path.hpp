// The impact of one rough stop, followed along its normal impulse p (Routh 1905; Keller 1986; Stronge 1990).
//
// With u = (u_n, u_t) the rates along the normal and the tangents, du/dp = B (1, f). Friction f slides, f = -μ u_t/|u_t|, or
// sticks, B_tt f = -B_tn with |f| <= μ. Until u_n = 0 the stop takes the energy W = -∫ u_n dp, and it returns e² W. This law
// creates no energy: friction opposes the sliding all along the way.
#pragma once

#include <Eigen/Core>

#include "model/thresholds.hpp"

namespace mbproj {

// The impulses along the normal and the tangents, and the work of each, at rates u before. False where the gap never stops closing.
bool follow_impulse(const Eigen::MatrixXd& B, const Eigen::VectorXd& u, double coefficient, double restitution,
                    const Thresholds& thresholds, Eigen::VectorXd& impulse, Eigen::VectorXd& work);

}  // namespace mbproj
