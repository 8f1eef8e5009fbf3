// Decompositions of matrices, after Golub & Van Loan, Matrix Computations, 2013: LU, pivoted QR, eigenvalues. Compiled once.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "model/operators.hpp"

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

// Of symmetric matrices of up to three rows: the least and the largest eigenvalue.
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

// An orthogonal factorisation Y P = Q R: Householder's reflections, with pivots by the remaining lengths of the columns.
class PivotedQr final {
public:
    void factor(const Eigen::MatrixXd& Y);
    // The shortest x of those with the least |Y x - b|; Y may have dependent columns.
    Eigen::VectorXd least_squares(Eigen::VectorXd b) const;
    // Moves w to the nearest w - Yλ with Yᵀ(w - Yλ) = c; gives λ. The columns of Y are independent.
    void solve(Eigen::VectorXd& w, const Eigen::VectorXd& c, Eigen::VectorXd& lambda) const;

private:
    using Index = Eigen::Index;

    double& R(Index row, Index column) { return R_[row * columns_ + column]; }
    double R(Index row, Index column) const { return R_[row * columns_ + column]; }
    Index rank() const;
    void reflect(Index k, Eigen::VectorXd& x) const;

    Index rows_ = 0, columns_ = 0, size_ = 0;  // size_: the smaller of both
    std::vector<double> R_, v_, tau_;          // R by rows; reflections 1 - τ v vᵀ, each v in a column of rows_ numbers
    std::vector<Index> pivots_;                // column k of Q R is this column of Y
};

}  // namespace mbproj
