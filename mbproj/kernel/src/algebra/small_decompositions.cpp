// Eigenvalues and roots of matrices of few numbers, by Eigen.
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "algebra/decompositions.hpp"

namespace mbproj {

namespace {

template <int N> using Square = Eigen::Matrix<double, N, N>;

template <int N> Square<N> for_eigen(const Matrix<N, N>& A) { return Eigen::Map<const Square<N>>(A.data()); }
template <int N> Matrix<N, N> from_eigen(const Square<N>& A) { return matrix_at<N, N>(A.data()); }

}  // namespace

template <int N> EigenvalueRange eigenvalue_range(const Matrix<N, N>& A) {
    const Eigen::SelfAdjointEigenSolver<Square<N>> principal(for_eigen(A), Eigen::EigenvaluesOnly);
    return {principal.eigenvalues()[0], principal.eigenvalues()[N - 1]};
}

template <int N> Matrix<N, N> root(const Matrix<N, N>& A) {
    const Eigen::SelfAdjointEigenSolver<Square<N>> principal(for_eigen(A));
    const Square<N> found =
        principal.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * principal.eigenvectors().transpose();
    return from_eigen(found);
}

template <int N> Matrix<N, N> inverse_root(const Matrix<N, N>& A) {
    const Square<N> found = Eigen::LLT<Square<N>>(for_eigen(A)).matrixL().solve(Square<N>::Identity());
    return from_eigen(found);
}

template <int N> double norm_of_inverse(const Matrix<N, N>& A) { return for_eigen(A).inverse().norm(); }

template EigenvalueRange eigenvalue_range(const Matrix<1, 1>&);
template EigenvalueRange eigenvalue_range(const Matrix<3, 3>&);
template Matrix<1, 1> inverse_root(const Matrix<1, 1>&);
template Matrix<3, 3> inverse_root(const Matrix<3, 3>&);
template double norm_of_inverse(const Matrix<1, 1>&);
template double norm_of_inverse(const Matrix<3, 3>&);
template Matrix<1, 1> root(const Matrix<1, 1>&);
template Matrix<2, 2> root(const Matrix<2, 2>&);
template Matrix<3, 3> root(const Matrix<3, 3>&);

}  // namespace mbproj
