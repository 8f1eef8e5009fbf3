// Linear equations, by Eigen.
#if defined(__GNUC__) && !defined(__clang__)  // GCC takes an ordering of Eigen's sparse LU for one that is not set
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SparseLU>

#include "algebra/decompositions.hpp"

namespace mbproj {

Eigen::VectorXd solved(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) { return A.partialPivLu().solve(b); }
Eigen::MatrixXd solved_columns(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) { return A.partialPivLu().solve(B); }

Eigen::VectorXd least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
    return A.completeOrthogonalDecomposition().solve(b);
}

namespace {

// A larger matrix is factored as a sparse one.
constexpr int largest_dense = 64;

int dense_sign(const Eigen::MatrixXd& A) {
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(A);
    double sign = static_cast<double>(lu.permutationP().determinant());
    for (Eigen::Index k = 0; k < A.rows(); ++k) {
        const double pivot = lu.matrixLU()(k, k);
        sign = pivot > 0.0 ? sign : pivot < 0.0 ? -sign : 0.0;
    }
    return static_cast<int>(sign);
}

}  // namespace

int determinant_sign(int size, const std::vector<Entry>& entries) {
    if (size <= largest_dense) {
        Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size, size);
        for (const Entry& each : entries) A(each.row, each.column) = each.value;
        return dense_sign(A);
    }
    std::vector<Eigen::Triplet<double>> all;
    all.reserve(entries.size());
    for (const Entry& each : entries) all.emplace_back(each.row, each.column, each.value);
    Eigen::SparseMatrix<double> A(size, size);
    A.setFromTriplets(all.begin(), all.end());
    A.makeCompressed();
    Eigen::SparseLU<Eigen::SparseMatrix<double>> lu(A);
    return lu.info() == Eigen::Success ? static_cast<int>(lu.signDeterminant()) : 0;
}

}  // namespace mbproj
