// Compliant rows: the forces of springs, dampers, laws of the state and bushings in an implicit step. Where the velocities are v
// = c + g a and the coordinates change by g² a, a force along a coordinate s with the gradient J adds J^T D J to the masses,
// with D = g² ∂(-F)/∂s + g ∂(-F)/∂s'. It acts like a flywheel of inertia D that the coordinate turns. On a hinge D adds to the
// inertia of a free motion; in the loops it is one more row of S with 1/D on the diagonal. D → ∞ is a rigid joint, D = 0 no
// force.
#pragma once

#include "kinematics/loads.hpp"
#include "model/decompositions.hpp"

namespace mbproj {

// The model with a joint for each force that depends on the state. Only implicit steps use it.
template <class D> Model<D> with_compliant_rows(Model<D> model) {
    if (!model.loads) return model;
    const Loads<D>& loads = *model.loads;
    PrimitiveSet<D>& set = model.constraints;
    const auto add = [&model](Joint joint, StiffForce force) {
        joint.row = model.all_rows();
        model.stiff_rows += joint.rows;
        model.joints.push_back(std::move(joint));
        model.stiff.push_back(force);
    };
    const auto moves = [&model](std::vector<int>& bodies, int body) {
        if (body < model.size() && std::find(bodies.begin(), bodies.end(), body) == bodies.end())
            bodies.push_back(body);
    };
    const int slots = static_cast<int>(set.attachments.size());
    set.attachments.insert(set.attachments.end(), loads.coordinates.attachments.begin(),
                           loads.coordinates.attachments.end());
    for (std::size_t l = 0; l < loads.laws.size(); ++l) {
        if (!depends_on_state(model.programs, loads.laws[l])) continue;
        Instance<D> p = loads.coordinates.instances[l];
        for (int s = 0; s < p.slot_count; ++s) p.slots[s] += slots;
        p.row = model.all_rows();
        const int at = static_cast<int>(set.instances.size());
        Joint joint{at, at + 1, p.row, p.rows, {}};
        for (int s = 0; s < p.slot_count; ++s) moves(joint.bodies, set.attachments[p.slots[s]].body);
        set.instances.push_back(p);
        add(std::move(joint), {static_cast<int>(l), -1});
    }
    const int end = static_cast<int>(set.instances.size());
    for (std::size_t b = 0; b < loads.bushings.size(); ++b) {
        Joint joint{end, end, 0, Size<D>::freedoms, {}, static_cast<int>(b)};
        for (const int body : loads.bushings[b].body) moves(joint.bodies, body);
        add(std::move(joint), {-1, static_cast<int>(b)});
    }
    model.row_scale.resize(model.all_rows(), 1.0);
    return model;
}

// A pass of Newton's method on the stage with this number.
struct Pass {
    int stage, number;
};

// The derivatives of the forces of compliant rows by the accelerations of a stage.
template <class D> class Compliance final {
public:
    static constexpr int F = Size<D>::freedoms;
    using Root = Matrix<F, F, Scalar<D>>;

    explicit Compliance(const Model<D>& model)
        : model_(model), weights_(model.stiff.size(), 0.0), slopes_(weights_),
          roots_(model.stiff.size(), Root(Root::Zero())) {}

    // Makes room for the values at so many stages.
    void remember(int stages) {
        before_.resize(stages * model_.stiff.size());
        most_.resize(before_.size());
    }
    bool empty() const { return weights_.empty(); }

    // Sets D and ∂(-F)/∂s at a state, in a pass of Newton's method on a stage. A slope that would add energy counts as 0. A
    // function that bends within the last change counts with its secant; else Newton's method would alternate between two flat
    // parts across a steep one. After some passes no slope becomes smaller, so that the method cannot cycle.
    void set(const Applied<D>& applied, const Pose<D>& pose, const Motion<D>& motion, Channels<D>& channels,
             Scalar<D> g, Pass pass) {
        for (std::size_t f = 0; f < weights_.size(); ++f) {
            if (model_.stiff[f].law < 0) continue;
            const LawSlopes<D> found = applied.slopes(*model_.loads, model_.stiff[f].law, pose, motion, channels);
            Scalar<D> weight = max(g * g * found.of_value + g * found.of_rate, 0.0);
            const std::size_t seen = pass.stage * weights_.size() + f;
            if (pass.number > 0 && isfinite(found.given))
                weight = max(weight, secant(model_.loads->laws[model_.stiff[f].law], before_[seen], found, g));
            if (pass.number > model_.thresholds.free_passes) weight = max(weight, most_[seen]);
            weights_[f] = most_[seen] = weight;
            before_[seen] = found;
            slopes_[f] = max(found.of_value, 0.0);
            roots_[f](0, 0) = sqrt(weights_[f]);
        }
        set_bushings(pose, g);
    }

    // Sets each law's D to its smallest value over the stages, for an error estimate over all of them. False where the last
    // stage's D is almost the same.
    bool soften(int stages, Scalar<D> g) {
        bool changed = false;
        for (std::size_t f = 0; f < weights_.size(); ++f) {
            if (model_.stiff[f].law < 0) continue;
            for (int stage = 0; stage < stages; ++stage) {
                const LawSlopes<D>& seen = before_[stage * weights_.size() + f];
                const Scalar<D> weight = max(g * g * seen.of_value + g * seen.of_rate, 0.0);
                if (!(weight < model_.thresholds.softened * weights_[f])) continue;
                weights_[f] = weight;
                slopes_[f] = max(seen.of_value, 0.0);
                roots_[f](0, 0) = sqrt(weight);
                changed = true;
            }
        }
        return changed;
    }

    // The D of a law, by the number of its joint.
    Scalar<D> weight(int joint) const { return weights_[joint - model_.first_stiff()]; }
    // R of a joint, with D = RᵀR.
    const Root& root(int joint) const { return roots_[joint - model_.first_stiff()]; }
    // Replaces x by R x, for a joint with so many rows.
    void turn(int joint, int rows, Scalar<D>* x) const {
        const Root& R = root(joint);
        Column<F, Scalar<D>> found = Column<F, Scalar<D>>::Zero();
        for (int r = 0; r < rows; ++r)
            for (int c = 0; c < rows; ++c) found[r] += R(r, c) * x[c];
        std::copy(found.begin(), found.begin() + rows, x);
    }
    // Replaces the rows' gradients, given as columns, by those of the rows R J.
    void turn(int joint, int rows, Matrix<F, F, Scalar<D>>& gradients) const {
        for (int c = 0; c < F; ++c) {
            Column<F, Scalar<D>> x = gradients.row(c).transpose();
            turn(joint, rows, x.data());
            gradients.row(c) = x.transpose();
        }
    }
    // The slope of stiff force number f, a law.
    Scalar<D> slope(std::size_t f) const { return slopes_[f]; }

private:
    // The D of the secant through the last two states, without the coordinate's motion by other stages.
    Scalar<D> secant(const Law<D>& law, const LawSlopes<D>& before, const LawSlopes<D>& now, Scalar<D> g) const {
        const Scalar<D> change = now.rate - before.rate;
        if (!(abs(change) > model_.thresholds.rounded * max(abs(now.rate), abs(before.rate)))) return 0.0;
        const Scalar<D> moved = now.value - before.value - g * change;
        const Scalar<D> given = now.given - before.given + (now.of_value - law.stiffness) * moved;
        return g * g * law.stiffness + g * law.damping - g * given / change;
    }

    // Translations and rotation are not coupled. Rotational damping depends on the pose, the rest on g alone.
    void set_bushings(const Pose<D>& pose, Scalar<D> g) {
        for (std::size_t f = 0; f < roots_.size(); ++f) {
            if (model_.stiff[f].bushing < 0) continue;
            const Bushing<D>& bushing = model_.loads->bushings[model_.stiff[f].bushing];
            if (g == g_ && !bushing.sees_pose) continue;
            const Root weight = g * g * bushing.stiffness + g * Deflection<D>(bushing, pose).damping();
            if (g != g_) set_root<D::axes>(weight, 0, roots_[f]);
            set_root<Size<D>::turns>(weight, D::axes, roots_[f]);
        }
        g_ = g;
    }
    // Sets the root of the block from `at` on.
    template <int N> static void set_root(const Root& weight, int at, Root& root) {
        const Matrix<N, N, Scalar<D>> own = weight.template block<N, N>(at, at);
        root.template block<N, N>(at, at) = mbproj::root<N>(0.5 * (own + own.transpose()));
    }

    const Model<D>& model_;
    std::vector<Scalar<D>> weights_, slopes_;
    std::vector<LawSlopes<D>> before_;  // the slopes of each force at each stage
    std::vector<Scalar<D>> most_;       // the largest D of each force at each stage
    std::vector<Root> roots_;
    Scalar<D> g_ = 0.0;  // the g of the bushings' roots
};

}  // namespace mbproj
