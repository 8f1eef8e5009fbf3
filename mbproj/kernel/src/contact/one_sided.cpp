// With B = N Nᵀ the smallest x with N x + b >= 0 is sought, x = Nᵀz: a least-distance problem, by non-negative least squares
// (Lawson and Hanson 1974, ch. 23), without regularisation.
#include "contact/one_sided.hpp"

#include "model/decompositions.hpp"
#include "model/semidefinite.hpp"

namespace mbproj {

namespace {

using Index = Eigen::Index;
using Vector = Eigen::VectorXd;
using Rows = std::vector<Index>;

// The u >= 0 with the least |E u - goal|.
Vector non_negative(const Eigen::MatrixXd& E, const Vector& goal, double none) {
    constexpr int most_exchanges = 20;  // per unknown
    Vector u = Vector::Zero(E.cols());
    Rows free;
    for (Index exchange = 0; exchange < most_exchanges * E.cols(); ++exchange) {
        Vector slope = E.transpose() * (goal - E * u);
        for (const Index k : free) slope[k] = -1.0;
        Index best;
        if (!(slope.maxCoeff(&best) > none)) break;
        free.push_back(best);
        while (!free.empty()) {
            const Vector trial = least_squares(E(Eigen::all, free), goal);
            double way = 1.0;
            for (std::size_t i = 0; i < free.size(); ++i)
                if (const double now = u[free[i]], to = trial[static_cast<Index>(i)]; to <= 0.0)
                    way = std::min(way, now > to ? now / (now - to) : 0.0);
            for (std::size_t i = 0; i < free.size(); ++i)
                u[free[i]] += way * (trial[static_cast<Index>(i)] - u[free[i]]);
            if (way == 1.0) break;
            const double least = none * u.maxCoeff();
            const auto is_back = [&](Index k) { return !(u[k] > least) && (u[k] = 0.0, true); };
            free.erase(std::remove_if(free.begin(), free.end(), is_back), free.end());
        }
    }
    return u;
}

// The least z with B z + b = 0, to round-off.
Vector equalised(const Eigen::MatrixXd& B, const Vector& b, double none) {
    SemidefiniteCholesky cholesky;
    cholesky.factor(B, none);
    Vector z;
    if (cholesky.full()) return cholesky.solve(b, z), z;
    const Eigen::MatrixXd N = cholesky.root(), square = N.transpose() * N;
    return N * solved(square, solved(square, -N.transpose() * b));
}

}  // namespace

bool one_sided(const Eigen::MatrixXd& B, const Vector& b, double none, Vector& z) {
    z = Vector::Zero(b.size());
    const double deepest = b.size() ? -b.minCoeff() : 0.0;
    if (!(deepest > 0.0)) return true;
    const Vector size = B.diagonal().cwiseMax(0.0).cwiseSqrt();
    Rows able;
    for (Index k = 0; k < b.size(); ++k)
        if (size[k] > none * size.maxCoeff())
            able.push_back(k);
        else if (-b[k] > none * deepest)
            return false;
    if (able.empty()) return false;
    const Vector length = size(able), wanted = -b(able).cwiseQuotient(length);
    const Eigen::MatrixXd unit =
        length.cwiseInverse().asDiagonal() * B(able, able) * length.cwiseInverse().asDiagonal();
    SemidefiniteCholesky cholesky;
    cholesky.factor(unit, none);
    const Eigen::MatrixXd N = cholesky.root();
    Eigen::MatrixXd E(N.cols() + 1, N.rows());
    E << N.transpose(), wanted.transpose() / wanted.cwiseAbs().maxCoeff();
    const Vector goal = Vector::Unit(E.rows(), E.rows() - 1), u = non_negative(E, goal, none);
    if (!((goal - E * u)[E.rows() - 1] > none)) return false;
    Rows pressing;
    for (Index k = 0; k < u.size(); ++k)
        if (u[k] > 0.0) pressing.push_back(k);
    const Vector push = equalised(unit(pressing, pressing), -wanted(pressing), none);
    for (std::size_t i = 0; i < pressing.size(); ++i)
        z[able[static_cast<std::size_t>(pressing[i])]] =
            std::max(push[static_cast<Index>(i)], 0.0) / length[pressing[i]];
    return true;
}

}  // namespace mbproj
