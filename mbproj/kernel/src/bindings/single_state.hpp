// The equations at single states: for tests, for the start of a run, and for reactions of planar scenes.
#pragma once

#include <optional>
#include <utility>

#include "projection/projector.hpp"

namespace mbproj {

struct EliminationFacts {
    std::size_t leaves, loop_bodies, loop_joints, stored, filled;
};

template <int D> class SingleState {
public:
    using S = Size<D>;
    using Numbers = std::vector<double>;

    SingleState(const Model<D>& model, const ProjectionSettings& projection)
        : model_(model), projection_(projection), equations_(model_, projection_),
          projector_(equations_, projection_, phases_) {}
    SingleState(const SingleState&) = delete;
    SingleState& operator=(const SingleState&) = delete;

    Numbers constraint(double t, const double* y) {
        place(t, y);
        return rows(equations_.constraint());
    }
    Numbers constraint_velocity(double t, const double* y) {
        place(t, y);
        return rows(equations_.constraint_velocity(y));
    }
    Numbers gamma(double t, const double* y) {
        place(t, y);
        equations_.set_velocities(y, false);
        return rows(equations_.gamma());
    }

    // G in (δr, δθ global) of each body, rows × bodies × freedoms.
    Numbers jacobian(double t, const double* y) {
        place(t, y);
        const std::size_t width = static_cast<std::size_t>(S::freedoms) * model_.size();
        Numbers found(width * model_.all_rows());
        Matrix<6, S::freedoms> G;
        for (const Joint& joint : model_.joints)
            for (const int body : joint.bodies) {
                mbproj::jacobian<D>(model_, equations_.pose(), joint, body, G);
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
        Numbers slope(equations_.total()), lambda(model_.all_rows()), found;
        place(t, y, coordinates);
        if (!equations_.factor(Metric::mass)) return std::nullopt;
        equations_.set_velocities(y, false);
        if (!equations_.slope_at(y, slope.data(), lambda.data())) return std::nullopt;
        if (smallest) equations_.solver().spread(equations_.pose(), lambda.data());
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
        equations_.set_pose(t, y);
        if (!equations_.factor(Metric::mass) || !equations_.responses(laws, found)) return std::nullopt;
        return found;
    }

    // The state after one exact Newton correction of its position.
    std::optional<Numbers> newton(double t, const double* y) {
        Numbers state = whole(y);
        if (!projector_.newton(t, state.data())) return std::nullopt;
        state.resize(equations_.size());
        return state;
    }

    // The state moved to the constraints, position and velocity.
    std::optional<Numbers> corrected(double t, const double* y) {
        Numbers state = whole(y);
        if (!projector_.anywhere(t, state.data()).regular) return std::nullopt;
        state.resize(equations_.size());
        return state;
    }

    // Rows that follow from the others at this state, up to a distance of √smallest.
    int dependent_rows(double t, const double* y, double smallest) {
        place(t, y);
        return equations_.solver().hold_independent_rows(equations_.pose(), smallest);
    }

    int singular_joint() { return equations_.solver().singular_joint(); }
    const Model<D>& model() const { return model_; }
    EliminationFacts facts() const {
        const auto& order = equations_.solver().order();
        const auto& cholesky = equations_.solver().cholesky();
        return {order.leaves.size(), order.loop_bodies.size(), order.loop_joints.size(), cholesky.stored(),
                cholesky.filled()};
    }

private:
    // The bodies' state y and what is integrated beside it; the angles that are followed, where there are any.
    Numbers whole(const double* y, const Numbers& coordinates = {}) const {
        Numbers state(y, y + equations_.size());
        state.resize(equations_.total());
        if (model_.follows_angles)
            std::copy(coordinates.begin(), coordinates.end(), state.begin() + equations_.followed());
        return state;
    }
    void place(double t, const double* y, const Numbers& coordinates = {}) {
        equations_.set_pose(t, whole(y, coordinates).data());
    }

    Numbers rows(const double* values) const { return {values, values + model_.constraints.rows}; }

    const Model<D> model_;
    const ProjectionSettings projection_;
    Phases phases_;
    EquationsOfMotion<D> equations_;
    Projector<D> projector_;
};

}  // namespace mbproj
