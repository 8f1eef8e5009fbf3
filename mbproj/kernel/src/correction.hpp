// The projection after a step: positions by simplified Newton with one factor, velocities by one solve at the pose reached.
#pragma once

#include <limits>

#include "dynamics.hpp"
#include "phases.hpp"

namespace mbproj {

struct Corrected {
    int projections = 0, position_passes = 0, velocity_passes = 0, failures = 0;
    bool regular = true;
};

template <int D> class Corrector {
public:
    using S = Size<D>;

    Corrector(Dynamics<D>& dynamics, const Projection& settings, Phases& phases)
        : dynamics_(dynamics), model_(dynamics.model()), settings_(settings), phases_(phases),
          metric_(settings.correction == Correction::coordinates ? Metric::coordinates : Metric::mass),
          rhs_(model_.constraints.rows), before_(dynamics.size()) {}

    // The state y after step number `step` (from 1) with its orientations normalised, projected if the schedule says so:
    // every k-th step, and with a threshold only the levels that exceed it (velocities always after a moved position).
    // Afterwards the pose of y is in place.
    Corrected after_step(long step, double t, double* y) {
        normalise(y);
        dynamics_.place(t, y);
        const bool due = settings_.corrects() && !rhs_.empty() && step % settings_.every == 0;
        bool position = due && settings_.position, velocity = due && settings_.velocity;
        if (due && settings_.threshold >= 0.0) {
            position = position && largest(dynamics_.constraint()) > settings_.threshold;
            velocity = velocity && (position || largest(dynamics_.constraint_velocity(y)) > settings_.threshold);
        }
        Corrected done;
        done.projections = position || velocity;
        // The factor of the step's last stage, a pose near by, serves where there is one.
        if (position) settings_.paper_test ? by_paper(y, done) : by_violation(y, done, !dynamics_.holds(metric_));
        phases_.mark(Phase::position);
        if (velocity && done.regular) correct_velocity(y, done);
        phases_.mark(Phase::velocity);
        return done;
    }

    // A state between two steps, moved to the constraints at the levels that are switched on.
    Corrected anywhere(double t, double* y) {
        normalise(y);
        dynamics_.place(t, y);
        Corrected done;
        if (!settings_.corrects() || rhs_.empty()) return done;
        if (settings_.position) settings_.paper_test ? by_paper(y, done) : by_violation(y, done, true);
        if (settings_.velocity && done.regular) correct_velocity(y, done);
        return done;
    }

    // One exact Newton correction of the position; false where there is none.
    bool newton(double t, double* y) {
        dynamics_.place(t, y);
        if (!dynamics_.factor(metric_)) return false;
        move(y, dynamics_.constraint());
        return true;
    }

private:
    // A pass that leaves more than this part of the violation has reached round-off, or does not converge.
    static constexpr double stagnation = 0.5;
    // A pass that leaves more than this part of it calls for a factor of the pose it has reached.
    static constexpr double slow = 0.1;
    static constexpr double floor = 1e-13;
    static constexpr double paper_tolerance = 1e-12;

    double largest(const double* rows) const {
        double most = 0.0;
        for (std::size_t r = 0; r < rhs_.size(); ++r) most = std::max(most, std::abs(rows[r]));
        return most;
    }

    void normalise(double* y) const {
        for (int b = 0; b < model_.size(); ++b) {
            const auto orientation = WritablePart<D>(y, b).orientation();
            WritablePart<D>(y, b).orientation() = normalised(Column<S::orientation>(orientation));
        }
    }

    // Until every row of C meets its tolerance. One factor, `fresh` from this pose or from one near by, serves all passes
    // (simplified Newton) unless they converge slowly; a violation that does not fall with a fresh factor either has
    // reached round-off.
    void by_violation(double* y, Corrected& done, bool fresh) {
        const double* C = dynamics_.constraint();
        double left = largest(C);
        while (!meets(C)) {
            if (done.position_passes == settings_.max_iterations) {
                ++done.failures;
                return;
            }
            if (fresh && !(done.regular = dynamics_.factor(metric_))) return;
            std::copy(y, y + before_.size(), before_.begin());
            move(y, C);
            ++done.position_passes;
            C = dynamics_.constraint();
            const double now = largest(C);
            const bool may_rise = fresh && done.position_passes == 1 && std::isfinite(now);
            if (!may_rise && !(now < stagnation * left)) {
                std::copy(before_.begin(), before_.end(), y);
                dynamics_.place(y);
                C = dynamics_.constraint();
                if (fresh) {
                    ++done.failures;
                    return;
                }
                fresh = true;
                continue;
            }
            fresh = !(now < slow * left);
            left = now;
        }
    }

    // Until ΔqᵀMΔq <= tolerance (sect. 5), by Newton's method.
    void by_paper(double* y, Corrected& done) {
        const double tolerance = settings_.tolerance < 0.0 ? paper_tolerance : settings_.tolerance;
        while (done.position_passes < settings_.max_iterations) {
            if (!(done.regular = dynamics_.factor(metric_))) return;
            const double change = move(y, dynamics_.constraint());
            ++done.position_passes;
            if (change <= tolerance) return;
        }
        ++done.failures;
    }

    // Eqs. 46, 41, 74: G (u + δ) = 0.
    void correct_velocity(double* y, Corrected& done) {
        const double* C_dot = dynamics_.constraint_velocity(y);
        if (!(done.regular = dynamics_.factor(metric_))) return;
        solve(C_dot);
        for (int b = 0; b < model_.size(); ++b) {
            WritablePart<D> part(y, b);
            part.velocity() += dynamics_.bordered().shift(b);
            part.omega() += to_body(dynamics_.pose()[b].rotation, dynamics_.bordered().turn(b));
        }
        ++done.velocity_passes;
    }

    void solve(const double* violation) {
        for (std::size_t r = 0; r < rhs_.size(); ++r) rhs_[r] = -violation[r];
        dynamics_.bordered().clear_forces();
        dynamics_.bordered().solve(rhs_.data());
    }

    // Moves y by the correction of this violation with the factor at hand, and the pose with it; returns δᵀWδ.
    double move(double* y, const double* C) {
        solve(C);
        double change = 0.0;
        for (int b = 0; b < model_.size(); ++b) {
            const Point<D> shift = dynamics_.bordered().shift(b);
            const Turn<D> turn = dynamics_.bordered().turn(b);
            const Body<D>& body = model_.bodies[b];
            WritablePart<D> part(y, b);
            if (settings_.paper_test) {
                const Turn<D> local = to_body(dynamics_.pose()[b].rotation, turn);
                change += body.mass * shift.squaredNorm() + local.dot(body.inertia * local);
            }
            part.position() += shift;
            part.orientation() = turned(Column<S::orientation>(part.orientation()), turn);
        }
        dynamics_.place(y);
        return change;
    }

    // |C| <= tolerance row by row: as set, or max(1e-13, 4 ε × the largest coordinate that enters the row).
    bool meets(const double* C) const {
        const double most = largest(C);
        if (settings_.tolerance >= 0.0) return most <= settings_.tolerance;
        if (most <= floor) return true;
        constexpr double grain = 4.0 * std::numeric_limits<double>::epsilon();
        for (const Instance& p : model_.constraints.instances) {
            double reach = 1.0;
            for (int s = 0; s < p.slot_count; ++s) {
                const Attachment<D>& a = model_.constraints.attachments[p.slots[s]];
                if (a.is_point) reach = std::max(reach, dynamics_.pose()[a.body].position.cwiseAbs().maxCoeff() + a.size);
            }
            const double tolerance = std::max(floor, grain * reach);
            for (int r = p.row; r < p.row + p.rows; ++r)
                if (!(std::abs(C[r]) <= tolerance)) return false;
        }
        return true;
    }

    Dynamics<D>& dynamics_;
    const Model<D>& model_;
    const Projection& settings_;
    Phases& phases_;
    Metric metric_;
    std::vector<double> rhs_, before_;
};

}  // namespace mbproj
