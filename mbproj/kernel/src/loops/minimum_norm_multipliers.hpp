// Where rows of G follow from others, G_R = T G_K, many λ balance the same forces: (λ_K - Tᵀμ, μ) for any μ. The smallest
// of them, rows weighed with the lengths that they are measured in, so that torques and forces compare.
#pragma once

#include "algebra/decompositions.hpp"
#include "loops/delassus_matrix.hpp"

namespace mbproj {

// T, rows left out × rows held, by the factor of S at hand: T S = Y_RᵀY_K; a second solution, on what the first leaves of
// Y_R, gives back the digits that S squares away.
template <int D> Eigen::MatrixXd combinations(const DelassusMatrix<D>& rows, const Pose<D>& pose, int left_out) {
    using Y = Column<Size<D>::freedoms>;
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(left_out, rows.count());
    std::vector<int> begin(1, 0);
    for (const auto& some : rows.layout().left_out()) begin.push_back(begin.back() + some.count);
    std::vector<std::vector<Y>> open(left_out, std::vector<Y>(rows.halves.size(), Y::Zero()));
    for (const auto& at : rows.left_out_incidences(pose))
        for (int r = 0; r < at.count; ++r) open[begin[at.held] + r][at.body] = at.Y.col(r);
    Eigen::VectorXd share(rows.count());
    std::vector<double> turned(rows.flywheels().size());
    for (int left = 0; left < left_out; ++left) {
        std::fill(turned.begin(), turned.end(), 0.0);
        for (int pass = 0; pass < 2; ++pass) {
            share.setZero();
            for (std::size_t f = 0; f < turned.size(); ++f)
                share[rows.flywheels()[f].row] = rows.y(rows.flywheels()[f]) * turned[f];
            rows.add_products(open[left], share.data());
            rows.cholesky.solve(share.data());
            T.row(left) += share;
            rows.subtract_products(share.data(), open[left]);
            for (std::size_t f = 0; f < turned.size(); ++f)
                turned[f] -= share[rows.flywheels()[f].row] * rows.y(rows.flywheels()[f]);
        }
    }
    return T;
}

// λ, at the model's rows, from those of the rows that are held: (T W_K² Tᵀ + W_R²) μ = T W_K² λ_K.
template <int D>
void spread(const DelassusMatrix<D>& rows, const Model<D>& model, const Pose<D>& pose, double* lambda) {
    const auto numbers = [&model](const auto& list) {
        std::vector<int> found;
        for (const auto& some : list)
            for (int r = 0; r < some.count; ++r) found.push_back(model.joints[some.joint].row + some.rows[r]);
        return found;
    };
    const std::vector<int> left_out = numbers(rows.layout().left_out());
    if (left_out.empty()) return;
    const std::vector<int> held = numbers(rows.held());
    const Eigen::MatrixXd T = combinations(rows, pose, static_cast<int>(left_out.size()));
    Eigen::VectorXd weight(held.size()), own(held.size());
    for (std::size_t k = 0; k < held.size(); ++k) {
        weight[k] = model.row_scale[held[k]] * model.row_scale[held[k]];
        own[k] = lambda[held[k]];
    }
    const Eigen::MatrixXd weighed = T * weight.asDiagonal();
    Eigen::MatrixXd A = weighed * T.transpose();
    for (std::size_t r = 0; r < left_out.size(); ++r)
        A(r, r) += model.row_scale[left_out[r]] * model.row_scale[left_out[r]];
    const Eigen::VectorXd mu = solved_positive(A, weighed * own);
    own -= T.transpose() * mu;
    for (std::size_t k = 0; k < held.size(); ++k) lambda[held[k]] = own[k];
    for (std::size_t r = 0; r < left_out.size(); ++r) lambda[left_out[r]] = mu[r];
}

}  // namespace mbproj
