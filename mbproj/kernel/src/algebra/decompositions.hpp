// Decompositions by Eigen. Its templates are compiled once, in the .cpp files of this folder.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "algebra/operators.hpp"

namespace mbproj {

// The solution of A x = b.
Eigen::VectorXd solved(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
Eigen::MatrixXd solved_columns(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
// The least-squares solution of minimum norm, for a matrix that may be singular.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
// An entry of a matrix in which most are 0.
struct Entry {
    int row, column;
    double value;
};
// The sign of the determinant of a square matrix: 1, -1 or 0.
int determinant_sign(int size, const std::vector<Entry>& entries);

// The least and the largest eigenvalue of a symmetric matrix, for N = 1 and 3.
struct EigenvalueRange {
    double least, most;
};
template <int N> EigenvalueRange eigenvalue_range(const Matrix<N, N>& A);
// R with RᵀR = A, where negative eigenvalues count as 0.
template <int N> Matrix<N, N> root(const Matrix<N, N>& A);
// K⁻¹ with A = K Kᵀ, K lower triangular; A is positive definite.
template <int N> Matrix<N, N> inverse_root(const Matrix<N, N>& A);
// The Frobenius norm of A⁻¹.
template <int N> double norm_of_inverse(const Matrix<N, N>& A);

// The loops' equations by an orthogonal factorisation of Y. S = YᵀY has the square of Y's condition number, too much
// where masses of neighbours differ by more than S has digits for. Dense, and used only there.
class DenseQr final {
public:
    // Y P = Q R, with pivots by the remaining lengths of the columns. The columns of Y are the rows of the constraints.
    void factor(const Eigen::MatrixXd& Y);
    // Moves w to the nearest w - Yλ with Yᵀ(w - Yλ) = c; gives λ.
    void solve(Eigen::VectorXd& w, const Eigen::VectorXd& c, Eigen::VectorXd& lambda) const;

private:
    struct Factor;
    std::shared_ptr<const Factor> factor_;
};

}  // namespace mbproj
