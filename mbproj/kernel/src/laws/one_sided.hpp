// One-sided conditions on a border: pushes z >= 0 with B z + b >= 0 and zᵀ(B z + b) = 0, B positive definite. The reference,
// mbproj.dynamics.contact.complementarity, also takes dependent rows.
#pragma once

#include "algebra/semidefinite.hpp"

namespace mbproj {

// The active-set method of Lawson and Hanson (1974, ch. 23): rows begin to push one by one, the most violated first, and those
// that would pull are released. False where that does not end.
inline bool one_sided(const Eigen::MatrixXd& B, const Eigen::VectorXd& b, double none, Eigen::VectorXd& z) {
    const Eigen::Index count = b.size();
    z = Eigen::VectorXd::Zero(count);
    Eigen::VectorXd scale = B.diagonal().cwiseSqrt(), left = b, trial;
    const double deepest = count ? (-b.array() / scale.array()).maxCoeff() : 0.0;
    if (!(deepest > 0.0)) return true;
    std::vector<Eigen::Index> pushing;
    SemidefiniteCholesky cholesky;
    const auto solve = [&] {
        const auto size = static_cast<Eigen::Index>(pushing.size());
        Eigen::MatrixXd own(size, size);
        Eigen::VectorXd wanted(size);
        for (Eigen::Index i = 0; i < size; ++i) {
            wanted[i] = b[pushing[i]];
            for (Eigen::Index j = 0; j < size; ++j) own(i, j) = B(pushing[i], pushing[j]);
        }
        cholesky.factor(own, none);
        cholesky.solve(wanted, trial);
        return cholesky.full();
    };
    constexpr int most_exchanges = 20;
    for (Eigen::Index exchange = 0; exchange < most_exchanges * count; ++exchange) {
        Eigen::Index best = -1;
        double most = none * deepest;
        for (Eigen::Index k = 0; k < count; ++k) {
            const bool free = std::find(pushing.begin(), pushing.end(), k) == pushing.end();
            if (free && -left[k] / scale[k] > most) most = -left[k] / scale[k], best = k;
        }
        if (best < 0) return true;
        pushing.push_back(best);
        while (true) {
            if (!solve()) return false;
            double way = 1.0;
            for (std::size_t i = 0; i < pushing.size(); ++i)
                if (const double now = z[pushing[i]], to = trial[static_cast<Eigen::Index>(i)]; to <= 0.0)
                    way = std::min(way, now > to ? now / (now - to) : 0.0);
            for (std::size_t i = 0; i < pushing.size(); ++i)
                z[pushing[i]] += way * (trial[static_cast<Eigen::Index>(i)] - z[pushing[i]]);
            if (way == 1.0) break;
            const double largest = z.maxCoeff();
            for (std::size_t i = pushing.size(); i-- > 0;)
                if (!(z[pushing[i]] > none * largest)) {
                    z[pushing[i]] = 0.0;
                    pushing.erase(pushing.begin() + static_cast<std::ptrdiff_t>(i));
                }
            if (pushing.empty()) return false;
        }
        left = b + B * z;
    }
    return false;
}

}  // namespace mbproj
