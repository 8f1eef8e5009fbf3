// The equations at single states: for tests, for the start of a run, and for reactions of planar scenes.
#pragma once

#include <optional>
#include <utility>

#include "correction.hpp"

namespace mbproj {

struct TopologyFacts {
    std::size_t leaves, core_bodies, core_joints, stored, filled;
};

template <int D> class Equations {
public:
    using S = Size<D>;
    using Numbers = std::vector<double>;

    Equations(const Model<D>& model, const Projection& projection)
        : model_(model), projection_(projection), dynamics_(model_, projection_),
          corrector_(dynamics_, projection_, phases_) {}
    Equations(const Equations&) = delete;
    Equations& operator=(const Equations&) = delete;

    Numbers constraint(double t, const double* y) {
        place(t, y);
        return rows(dynamics_.constraint());
    }
    Numbers constraint_velocity(double t, const double* y) {
        place(t, y);
        return rows(dynamics_.constraint_velocity(y));
    }
    Numbers gamma(double t, const double* y) {
        place(t, y);
        dynamics_.move(y, false);
        return rows(dynamics_.gamma());
    }

    // G in (δr, δθ global) of each body, rows × bodies × freedoms.
    Numbers jacobian(double t, const double* y) {
        place(t, y);
        const std::size_t width = static_cast<std::size_t>(S::freedoms) * model_.size();
        Numbers found(width * model_.all_rows());
        Matrix<6, S::freedoms> G;
        for (const Joint& joint : model_.joints)
            for (const int body : joint.bodies) {
                mbproj::jacobian<D>(model_, dynamics_.pose(), joint, body, G);
                for (int r = 0; r < joint.rows; ++r)
                    for (int c = 0; c < S::freedoms; ++c)
                        found[width * (joint.row + r) + S::freedoms * body + c] = G(r, c);
            }
        found.resize(width * model_.constraints.rows);
        return found;
    }

    // (r'', ω' in body axes) of each body and λ, or nothing where they are not unique. `coordinates` are the joints',
    // each to less than half a turn. `smallest`: the smallest λ where redundant rows leave it open.
    std::optional<std::pair<Numbers, Numbers>> accelerations(double t, const double* y, const Numbers& coordinates,
                                                             bool smallest) {
        Numbers slope(dynamics_.total()), lambda(model_.all_rows()), found;
        place(t, y, coordinates);
        if (!dynamics_.factor(Metric::mass)) return std::nullopt;
        dynamics_.move(y, false);
        if (!dynamics_.slope_at(y, slope.data(), lambda.data())) return std::nullopt;
        if (smallest) dynamics_.bordered().spread(dynamics_.pose(), lambda.data());
        for (int b = 0; b < model_.size(); ++b) {
            const double* a = slope.data() + S::state * b + S::pose;
            found.insert(found.end(), a, a + S::freedoms);
        }
        lambda.resize(model_.constraints.rows);
        return std::make_pair(std::move(found), std::move(lambda));
    }

    // The acceleration along the coordinates of these laws per unit force on each of them, row by row; nothing where that
    // is not unique.
    std::optional<Numbers> responses(double t, const double* y, const std::vector<int>& laws) {
        Numbers found;
        dynamics_.place(t, y);
        if (!dynamics_.factor(Metric::mass) || !dynamics_.responses(laws, found)) return std::nullopt;
        return found;
    }

    // The state after one exact Newton correction of its position.
    std::optional<Numbers> newton(double t, const double* y) {
        Numbers state = whole(y);
        if (!corrector_.newton(t, state.data())) return std::nullopt;
        state.resize(dynamics_.size());
        return state;
    }

    // The state moved to the constraints, position and velocity.
    std::optional<Numbers> corrected(double t, const double* y) {
        Numbers state = whole(y);
        if (!corrector_.anywhere(t, state.data()).regular) return std::nullopt;
        state.resize(dynamics_.size());
        return state;
    }

    // Rows that follow from the others at this state, up to a distance of √smallest.
    int dependent_rows(double t, const double* y, double smallest) {
        place(t, y);
        return dynamics_.bordered().dependent_rows(dynamics_.pose(), smallest);
    }

    int singular_joint() { return dynamics_.bordered().singular_joint(); }
    const Model<D>& model() const { return model_; }
    TopologyFacts facts() const {
        const auto& topology = dynamics_.bordered().topology();
        const auto& cholesky = dynamics_.bordered().cholesky();
        return {topology.leaves.size(), topology.core_bodies.size(), topology.core_joints.size(), cholesky.stored(),
                cholesky.filled()};
    }

private:
    // The bodies' state y and what is integrated beside it; the angles that are followed, where there are any.
    Numbers whole(const double* y, const Numbers& coordinates = {}) const {
        Numbers state(y, y + dynamics_.size());
        state.resize(dynamics_.total());
        if (model_.follows_angles) std::copy(coordinates.begin(), coordinates.end(), state.begin() + dynamics_.followed());
        return state;
    }
    void place(double t, const double* y, const Numbers& coordinates = {}) {
        dynamics_.place(t, whole(y, coordinates).data());
    }

    Numbers rows(const double* values) const { return {values, values + model_.constraints.rows}; }

    const Model<D> model_;
    const Projection projection_;
    Phases phases_;
    Dynamics<D> dynamics_;
    Corrector<D> corrector_;
};

}  // namespace mbproj
