// An impact with friction, followed along the impulses of the stops (Routh 1905; Darboux 1880; Keller 1986; Stronge 1990).
//
// The normal impulses grow in fixed proportions, dz_n = d dp. With u = (u_n, u_t) the rates along normals and tangents, du/dp =
// B (d, f). The friction f of each stop slides, f = -μ d u_t/|u_t|, or sticks with |f| <= μ d: a convex problem, which has one
// motion for any d. Compression ends where the stops' power dᵀu_n is no longer negative. Each stop takes work while its gap
// closes. Expansion ends where all together have given back the parts e² of what each took. Friction opposes sliding all along
// the way, so that no energy is created.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "model/thresholds.hpp"

namespace mbproj {

// Friction along tangents of stops that touch: each tangent's coefficient, the other tangent of its plane, and its stop.
struct Rubbing {
    std::vector<double> coefficient;
    std::vector<int> partner, by;

    Eigen::Index size() const { return static_cast<Eigen::Index>(coefficient.size()); }
};

// The impulses along all rows of B, those of stops and then of their tangents, and the work of each, from rates u. Stops push in
// the proportions `push`. `moves`: the rows that can move. Where sticking stops jam, so that no push opens a gap any more, they
// keep what they took. False where pushes cannot end the closing.
bool follow_impulse(const Eigen::MatrixXd& B, const Eigen::VectorXd& u, const Eigen::VectorXd& push,
                    const Eigen::VectorXd& restitution, const Rubbing& rubbing, const std::vector<bool>& moves,
                    const Thresholds& thresholds, Eigen::VectorXd& impulse, Eigen::VectorXd& work);

}  // namespace mbproj
