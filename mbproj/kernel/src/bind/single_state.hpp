// The equations at single states: for tests, for the start of a run, and for reactions of planar scenes. Each call starts
// afresh: with the rows that a run from its state begins with, or with those that it is given.
#pragma once

#include <optional>
#include <utility>

#include "solver/newton_projector.hpp"

namespace mbproj {

struct EliminationFacts {
    std::size_t leaves, loop_bodies, loop_joints, stored, filled;
};

template <class D> class SingleState final {
public:
    using S = Size<D>;
    using Numbers = std::vector<double>;
    using Rows = std::vector<int>;
    using LeftOut = std::optional<Rows>;  // in place of those that a step from a state leaves out

    SingleState(const Model<D>& model, const ProjectionSettings& projection)
        : model_(model), projection_(projection), equations_(model_, projection_),
          projector_(equations_, projection_, phases_) {}
    SingleState(const SingleState&) = delete;
    SingleState& operator=(const SingleState&) = delete;
    Numbers constraint(double t, const double* y) {
        set_pose(t, y);
        return rows(equations_.constraint());
    }
    Numbers constraint_velocity(double t, const double* y) {
        set_pose(t, y);
        return rows(equations_.constraint_velocity(y));
    }
    Numbers gamma(double t, const double* y) {
        set_pose(t, y);
        equations_.set_velocities(y, false);
        return rows(equations_.gamma());
    }

    // G in (δr, δθ global) of each body, rows × bodies × freedoms.
    Numbers jacobian(double t, const double* y) {
        set_pose(t, y);
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

    // The rows that a step from a state leaves out.
    Rows left_out(double t, const double* y) {
        begin(t, y, {}, {});
        return equations_.solver().left_out();
    }
    // The pivots of S without these rows; and the smallest where all bodies weigh the same. None, and 0, where the equations have
    // no unique solution.
    std::pair<Numbers, double> pivots(double t, const double* y, const Rows& left_out) {
        KktSolver<D>& solver = equations_.solver();
        set_pose(t, y);
        equations_.policy().hold_all_but(left_out);
        if (!equations_.factor_all(Metric::mass) || !solver.is_regular()) return {};
        return {solver.cholesky().pivots(), solver.even_pivot(equations_.pose())};
    }

    // (r'', ω' in body axes) of each body and λ, or nothing where they are not unique. `coordinates` are the joints',
    // each to less than half a turn, and after them the states of elements; what is not there is as a run begins with it.
    std::optional<std::pair<Numbers, Numbers>> accelerations(double t, const double* y, const Numbers& coordinates,
                                                             const LeftOut& left_out) {
        Numbers slope(model_.layout.size()), lambda(model_.all_multipliers()), found;
        if (!begin(t, y, coordinates, left_out)) return std::nullopt;
        equations_.set_velocities(y, false);
        if (!equations_.slope_at(state_.data(), slope.data(), lambda.data())) return std::nullopt;
        for (int b = 0; b < model_.size(); ++b) {
            const double* a = slope.data() + S::state * b + S::pose;
            found.insert(found.end(), a, a + S::freedoms);
        }
        lambda.resize(model_.constraints.rows);
        return std::make_pair(std::move(found), std::move(lambda));
    }

    // How many numbers of a state stand beside its bodies': coordinates, and states of elements.
    std::size_t beside() const { return model_.coordinates.instances.size() + model_.layout.states.size; }
    // The smallest λ of each of `count` states, one after another; not numbers where they are not unique. With forces along
    // each coordinate of stops and frictions, or none.
    Numbers smallest_multipliers(std::size_t count, const double* t, const double* y, const double* coordinates,
                                 const double* forces) {
        std::vector<ContactRow> along;
        for (std::size_t k = 0; k < model_.stops.bound.size(); ++k) along.push_back({static_cast<int>(k), 1.0, 0.0});
        const auto contacts = static_cast<Eigen::Index>(along.size());
        const std::size_t rows = model_.constraints.rows;
        Numbers found(count * rows, std::numeric_limits<double>::quiet_NaN());
        Numbers slope(model_.layout.size()), lambda(model_.all_multipliers());
        for (std::size_t i = 0; i < count; ++i, y += model_.layout.bodies.size, coordinates += beside()) {
            if (forces) equations_.contacts().give(along, Eigen::Map<const Eigen::VectorXd>(forces, contacts));
            if (forces) forces += contacts;
            const Numbers there(coordinates, coordinates + beside());
            if (!begin(t[i], y, there, {})) continue;
            equations_.set_velocities(y, false);
            if (!equations_.slope_at(state_.data(), slope.data(), lambda.data())) continue;
            if (!equations_.solver().spread(equations_.pose(), lambda.data())) continue;
            std::copy_n(lambda.begin(), rows, found.begin() + i * rows);
        }
        equations_.contacts().hold({});
        return found;
    }

    // The smallest λ of each of `count` states from any, `carried`, that balance the same forces; these where there are none.
    Numbers spread(std::size_t count, const double* t, const double* y, const double* carried) {
        const std::size_t rows = model_.constraints.rows;
        Numbers found(carried, carried + count * rows), lambda;
        for (std::size_t i = 0; i < count; ++i, y += model_.layout.bodies.size) {
            set_pose(t[i], y);
            lambda.assign(carried + i * rows, carried + (i + 1) * rows);
            if (equations_.solver().spread_over_all(equations_.pose(), lambda.data()))
                std::copy(lambda.begin(), lambda.end(), found.begin() + i * rows);
        }
        return found;
    }

    // y' as a stage of a step has it, in the order of y; nothing where it is not unique.
    std::optional<Numbers> derivative(double t, const double* y, const Numbers& coordinates, const LeftOut& left_out) {
        Numbers slope(model_.layout.size());
        begin(t, y, coordinates, left_out);
        if (!equations_.derivative(t, state_.data(), slope.data())) return std::nullopt;
        return bodies(std::move(slope));
    }

    // The acceleration along the coordinates of these laws per unit force on each of them, row by row; nothing where that
    // is not unique.
    std::optional<Numbers> responses(double t, const double* y, const std::vector<int>& laws) {
        Numbers found;
        if (!begin(t, y, {}, {})) return std::nullopt;
        const Numbers none(model_.all_rows(), 0.0);
        std::vector<Point<D>> shift(model_.size() + 1, Point<D>::Zero());
        std::vector<Turn<D>> turn(model_.size() + 1, Turn<D>::Zero());
        Applied<D>& applied = equations_.applied();
        KktSolver<D>& solver = equations_.solver();
        for (const int pulled : laws) {
            applied.pull(*model_.loads, pulled, equations_.pose());
            for (int b = 0; b < model_.size(); ++b) solver.set_force(b, applied.force[b], applied.torque[b]);
            if (!solver.solve(none.data())) return std::nullopt;
            for (int b = 0; b < model_.size(); ++b) {
                shift[b] = solver.shift(b);
                turn[b] = solver.turn(b);
            }
            for (const int law : laws)
                found.push_back(applied.rate(*model_.loads, law, equations_.pose(), shift, turn));
        }
        return found;
    }

    // Of these rows of stops B, row by row, and how their gaps accelerate without a push; nothing where the rows depend
    // on each other or the motion is not unique. The accelerations and λ that come next are those with these contacts, which hold until others do.
    std::optional<std::pair<Numbers, Numbers>> border(double t, const double* y, std::vector<ContactRow> rows) {
        Numbers slope(model_.layout.size());
        equations_.hold_contacts(std::move(rows));
        if (!begin(t, y, {}, {})) return std::nullopt;
        equations_.set_velocities(y, false);
        if (!equations_.slope_at(state_.data(), slope.data())) return std::nullopt;
        const auto& B = equations_.contacts().operator_of_rows();
        const auto& b = equations_.contacts().free_accelerations();
        return std::make_pair(Numbers(B.data(), B.data() + B.size()), Numbers(b.data(), b.data() + b.size()));
    }

    // The state after one exact Newton correction of its position.
    std::optional<Numbers> newton(double t, const double* y) {
        begin(t, y, {}, {});
        if (!projector_.newton(t, state_.data())) return std::nullopt;
        return bodies(state_);
    }

    // The state moved to the constraints, position and velocity.
    std::optional<Numbers> corrected(double t, const double* y, const LeftOut& left_out) {
        begin(t, y, {}, left_out);
        if (!projector_.anywhere(t, state_.data()).regular) return std::nullopt;
        return bodies(state_);
    }

    // Rows that follow from the others at this state, up to a distance of √smallest.
    int dependent_rows(double t, const double* y, double smallest) {
        set_pose(t, y);
        return equations_.solver().count_dependent(equations_.pose(), smallest);
    }

    // Of the last factor: its rows' distance from dependent, squared, about; 0 where rows were left out.
    double nearness() const { return equations_.solver().nearness(); }
    int singular_joint() { return equations_.solver().singular_joint(); }
    const Model<D>& model() const { return model_; }
    EliminationFacts facts() const {
        const auto& order = equations_.solver().order();
        const auto& cholesky = equations_.solver().cholesky();
        return {order.leaves.size(), order.loop_bodies.size(), order.loop_joints.size(), cholesky.stored(),
                cholesky.filled()};
    }

private:
    // The bodies' state y in place, and beside it what a run begins with; the angles that are followed, where there are any.
    void set_pose(double t, const double* y, const Numbers& coordinates = {}) {
        const Layout& layout = model_.layout;
        state_ = layout.start;
        std::copy(y, y + layout.bodies.size, state_.begin());
        const auto followed = std::min(coordinates.size(), model_.coordinates.instances.size());
        if (layout.follows()) std::copy_n(coordinates.begin(), followed, state_.begin() + layout.followed.first);
        std::copy(coordinates.begin() + followed, coordinates.end(), state_.begin() + layout.states.first);
        equations_.set_pose(t, state_.data());
    }
    Numbers bodies(Numbers y) const {
        y.resize(model_.layout.bodies.size);
        return y;
    }

    // A state with the rows of a run that begins there, or with those given; factored with the masses. False where the
    // equations have no unique solution.
    bool begin(double t, const double* y, const Numbers& coordinates, const LeftOut& left_out) {
        set_pose(t, y, coordinates);
        if (!left_out) return equations_.start();
        equations_.policy().hold_all_but(*left_out);
        return equations_.factor(Metric::mass);
    }

    Numbers rows(const double* values) const { return {values, values + model_.constraints.rows}; }

    const Model<D> model_;
    const ProjectionSettings projection_;
    Phases phases_;
    EquationsOfMotion<D> equations_;
    NewtonProjector<D> projector_;
    Numbers state_;
};

}  // namespace mbproj
