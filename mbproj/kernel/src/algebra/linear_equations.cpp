// Dense linear equations, by Eigen.
#include <Eigen/LU>

#include "algebra/decompositions.hpp"

namespace mbproj {

Eigen::VectorXd solved(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) { return A.partialPivLu().solve(b); }

}  // namespace mbproj
