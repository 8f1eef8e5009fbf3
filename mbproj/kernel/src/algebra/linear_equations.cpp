// Dense linear equations, by Eigen.
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "algebra/decompositions.hpp"

namespace mbproj {

Eigen::VectorXd solved(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) { return A.partialPivLu().solve(b); }
Eigen::VectorXd solved_positive(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) { return A.llt().solve(b); }

}  // namespace mbproj
