// The KKT system [W Gᵀ; G 0] (δ, λ) = (f, c) of Eq. 14 in tangent coordinates, and of Eqs. 39-74 with f = 0 and
// c = -C or -C': factored at a pose, solved for any right-hand side.
#pragma once

#include <optional>

#include "elimination/leaves.hpp"
#include "elimination/metric.hpp"
#include "loops/loop_solver.hpp"

namespace mbproj {

template <int D> class KktSolver {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;
    using Wrench = Column<F>;

    // With a penalty factor, all joints stay in the loops: (M + α GᵀG)⁻¹ α Gᵀ = M⁻¹Gᵀ (S + 1/α)⁻¹.
    KktSolver(const Model<D>& model, std::optional<double> penalty)
        : model_(model), thresholds_(model.thresholds), order_(model, !penalty), leaves_(model, order_.leaves),
          loops_(model, order_), shift_(penalty ? 1.0 / *penalty : 0.0), lent_(lent_mass(model)),
          inertias_(model.size()), reference_(model.size() + 1, Point<D>::Zero()), articulated_(model.size(), false),
          force_(model.size() + 1), delta_(model.size() + 1) {
        for (const Leaf<D>& leaf : order_.leaves)
            if (leaf.hinge.parent < model.size()) articulated_[leaf.hinge.parent] = true;
    }

    // Factors at a pose; rows whose squared distance from the span of the others is below `near`, of what it is elsewhere,
    // are left out of this factor. False where a joint's rows are dependent or a motion carries no mass: `singular_joint`. Where
    // the model has redundant rows, as many are left out of the run.
    bool factor(const Pose<D>& pose, Metric metric) { return factor(pose, metric, thresholds_.near_dependent); }
    bool factor(const Pose<D>& pose, Metric metric, double near) {
        if (model_.redundant > left_out_) hold_best_rows(pose);
        const bool found = factor_held(pose, metric, near);
        const bool regular = left_out_ == 0 || (found && !near_singular());
        if ((!learns || !stiff_.empty()) && found) return true;
        if (regular || (found && !others_may_serve_)) {
            others_may_serve_ = others_may_serve_ || regular;
            return found;
        }
        hold_best_rows(pose);
        const bool now = factor_held(pose, metric, near);
        others_may_serve_ = !near_singular();
        return now;
    }

    // With the rows that are held; `near` = 0 takes all of these, even where some hardly differ from the others.
    bool factor_held(const Pose<D>& pose, Metric metric, double near) {
        ++factorisations_;
        metric_ = metric;
        if (const int joint = leaves_.place(pose, reference_); joint >= 0) return fails(joint);
        for (int b = 0; b < model_.size(); ++b) set_inertia(b, pose[b].rotation, metric);
        if (const int joint = leaves_.factor(inertias_, reference_, metric != Metric::coordinates); joint >= 0)
            return fails(joint);
        if (!set_halves(pose, metric)) return fails(-1);
        if (order_.loop_joints.empty()) return true;
        loops_.leave_none_out();
        const double shift = metric == Metric::penalised ? shift_ : 0.0;
        const int failed = loops_.factor(pose, thresholds_.smallest_pivot, shift);
        if (failed < 0 && metric == Metric::mass && learns && stiff_.empty()) learn(pose);
        if (failed >= 0 || loops_.cholesky().smallest_pivot() < near * usual())
            if (near == 0.0 || !factor_near_singular(pose, metric, shift, failed, near)) return fails(failed);
        return true;
    }

    // Whether rows had to be left out of the last factor because they depend on the others at its pose alone.
    bool near_singular() const { return loops_.cholesky().leaves_out(); }

    // Whether no row is nearer to dependent than √near, where all bodies weigh the same. As long as the pivot at hand is at
    // least half of that at the last pose that was looked at, what was seen there holds to a quarter.
    bool is_clear(const Pose<D>& pose, double near) {
        const double pivot = loops_.cholesky().smallest_pivot();
        if (near_singular() || metric_ != Metric::mass) return false;
        if (pivot >= thresholds_.clear_fall * clear_pivot_ && near < clear_even_) return true;
        if (!learns) return false;
        clear_pivot_ = pivot;
        clear_even_ = thresholds_.clear_margin * even_pivot(pose) / usual_even_;
        return near < clear_even_;
    }

    // Whether rows are nearer to dependent than √near, where all bodies weigh the same: masses have no say in it.
    bool is_near_singular(const Pose<D>& pose, double near) {
        return loops_.count_dependent(pose, near * usual_even_) > model_.redundant;
    }

    // Whether a pivot of the rows held has fallen so far that others may be better.
    bool held_rows_decline() const {
        if (pivots_when_held_.empty()) return false;
        const std::vector<double> now = loops_.cholesky().pivots();
        return !std::equal(now.begin(), now.end(), pivots_when_held_.begin(),
                           [this](double a, double b) { return a >= thresholds_.decline * b; });
    }

    // Holds the best-conditioned rows of a pose from here on; leaves out exactly as many as are redundant.
    void hold_best_rows(const Pose<D>& pose) {
        if (!loops_.hold_best(pose, model_.redundant)) return;
        left_out_ = model_.redundant;
        forget_pivots();
    }

    // Holds only rows that are independent at a pose, up to a distance of √smallest. How many are left out.
    int hold_independent_rows(const Pose<D>& pose, double smallest) {
        forget_pivots();
        return left_out_ = loops_.hold_independent(pose, smallest);
    }

    // Moments of inertia that factors to come add to the bodies', or none.
    void stiffen(const std::vector<double>& moments) { stiff_ = moments; }

    // Forces on a body before `solve`: a force at its centre of mass and a moment, global axes.
    void set_force(int body, const Point<D>& force, const Turn<D>& torque) {
        force_[body].template head<D>() = force;
        // The centre of mass is at -reference from the reference point.
        force_[body].template tail<S::turns>() = torque - moment(reference_[body], force);
    }
    void clear_forces() { std::fill(force_.begin(), force_.end(), Wrench::Zero()); }

    // Solves with the forces given (which are used up) and G δ = c; multipliers on request, one for each row. False where
    // a body without mass is free to move.
    bool solve(const double* c, double* lambda = nullptr) {
        leaves_.solve_up(c, force_);
        const bool settled =
            order_.loop_bodies.empty() || loops_.solve(force_, c, delta_, metric_ == Metric::penalised);
        delta_.back().setZero();
        leaves_.solve_down(delta_, lambda);
        if (lambda) loops_.multipliers(lambda);
        return settled || fails(-1);
    }

    // Σ I s'² of the flywheels, of the last `solve` for velocities.
    double of_flywheels() const { return loops_.of_flywheels() + leaves_.of_flywheels(); }
    // How far rows that were left out of the last factor are from what the others say of a violation.
    double contradiction(const double* violation) const { return loops_.contradiction(violation); }
    // λ of the last `solve`, spread over redundant rows so that it is smallest.
    void spread(const Pose<D>& pose, double* lambda) const { loops_.smallest_multipliers(pose, lambda); }

    // (δr, δθ) or accelerations of a body, of its centre of mass, global axes.
    Turn<D> turn(int body) const { return delta_[body].template tail<S::turns>(); }
    Point<D> shift(int body) const { return delta_[body].template head<D>() - turned_by(turn(body), reference_[body]); }

    bool learns = true;  // from the poses that are factored: what is usual, and which rows to hold

    int singular_joint() const { return singular_joint_; }
    long factorisations() const { return factorisations_; }
    const EliminationOrder<D>& order() const { return order_; }
    const BlockCholesky& cholesky() const { return loops_.cholesky(); }
    // Of the last factor: its rows' distance from dependent, squared, about, as a part of what it is elsewhere.
    double nearness() const { return near_singular() ? 0.0 : cholesky().smallest_pivot() / usual(); }

private:
    bool fails(int joint) { return singular_joint_ = joint, false; }

    void forget_pivots() {
        pivots_when_held_.clear();
        clear_pivot_ = std::numeric_limits<double>::infinity();
    }

    // Masses and lengths of different orders make small pivots at every pose: singular is one where they are small beside
    // the largest that was seen. The same of bodies that weigh alike.
    void learn(const Pose<D>& pose) {
        const double pivot = loops_.cholesky().smallest_pivot();
        if (left_out_ > 0 && pivots_when_held_.empty()) pivots_when_held_ = loops_.cholesky().pivots();
        if (pivot <= thresholds_.usual_growth * usual_pivot_) return;
        usual_pivot_ = pivot;
        usual_even_ = 1.0;
        if (pivot >= thresholds_.near_branch) return;
        usual_even_ = even_pivot(pose);
        clear_pivot_ = std::numeric_limits<double>::infinity();
    }
    // The smallest where all bodies weigh the same; the factor at hand stays.
    double even_pivot(const Pose<D>& pose) {
        const double found = loops_.even_pivot(pose);
        set_halves(pose, Metric::mass);
        loops_.factor(pose, thresholds_.smallest_pivot);
        return found;
    }
    double usual() const {
        if (metric_ == Metric::coordinates) return usual_even_;
        return usual_pivot_ < thresholds_.near_branch ? usual_pivot_ : 1.0;
    }

    // Near a singular pose, rows that have almost become dependent have finite multipliers but almost no gradient left:
    // leaving them out errs by their distance from the span of the others, dividing by that errs without bound. Where no
    // row is near to dependent, it is the masses that leave S few digits, or none.
    bool factor_near_singular(const Pose<D>& pose, Metric metric, double shift, int failed, double near) {
        const int dependent = loops_.leave_out_dependent(pose, near * usual_even_);
        if (!set_halves(pose, metric)) return false;
        if (dependent == 0 && failed >= 0) return loops_.factor_by_qr(pose);
        return loops_.factor(pose, thresholds_.smallest_pivot, shift) < 0;
    }

    // The inertias of the loops' bodies, halved; false where one has no inverse.
    bool set_halves(const Pose<D>& pose, Metric metric) {
        const bool by_coordinates = metric == Metric::coordinates;
        loops_.lend(by_coordinates ? Wrench(Wrench::Zero()) : lent_);
        loops_.turn_flywheels(!by_coordinates);
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b) {
            const int body = order_.loop_bodies[b];
            const bool lends = model_.bodies[body].is_light && !by_coordinates;
            if (articulated_[body] || lends || !stiff_.empty()) {
                Inertia<D> M = inertias_[body];
                if (lends) M.lend(lent_);
                if (!loops_.half(b).articulated(M)) return false;
            } else if (by_coordinates) {
                loops_.half(b).bare(1.0, pose[body].rotation, 2.0 * Matrix<S::turns, S::turns>::Identity());
            } else {
                loops_.half(b).bare(model_.bodies[body].mass, pose[body].rotation, model_.bodies[body].inverse_root);
            }
        }
        return true;
    }

