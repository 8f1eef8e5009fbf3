// Finds dependent rows, and how the stops may share because of them.
#include "contact/shares.hpp"

#include <algorithm>
#include <cmath>

#include "model/decompositions.hpp"
#include "model/semidefinite.hpp"

namespace mbproj {

std::vector<Eigen::Index> independent(const Eigen::MatrixXd& B, std::vector<Eigen::Index> rows, double least) {
    SemidefiniteCholesky cholesky;
    cholesky.factor(B(rows, rows), least);
    std::vector<Eigen::Index> found;
    for (const auto k : cholesky.rows()) found.push_back(rows[static_cast<std::size_t>(k)]);
    std::sort(found.begin(), found.end());
    return found;
}

double Span::beyond(Eigen::Index row, Eigen::VectorXd& along) const {
    along = B_.col(row);
    for (const Eigen::VectorXd& each : basis_) along -= each[row] * each;
    return along[row];
}

double Span::part_beyond(Eigen::Index row) const {
    Eigen::VectorXd along;
    const double left = beyond(row, along);
    return left > 0.0 ? left / B_(row, row) : 0.0;
}

bool Span::takes(Eigen::Index row) {
    Eigen::VectorXd along;
    const double left = beyond(row, along);
    if (!(left > least_ * B_(row, row))) return false;
    basis_.push_back(along / std::sqrt(left));
    return true;
}

bool shares_of(const Eigen::MatrixXd& B, const Eigen::MatrixXd& B_pulled, const Eigen::VectorXd& push,
               const Thresholds& thresholds, Shares& found) {
    using Index = Eigen::Index;
    const Index count = push.size();
    std::vector<Index> pushing;
    for (Index k = 0; k < count; ++k)
        if (push[k] > 0.0) pushing.push_back(k);
    if (pushing.empty()) return false;
    found.rows = independent(B, pushing, thresholds.no_push);
    const auto rank = static_cast<Index>(found.rows.size());
    const Eigen::MatrixXd own = B(found.rows, found.rows), across = B(found.rows, Eigen::all);
    Eigen::MatrixXd C(count, rank);
    for (Index k = 0; k < count; ++k) C.row(k) = solved(own, across.col(k));
    for (std::size_t r = 0; r < found.rows.size(); ++r)
        C.row(found.rows[r]) = Eigen::VectorXd::Unit(rank, static_cast<Index>(r));
    const double none = thresholds.no_push * B.diagonal().maxCoeff();
    found.apart.assign(static_cast<std::size_t>(count), false);
    Index together = 0;
    for (Index k = 0; k < count; ++k) {
        const double left = B(k, k) - C.row(k).dot(across.col(k));
        const bool apart = left > thresholds.no_push * B(k, k) || !(B(k, k) > none);
        found.apart[static_cast<std::size_t>(k)] = apart;
        if (!apart) ++together;
    }
    if (together == rank) return false;
    const Eigen::MatrixXd C_pushing = C(pushing, Eigen::all), square = C_pushing.transpose() * C_pushing;
    found.parts.resize(count, rank);
    for (Index k = 0; k < count; ++k) found.parts.row(k) = solved(square, C.row(k).transpose());
    const Eigen::VectorXd borne = C_pushing.transpose() * push(pushing);
    found.idle.assign(static_cast<std::size_t>(count), false);
    for (Index k = 0; k < count; ++k)
        found.idle[static_cast<std::size_t>(k)] = !(push[k] > 0.0) && !found.apart[static_cast<std::size_t>(k)];
    for (const Index k : pushing) {
        const double off = push[k] - found.parts.row(k).dot(borne);
        found.parts.row(k) += off / borne.squaredNorm() * borne.transpose();
    }
    const double most = B_pulled.diagonal().maxCoeff();
    found.decides = false;
    for (const Index k : pushing) {
        if (std::binary_search(found.rows.begin(), found.rows.end(), k)) continue;
        Eigen::VectorXd open = Eigen::VectorXd::Unit(count, k);
        for (std::size_t r = 0; r < found.rows.size(); ++r) open[found.rows[r]] -= C(k, static_cast<Index>(r));
        const double effect = open.dot(B_pulled * open) / open.squaredNorm();
        found.decides = found.decides || effect > thresholds.no_push * most;
    }
    return true;
}

}  // namespace mbproj
