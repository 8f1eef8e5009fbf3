// Steps of a mechanism without degrees of freedom (their quadrature: mbproj.motion.steppers.tableau). Joints and motions alone
// determine the poses of its bodies: Newton's method closes each stage from a prediction by the stages before, and
// velocities and accelerations follow from the equations. Explicit stages integrate the rest: the work of forces, and
// states of elements. Newton's method may lead to another assembly of the mechanism: a step is made only where no stage
// leaves a doubt about that. A mechanism at rest has velocities of exactly 0: velocities of round-off would do work of
// round-off.
#pragma once

#include "solver/branch_sign.hpp"
#include "solver/projector.hpp"
#include "step/explicit_stages.hpp"

namespace mbproj {

template <class D> class KinematicSteps final : public ExplicitStages {
public:
    using S = Size<D>;

    KinematicSteps(const Tableau& tableau, EquationsOfMotion<D>& equations, Projector& projector)
        : ExplicitStages(tableau, equations), equations_(equations), model_(equations.model()), projector_(projector),
          sign_(model_), states_(k_.size(), stage_),
          needs_last_(tableau.error.rows() > 0 && !(tableau.error.col(tableau.stages()).isZero(0.0) &&
                                                    tableau.dense.row(tableau.stages()).isZero(0.0))) {}

    std::unique_ptr<Stepper> copy() const override { return std::make_unique<KinematicSteps>(*this); }

    int error_cost() const override { return needs_last_; }

    bool attempt(double t, const Vector& y, double h, Vector& y_new) override {
        doubt_ = false;
        states_[0] = y;
        int end = -1;  // a stage at the end of the step
        for (int s = 1; s < tableau_.stages(); ++s) {
            combine(y, h, tableau_.a.row(s), s, states_[s]);
            if (!close(t, h, tableau_.c[s], states_[s]) || !evaluate(states_[s], k_[s])) return false;
            if (tableau_.c[s] == 1.0) end = s;
        }
        combine(y, h, tableau_.b, tableau_.stages(), y_new);
        const Block& bodies = layout_.bodies;
        if (end < 0) {
            if (!close(t, h, 1.0, y_new)) return false;
        } else {
            y_new.segment(bodies.first, bodies.size) = states_[end].segment(bodies.first, bodies.size);
            equations_.set_pose(t + h, y_new.data());
        }
        return keeps_sign(t, y, h, y_new);
    }
    bool closes_stages() const override { return true; }
    std::optional<Unsolved> unsolved() const override {
        return doubt_ ? std::optional(Unsolved{-1, -1}) : std::nullopt;
    }

    void quadrature(double t, const Vector&, double h, const Visit& visit) const override {
        for (int s = 0; s < tableau_.stages(); ++s)
            if (tableau_.b[s] != 0.0) visit(tableau_.b[s], t + tableau_.c[s] * h, states_[s]);
    }

    // The error of the states and the works. The scale of a work is the sum of the magnitudes of powers of inertias,
    // weights and forces, over the step. An error below the round-off of the work so far, or of the work of a fall by
    // the mechanism's length, is acceptable.
    std::optional<double> error(double t, const Vector& y, const Vector& y_new, double h, double tolerance,
                                bool) override {
        const int last = tableau_.stages();
        if (needs_last_ && !equations_.watched_derivative(t, y_new.data(), k_[last].data())) return std::nullopt;
        const Block &states = layout_.states, &works = layout_.quadratures;
        const int count = states.size + works.size;
        if (!count) return 0.0;
        const double weight = model_.gravity.norm() * model_.length * mass();
        double work = 0.0;
        for (int s = 0; s < last && works.size; ++s)
            if (tableau_.b[s] != 0.0) work += h * std::abs(tableau_.b[s]) * exchanged(states_[s], k_[s]);
        if (watches_sign()) {
            // Near a singular pose works err by the violation of the joints over the squared distance from it.
            const double nearest = std::max(equations_.policy().passed().smallest, round_off());
            work *= std::max(1.0, model_.thresholds.closed_to / (nearest * tolerance));
        }
        double norms[2] = {0.0, 0.0};
        for (int e = 0; e < tableau_.error.rows(); ++e) {
            double sum = 0.0;
            const auto add = [&](int i, double size) {
                double estimate = 0.0;
                for (int s = 0; s <= last; ++s)
                    if (tableau_.error(e, s) != 0.0) estimate += tableau_.error(e, s) * k_[s][i];
                if (estimate == 0.0) return;
                const double part = h * estimate / (tolerance * size);
                sum += part * part;
            };
            for (int i = states.first; i < states.end(); ++i)
                add(i, layout_.scale[i] + std::max(std::abs(y[i]), std::abs(y_new[i])));
            for (int i = works.first; i < works.end(); ++i)
                add(i, std::max(work, round_off() * (weight + std::abs(y_new[i])) / tolerance));
            norms[e] = std::sqrt(sum / count);
        }
        return combined(norms);
    }

    bool extend(double t, const Vector& y, double h) override {
        for (std::size_t x = 0; x < tableau_.extra_c.size(); ++x) {
            const int known = tableau_.stages() + 1 + static_cast<int>(x);
            combine(y, h, tableau_.extra_a.row(x), known, stage_);
            if (!close(t, h, tableau_.extra_c[x], stage_) || !evaluate(stage_, k_[known])) return false;
        }
        return true;
    }

private:
    // Closes the predicted bodies of a stage, at the part c of a step. False where they may be on another branch of the
    // motion than the start of the step.
    bool close(double t, double h, double c, Vector& stage) {
        const double time = t + c * h;
        lead(time, stage);
        predicted_ = stage;
        const Projected done = projector_.anywhere(time, stage.data());
        const bool closed = done.regular && done.failures == 0 && stage.allFinite() &&
                            model_.open_by_more(equations_.constraint(), model_.thresholds.lost_limit) < 0;
        doubt_ = !closed || !is_told(done, c * h, stage);
        if (equations_.drive().is_at_rest()) stop(stage);
        return !doubt_;
    }
    void stop(Vector& stage) const {
        for (int b = 0; b < model_.size(); ++b) {
            WritablePart<D> part(stage.data(), b);
            part.velocity() = Point<D>::Zero();
            part.omega() = Turn<D>(Turn<D>::Zero());
        }
    }

    // Whether the sign is watched. Works jump between branches: steps for works alone are so short that no other branch
    // is in reach. Steps for states of elements may be longer.
    bool watches_sign() const { return layout_.states.size > 0; }
    // Whether a step passes no crossing of branches, or is so short that it can pass one and reach no other branch.
    bool keeps_sign(double t, const Vector& y, double h, const Vector& y_new) {
        if (!watches_sign()) return true;
        const bool changes = sign_.changes(equations_, t, y.data(), t + h, y_new.data());
        doubt_ = changes && way(y, y_new) > model_.thresholds.crossed_way * model_.length;
        return !doubt_;
    }

    // Whether Newton's method has corrected a small part of the way alone, and of the velocity; or a way so short that
    // no other branch is in reach. Branches cross at an angle: their velocities differ where they are near.
    bool is_told(const Projected& done, double h, const Vector& stage) {
        const double corrected = way(predicted_, stage), made = way(states_[0], stage), length = model_.length;
        if (corrected == 0.0 && made == 0.0)
            return true;  // the pose of the start: a motion that begins or ends at rest
        const double part = model_.thresholds.told_part, least = model_.thresholds.told_way * length;
        if (corrected <= part * made && done.velocity_change <= part) return true;
        const bool is_short = corrected <= std::max(part * made, least) && done.speed_change * std::abs(h) <= least;
        return is_short && !equations_.is_near_singular();
    }

    // y' at a closed stage, the state in place.
    bool evaluate(const Vector& stage, Vector& slope) {
        if (!equations_.factor(Metric::mass)) return false;
        equations_.policy().record_pose();
        if (equations_.wants_others()) return false;
        equations_.set_velocities(stage.data(), false);
        return equations_.slope_at(stage.data(), slope.data());
    }

    // Sets angles that are followed and driven to the values of their motions.
    void lead(double t, Vector& stage) {
        if (!layout_.follows() || model_.driven.empty()) return;
        equations_.set_pose(t, stage.data());
        for (std::size_t k = 0; k < model_.driven.size(); ++k)
            if (const int i = model_.driven[k].coordinate; model_.counts_turns[i])
                stage[layout_.followed.first + i] = equations_.drive().prescribed(k);
    }

    // The distance of all bodies between two states, with turns times the mechanism's length.
    double way(const Vector& x, const Vector& y) const {
        double sum = 0.0;
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> from(x.data(), b), to(y.data(), b);
            const auto by = Column<S::orientation>(to.orientation() - from.orientation());
            sum += (to.position() - from.position()).squaredNorm() + model_.length * model_.length * squared_turn(by);
        }
        return std::sqrt(sum);
    }
    static double squared_turn(const Column<1>& by) { return std::pow(std::remainder(by[0], 2.0 * M_PI), 2); }
    static double squared_turn(const Column<4>& by) { return 4.0 * by.squaredNorm(); }

