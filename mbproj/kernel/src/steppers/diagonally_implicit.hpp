// Singly diagonally implicit Runge-Kutta steps of an explicit first stage, stiffly accurate (ESDIRK): each stage is solved
// after the other for its accelerations (dynamics/implicit_stage.hpp). The last stage is the end of the step, and its slope
// the first of the next step: evaluated anew after the projection, a stiff spring would make a large force of the little that
// the projection has moved it.
#pragma once

#include "dynamics/implicit_stage.hpp"
#include "steppers/stepper.hpp"

namespace mbproj {

template <int D> class DiagonallyImplicit final : public Stepper<D> {
public:
    using Base = Stepper<D>;
    using S = Size<D>;
    using typename Base::Vector;
    using typename Base::Visit;

    // `tolerance`: of the steps, or 0 where they are fixed.
    DiagonallyImplicit(const Tableau& tableau, EquationsOfMotion<D>& equations, double length, double tolerance)
        : Base(tableau, equations, length, tableau.stages()), implicit_(equations),
          thresholds_(equations.model().thresholds),
          least_(std::max(thresholds_.newton_part * tolerance, thresholds_.newton_fixed)), base_(equations.total()),
          found_(Vector::Zero(equations.total())), jump_(found_), lambda_(equations.model().all_rows()),
          jump_lambda_(lambda_), after_lambda_(lambda_) {}
    DiagonallyImplicit(const DiagonallyImplicit&) = default;

    std::unique_ptr<Base> copy() const override { return std::make_unique<DiagonallyImplicit>(*this); }

    long attempt_cost() const override { return evaluations_; }
    int error_cost() const override { return 0; }
    int extend_cost() const override { return 0; }
    int arrival_cost() const override { return 0; }

    bool attempt(double t, const Vector& y, double h, Vector& y_new) override {
        evaluations_ = 0;
        contraction_ = thresholds_.first_contraction;
        unsolved_.reset();
        for (int s = 1; s < tableau_.stages(); ++s) {
            combine(y, h, tableau_.a.row(s), s, base_);
            extrapolate(s);
            if (!solve(t + tableau_.c[s] * h, h * tableau_.a(s, s), k_[s])) return false;
        }
        y_new = stage_;
        return true;
    }
    std::optional<Unsolved> unsolved() const override { return unsolved_; }

    void quadrature(double t, const Vector& y, double h, const Visit& visit) const override {
        Vector state(y.size());
        for (int s = 0; s < tableau_.stages(); ++s) {
            if (tableau_.b[s] == 0.0) continue;
            combine(y, h, tableau_.a.row(s), s + 1, state);
            visit(tableau_.b[s], t + tableau_.c[s] * h, state);
        }
    }

    std::optional<double> error(double, const Vector& y, const Vector& y_new, double h, double tolerance) override {
        found_.setZero();
        for (int s = 0; s < tableau_.stages(); ++s) found_ += (h * tableau_.error(0, s)) * k_[s];
        if (implicit_.is_stiff() && !implicit_.filter(y_new.data(), h * tableau_.gamma, found_.data()))
            return std::nullopt;
        double sum = 0.0;
        for (int i = 0; i < equations_.size(); ++i) {
            const double part = found_[i] / (tolerance * (scale_[i] + std::max(std::abs(y[i]), std::abs(y_new[i]))));
            sum += part * part;
        }
        return std::sqrt(sum / equations_.size());
    }

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
    // Stiff forces keep the accelerations of the extension, as a projection moves this state, too.
    bool inside(double t, double h, double theta, const Vector& y, Vector& slope, double* lambda) override {
        combine(Vector::Zero(y.size()), 1.0, this->dense_rates(theta), tableau_.stages(), found_);
        return implicit_.slope_beside(t, y.data(), h * tableau_.gamma, found_.data(), slope.data(), lambda);
    }

    // At one state, which the projection has moved, forces differ by the jump alone.
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
        equations_.see(window);
        const bool found = before_jump(t, y);
        equations_.see({});
        return found && after_jump(t, y, slope, lambda);
    }
    bool carries_slope() const override { return true; }

private:
    static constexpr int most_extrapolated = 3;  // stages

    // The accelerations of stage s from those of the stages before, by the polynomial through them.
    void extrapolate(int s) {
        const std::vector<double>& c = tableau_.c;
        const int from = std::max(0, s - most_extrapolated);
        k_[s].setZero();
        for (int i = from; i < s; ++i) {
            double weight = 1.0;
            for (int j = from; j < s; ++j)
                if (j != i) weight *= (c[s] - c[j]) / (c[i] - c[j]);
            k_[s] += weight * k_[i];
        }
    }
    // Newton's method for the stage at t, with the accelerations in k to begin with: k becomes its slope, `stage_` its state.
    bool solve(double t, double g, Vector& k) {
        double before = std::numeric_limits<double>::infinity();
        for (int pass = 0; pass < thresholds_.most_newton; ++pass) {
            place(g, k);
            ++evaluations_;
            if (!implicit_.slope(t, stage_.data(), g, k.data(), pass, found_.data(), lambda_.data()))
                return pass > 0 && !equations_.broken_state().empty() && fails(k);
            const double change = g * distance(found_, k);
            k.swap(found_);
            if (!std::isfinite(change)) return fails(k);
            if (pass > 0) contraction_ = std::max(change / before, thresholds_.least_contraction);
            if (is_solved(change, before)) {
                place(g, k);
                set_rates(stage_, k);
                return true;
            }
            before = change;
        }
        return fails(k);
    }

    // After a pass that has led from the accelerations in `found_` to those in k.
    bool fails(const Vector& k) {
        const Vector change = k - found_;
        unsolved_ = Unsolved{furthest(change), implicit_.leader(change)};
        return false;
    }

    // By what is left, as the contraction so far lets expect; or because round-off keeps it from falling.
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
        for (int i = equations_.size(); i < equations_.total(); ++i) stage_[i] = base_[i] + g * k[i];
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

    // Of two slopes the accelerations, in the norm of the error without its tolerance.
    double distance(const Vector& a, const Vector& b) const {
        double sum = 0.0;
        for (int i = 0; i < equations_.size(); ++i) {
            if (i % S::state < S::pose) continue;
            const double part = (a[i] - b[i]) / (scale_[i] + std::abs(stage_[i]));
            sum += part * part;
        }
        return std::sqrt(sum / equations_.size());
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

    ImplicitStage<D> implicit_;
    const Thresholds& thresholds_;
    const double least_;  // of a velocity, to which stages are solved
    Vector base_, found_, jump_;
    std::vector<double> lambda_;  // of the last stage
    std::vector<double> jump_lambda_, after_lambda_;
    long evaluations_ = 0;
    double contraction_ = thresholds_.first_contraction;
    std::optional<Unsolved> unsolved_;

    using Base::combine, Base::equations_, Base::k_, Base::scale_, Base::stage_, Base::tableau_;
};

}  // namespace mbproj
