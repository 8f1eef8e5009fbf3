// One-sided conditions on a border: pushes z >= 0 with B z + b >= 0 and zᵀ(B z + b) = 0. Rows may depend on each other; then
// several z cause the same motion.
#pragma once

#include <Eigen/Core>

namespace mbproj {

// False where no pushes fulfil all conditions. `none` is the part that counts as round-off.
bool one_sided(const Eigen::MatrixXd& B, const Eigen::VectorXd& b, double none, Eigen::VectorXd& z);

}  // namespace mbproj