    // The sum of the magnitudes of powers of inertias, weights and forces at a stage, W.
    double exchanged(const Vector& stage, const Vector& slope) const {
        const Block& works = layout_.quadratures;
        double sum = std::abs(slope[works.first]) + std::abs(slope[works.first + 1]);
        const double weight = model_.gravity.norm();
        for (int b = 0; b < model_.size(); ++b) {
            const Body<D>& body = model_.bodies[b];
            const Part<D> at(stage.data(), b), rate(slope.data(), b);
            const Turn<D> omega = at.omega(), alpha = rate.omega();
            sum += body.mass * at.velocity().norm() * (rate.velocity().norm() + weight) +
                   omega.norm() * ((body.inertia * alpha).norm() + omega.norm() * (body.inertia * omega).norm());
        }
        return sum;
    }

    double mass() const {
        double sum = 0.0;
        for (const Body<D>& body : model_.bodies) sum += body.mass;
        return sum;
    }
    static double round_off() { return std::numeric_limits<double>::epsilon(); }

    EquationsOfMotion<D>& equations_;
    const Model<D>& model_;
    Projector& projector_;
    BranchSign<D> sign_;
    std::vector<Vector> states_;  // the stages
    Vector predicted_;
    const bool needs_last_;  // whether f at the end of the step is needed
    bool doubt_ = false;     // about the branch at the last stage
};

}  // namespace mbproj
