// Stiffly accurate implicit Runge-Kutta steps with an explicit first stage. Stages are solved for their accelerations
// (solver/implicit_stage.hpp), one after another where none needs a later one (ESDIRK). Where they are coupled, A = L
// + (A - L) with L lower triangular and hγ on its diagonal. Each pass of Newton's method solves one stage after another
// with L, and takes the terms of A - L from the pass before (van der Houwen & de Swart 1997). The last stage is the end
// of the step, and its slope is the first of the next step. It is not evaluated anew after the projection, whose small
// change of the positions would change the force of a stiff spring by much.
#pragma once

#include "solver/implicit_stage.hpp"
#include "step/stepper.hpp"

namespace mbproj {

template <class D> class ImplicitRungeKutta final : public Stepper {
public:
    using S = Size<D>;

    // `tolerance`: of the steps, or 0 where they are fixed.
    ImplicitRungeKutta(const Tableau& tableau, EquationsOfMotion<D>& equations, double tolerance)
        : Stepper(tableau, equations, tableau.stages()), equations_(equations), implicit_(equations),
          thresholds_(equations.model().thresholds),
          least_(std::max(thresholds_.newton_part * tolerance, thresholds_.newton_fixed)), base_(layout_.size()),
          found_(Vector::Zero(layout_.size())), jump_(found_), lambda_(equations.model().all_multipliers()),
          jump_lambda_(lambda_), after_lambda_(lambda_), old_(tableau.stages(), found_) {
        implicit_.remember(tableau.stages());
    }
    ImplicitRungeKutta(const ImplicitRungeKutta&) = default;
    std::unique_ptr<Stepper> copy() const override { return std::make_unique<ImplicitRungeKutta>(*this); }

    long attempt_cost() const override { return evaluations_; }
    int error_cost() const override { return 0; }
    int extend_cost() const override { return 0; }
    int arrival_cost() const override { return 0; }

    bool attempt(double t, const Vector& y, double h, Vector& y_new) override {
        evaluations_ = 0;
        contraction_ = thresholds_.first_contraction;
        unsolved_.reset();
        implicit_.begin(t, y.data(), h * tableau_.gamma);
        if (tableau_.is_coupled()) {
            if (!solve(t, y, h, 1, tableau_.stages())) return false;
            combine(y, h, tableau_.b, tableau_.stages(), y_new);
            return true;
        }
        for (int s = 1; s < tableau_.stages(); ++s)
            if (!solve(t, y, h, s, s + 1)) return false;
        y_new = stage_;
        return true;
    }
    std::optional<Unsolved> unsolved() const override { return unsolved_; }

    void quadrature(double t, const Vector& y, double h, const Visit& visit) const override {
        Vector state(y.size());
        for (int s = 0; s < tableau_.stages(); ++s) {
            if (tableau_.b[s] == 0.0) continue;
            combine(y, h, tableau_.a.row(s), tableau_.stages(), state);
            visit(tableau_.b[s], t + tableau_.c[s] * h, state);
        }
    }

    // For a stiff vibration the estimate does not fall with the step size: rejected steps would become so short that
    // they follow a vibration long damped. So it is filtered twice after a rejection (Hairer & Wanner II, IV.8).
    std::optional<double> error(double t, const Vector& y, const Vector& y_new, double h, double tolerance,
                                bool again) override {
        found_.setZero();
        for (int s = 0; s < tableau_.stages(); ++s) found_ += (h * tableau_.error(0, s)) * k_[s];
        if (!implicit_.filters()) return norm_of_error(y, y_new, tolerance);
        if (!filter(t, y_new, h)) return std::nullopt;
        const double once = norm_of_error(y, y_new, tolerance);
        if (!again || !(once > 1.0)) return once;
        if (!filter(t, y_new, h)) return std::nullopt;
        return norm_of_error(y, y_new, tolerance);
    }

    const Vector* estimate() const override { return &found_; }

    bool extend(double, const Vector&, double) override { return true; }

    bool arrive(const Vector& y, Vector& slope, double* lambda) override {
        slope = k_.back();
        set_rates(y, slope);
        if (lambda) std::copy(lambda_.begin(), lambda_.end(), lambda);
        return true;
    }
    bool follow_on(double, const Vector& y) override {
        k_[0] = k_.back();
        set_rates(y, k_[0]);
        return true;
    }
    // Stiff forces are those by the extension's accelerations, because a projection has moved this state, too.
    bool inside(double t, double h, double theta, const Vector& y, Vector& slope, double* lambda) override {
        combine(Vector::Zero(y.size()), 1.0, dense_rates(theta), tableau_.stages(), found_);
        return implicit_.slope_beside(t, y.data(), h * tableau_.gamma, found_.data(), slope.data(), lambda);
    }

    // Forces before and after are both those at y, which the projection has moved: they differ by the jump alone.
    bool before_jump(double t, const Vector& y) override {
        return equations_.derivative(t, y.data(), jump_.data(), jump_lambda_.data());
    }
    bool after_jump(double t, const Vector& y, Vector& slope, double* lambda) override {
        slope -= jump_;
        if (!equations_.derivative(t, y.data(), found_.data(), after_lambda_.data())) return false;
        slope += found_;
        for (std::size_t r = 0; lambda && r < jump_lambda_.size(); ++r) lambda[r] += after_lambda_[r] - jump_lambda_[r];
        return true;
    }
    bool meet_break(double t, const Vector& y, const TimeWindow& window, Vector& slope, double* lambda) override {
        equations_.set_window(window);
        const bool found = before_jump(t, y);
        equations_.set_window({});
        return found && after_jump(t, y, slope, lambda);
    }
    bool carries_slope() const override { return true; }

private:
    bool filter(double t, const Vector& y_new, double h) {
        return implicit_.filter(t, y_new.data(), h * tableau_.gamma, tableau_.stages(), found_.data());
    }
    double norm_of_error(const Vector& y, const Vector& y_new, double tolerance) const {
        double sum = 0.0;
        for (int i = 0; i < layout_.controlled(); ++i) {
            const double part =
                found_[i] / (tolerance * (layout_.scale[i] + std::max(std::abs(y[i]), std::abs(y_new[i]))));
            sum += part * part;
        }
        return std::sqrt(sum / layout_.controlled());
    }

    static constexpr int most_extrapolated = 3;  // stages

    // The accelerations of the stages from s on, from those of the stages before, by the polynomial through them.
    void extrapolate(int s, int end) {
        const std::vector<double>& c = tableau_.c;
        const int from = std::max(0, s - most_extrapolated);
        for (int to = s; to < end; ++to) {
            k_[to].setZero();
            for (int i = from; i < s; ++i) {
                double weight = 1.0;
                for (int j = from; j < s; ++j)
                    if (j != i) weight *= (c[to] - c[j]) / (c[i] - c[j]);
                k_[to] += weight * k_[i];
            }
        }
    }

    // Newton's method for the stages from `first` to `end`: k become their slopes, `stage_` the state of the last.
    bool solve(double t, const Vector& y, double h, int first, int end) {
        const double g = h * tableau_.gamma;
        const bool coupled = end - first > 1;
        double before = std::numeric_limits<double>::infinity();
        for (int pass = 0; pass < thresholds_.most_newton; ++pass) {
            double change = 0.0;
            for (int s = first; s < end; ++s) {
                if (pass == 0) extrapolate(s, end);
                if (pass == 0 || coupled) set_base(y, h, s, first, pass);
                place(g, k_[s]);
                ++evaluations_;
                const double time = t + tableau_.c[s] * h;
                if (!implicit_.slope(time, stage_.data(), g, k_[s].data(), {s, pass}, found_.data(), lambda_.data()))
                    return (pass > 0 || s > first) && diverged() && fails(pass > 0 ? s : s - 1);
                k_[s].swap(found_);
                old_[s].swap(found_);
                place(g, k_[s]);
                set_rates(stage_, k_[s]);
                const double moved = g * distance(k_[s], old_[s], coupled);
                if (!std::isfinite(moved) || (coupled && !settle_work(time, g, s))) return fails(s);
                change = std::max(change, moved);
            }
            if (pass > 0) contraction_ = std::max(change / before, thresholds_.least_contraction);
            if (is_solved(change, before))
                return coupled || settle_work(t + tableau_.c[first] * h, g, first) || fails(first);
            before = change;
        }
        return fails(end - 1);
    }

    // Stage s without hγ times its own slope: with A in the first pass, then with L, and A - L for the pass before.
    void set_base(const Vector& y, double h, int s, int first, int pass) {
        for (int j = 0; j < tableau_.stages(); ++j) weights_[j] = tableau_.a(s, j);
        weights_[s] -= tableau_.gamma;
        for (int j = first; pass > 0 && j < s; ++j) weights_[j] = tableau_.splitting(s, j);
        combine(y, h, weights_, tableau_.stages(), base_);
        for (int j = first; pass > 0 && j < s; ++j)
            base_ += h * (tableau_.a(s, j) - tableau_.splitting(s, j)) * old_[j];
    }

    // The power of stage s at the state of its final accelerations: the last, small change of the state by Newton's
    // method changes the power of a stiff force by much.
    bool settle_work(double t, double g, int s) {
        if (!implicit_.is_stiff() || layout_.quadratures.size == 0) return true;
        if (!equations_.settle_work(t, stage_.data(), k_[s].data())) return false;
        place_rest(g, k_[s]);
        return true;
    }

    // Whether the passes have led to a state at which functions or poses are not finite.
    bool diverged() const { return !equations_.broken_state().empty() || !equations_.pose().finite(); }
    // Records that stage s is not solved.
    bool fails(int s) {
        const Vector change = k_[s] - old_[s];
        unsolved_ = Unsolved{furthest(change), leader(change)};
        return false;
    }
    // The coordinate whose force changes most; or the element's state that does, numbered after all coordinates.
    int leader(const Vector& change) {
        const Block& states = layout_.states;
        int found = 0;
        double most = 0.0;
        for (int i = 0; i < layout_.controlled(); ++i)
            if (const double part = std::abs(change[i]) / (layout_.scale[i] + std::abs(stage_[i])); part > most)
                most = part, found = i;
        if (states.size == 0 || found < states.first) return implicit_.leader(change);
        return equations_.force_count() + found - states.first;
    }

    // Whether the error that the contraction lets expect is small enough, or round-off keeps the change from falling.
    bool is_solved(double change, double before) const {
        if (contraction_ < 1.0) {
            const double left = contraction_ / (1.0 - contraction_) * change;
            if (left <= least_) return true;
        }
        return change > 0.5 * before && change <= thresholds_.newton_floor;
    }

    // The state of a stage from its accelerations.
    void place(double g, const Vector& k) {
        for (int b = 0; b < equations_.model().size(); ++b) {
            const Part<D> from(base_.data(), b), slope(k.data(), b);
            WritablePart<D> to(stage_.data(), b);
            to.velocity() = from.velocity() + g * slope.velocity();
            to.omega() = from.omega() + g * slope.omega();
            to.position() = from.position() + g * to.velocity();
            to.orientation() = orientation_ahead(Column<S::orientation>(from.orientation()), Turn<D>(to.omega()), g);
        }
        place_rest(g, k);
    }
    void place_rest(double g, const Vector& k) {
        for (int i = layout_.bodies.size; i < layout_.size(); ++i) stage_[i] = base_[i] + g * k[i];
    }

    // r' and the orientation's rate of a state.
    void set_rates(const Vector& y, Vector& slope) const {
        for (int b = 0; b < equations_.model().size(); ++b) {
            const Part<D> part(y.data(), b);
            WritablePart<D> out(slope.data(), b);
            out.position() = part.velocity();
            out.orientation() = orientation_rate(Column<S::orientation>(part.orientation()), Turn<D>(part.omega()));
        }
    }

    // The distance of two slopes, in the norm of the error without its tolerance. A single stage follows from its
    // accelerations; coupled stages also from rates of the others in the pass before.
    double distance(const Vector& a, const Vector& b, bool coupled) const {
        double sum = 0.0;
        for (int i = 0; i < layout_.controlled(); ++i) {
            if (!coupled && i < layout_.bodies.size && i % S::state < S::pose) continue;
            const double part = (a[i] - b[i]) / (layout_.scale[i] + std::abs(stage_[i]));
            sum += part * part;
        }
        return std::sqrt(sum / layout_.controlled());
    }

    // The body of which the accelerations change most.
    int furthest(const Vector& change) const {
        int found = 0;
        double most = 0.0;
        for (int body = 0; body < equations_.model().size(); ++body) {
            const Part<D> part(change.data(), body);
            const double size = part.velocity().norm() / equations_.model().length + part.omega().norm();
            if (size > most) most = size, found = body;
        }
        return found;
    }

    EquationsOfMotion<D>& equations_;
    ImplicitStage<D> implicit_;
    const Thresholds& thresholds_;
    const double least_;  // the error of a velocity to which stages are solved
    Vector base_, found_, jump_;
    double weights_[most_stages];
    std::vector<double> lambda_;  // of the last stage
    std::vector<double> jump_lambda_, after_lambda_;
    std::vector<Vector> old_;  // slopes of the stages in the pass before
    long evaluations_ = 0;
    double contraction_ = thresholds_.first_contraction;
    std::optional<Unsolved> unsolved_;
};

}  // namespace mbproj