    // A body's own inertia at its reference point: the joint that it hangs on, or its centre of mass in the loops.
    [[gnu::always_inline]] void set_inertia(int b, const Rotation<D>& A, Metric metric) {
        if (metric == Metric::coordinates)
            inertias_[b].set(1.0, 0.25 * Matrix<S::turns, S::turns>::Identity(), reference_[b]);
        else
            inertias_[b].set(model_.bodies[b].mass, inertia_in_global(A, model_.bodies[b].inertia), reference_[b]);
        if (!stiff_.empty()) inertias_[b].C.diagonal().array() += stiff_[b];
    }

    const Model<D>& model_;
    const Thresholds& thresholds_;
    EliminationOrder<D> order_;
    Leaves<D> leaves_;
    LoopSolver<D> loops_;
    const double shift_;  // of S, where the violation is penalised
    const Wrench lent_;   // to light bodies
    std::vector<Inertia<D>> inertias_;
    std::vector<Point<D>> reference_;  // from each body's centre of mass
    std::vector<bool> articulated_;
    std::vector<Wrench> force_, delta_;  // at the reference points; the ground's last
    std::vector<double> stiff_;          // moments of inertia that are added
    int singular_joint_ = -1;
    int left_out_ = 0;              // rows, as redundant
    bool others_may_serve_ = true;  // where rows become dependent
    double usual_pivot_ = 0.0, usual_even_ = 1.0;
    double clear_pivot_ = std::numeric_limits<double>::infinity(), clear_even_ = 0.0;
    std::vector<double> pivots_when_held_;  // the pivots when they were chosen; empty until known
    Metric metric_ = Metric::mass;
    long factorisations_ = 0;
};

}  // namespace mbproj
