// What needs a decomposition, by Eigen. Its templates are compiled once, in the .cpp files of this folder.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "algebra/operators.hpp"

namespace mbproj {

// The solution of A x = b.
Eigen::VectorXd solved(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
Eigen::MatrixXd solved_columns(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
// The smallest of the x next to a solution, for a matrix that may be singular.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
// An entry of a matrix in which most are 0.
struct Entry {
    int row, column;
    double value;
};
// Of the determinant of a square matrix: 1, -1, or 0 where it is 0.
int determinant_sign(int size, const std::vector<Entry>& entries);

// Of a symmetric matrix, for N = 1, 3 and 6: its least and its largest eigenvalue.
struct EigenvalueRange {
    double least, most;
};
template <int N> EigenvalueRange eigenvalue_range(const Matrix<N, N>& A);
// R with RᵀR = A, where negative eigenvalues count as none.
template <int N> Matrix<N, N> root(const Matrix<N, N>& A);
// K⁻¹ with A = K Kᵀ, K lower triangular; A is positive definite.
template <int N> Matrix<N, N> inverse_root(const Matrix<N, N>& A);
// |A⁻¹|, the root of the sum of its squares.
template <int N> double norm_of_inverse(const Matrix<N, N>& A);

// The loops' equations by an orthogonal factorisation of Y itself, which S = YᵀY squares the condition of: for neighbours
// whose masses differ by more than S has digits for. Dense, and used only there.
class DenseQr final {
public:
    // Y P = Q R with the columns, which are the constraints' rows, in the order of their remaining lengths.
    void factor(const Eigen::MatrixXd& Y);
    // The w next to the one given with Yᵀw = c, and the λ by which it is moved: w - Yλ.
    void solve(Eigen::VectorXd& w, const Eigen::VectorXd& c, Eigen::VectorXd& lambda) const;

private:
    struct Factor;
    std::shared_ptr<const Factor> factor_;
};

}  // namespace mbproj
