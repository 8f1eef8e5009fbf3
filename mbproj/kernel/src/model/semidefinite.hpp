// Small, dense systems with a positive semidefinite matrix, whose rows may depend on each other.
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

namespace mbproj {

// B = L Lᵀ of the independent rows. The pivot is the largest remaining part of a diagonal entry; rows whose part does
// not exceed `least` are left out.
class SemidefiniteCholesky final {
public:
    void factor(const Eigen::MatrixXd& B, double least) {
        left_ = B;
        columns_.resize(B.rows(), B.cols());
        rows_.clear();
        const Eigen::Index size = B.rows();
        while (static_cast<Eigen::Index>(rows_.size()) < size) {
            Eigen::Index best = -1;
            double most = least;
            for (Eigen::Index k = 0; k < size; ++k)
                if (B(k, k) > 0.0 && left_(k, k) > most * B(k, k)) most = left_(k, k) / B(k, k), best = k;
            if (best < 0) return;
            rows_.push_back(best);
            const auto rank = static_cast<Eigen::Index>(rows_.size());
            columns_.col(rank - 1) = left_.col(best) / std::sqrt(left_(best, best));
            for (Eigen::Index i = 0; i < size; ++i)
                for (Eigen::Index j = 0; j < size; ++j) left_(i, j) -= columns_(i, rank - 1) * columns_(j, rank - 1);
            left_(best, best) = 0.0;
        }
    }

    // The rows that are independent, in the order of their pivots.
    const std::vector<Eigen::Index>& rows() const { return rows_; }
    bool full() const { return static_cast<Eigen::Index>(rows_.size()) == left_.rows(); }

    // L of all rows, with B = L Lᵀ to round-off.
    auto root() const { return columns_.leftCols(static_cast<Eigen::Index>(rows_.size())); }

    // y with (B y + b) = 0 in the independent rows, and 0 in all others.
    void solve(const Eigen::VectorXd& b, Eigen::VectorXd& y) const {
        y = Eigen::VectorXd::Zero(b.size());
        const std::size_t rank = rows_.size();
        for (std::size_t i = 0; i < rank; ++i) {
            double sum = -b[rows_[i]];
            for (std::size_t j = 0; j < i; ++j) sum -= lower(i, j) * y[rows_[j]];
            y[rows_[i]] = sum / lower(i, i);
        }
        for (std::size_t i = rank; i-- > 0;) {
            double sum = y[rows_[i]];
            for (std::size_t j = i + 1; j < rank; ++j) sum -= lower(j, i) * y[rows_[j]];
            y[rows_[i]] = sum / lower(i, i);
        }
    }

private:
    double lower(std::size_t i, std::size_t j) const { return columns_(rows_[i], static_cast<Eigen::Index>(j)); }

    Eigen::MatrixXd left_, columns_;
    std::vector<Eigen::Index> rows_;
};

}  // namespace mbproj
