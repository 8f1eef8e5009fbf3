// Dense linear equations, by Eigen.
#include <Eigen/LU>
#include <Eigen/QR>

#include "algebra/decompositions.hpp"

namespace mbproj {

Eigen::VectorXd solved(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) { return A.partialPivLu().solve(b); }

Eigen::VectorXd least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
    return A.completeOrthogonalDecomposition().solve(b);
}

}  // namespace mbproj
