// The KKT system [W Gᵀ; G 0] (δ, λ) = (f, c) of Eq. 14 in tangent coordinates, and of Eqs. 39-74 with f = 0 and
// c = -C or -C': factored at a pose, solved for any right-hand side.
#pragma once

#include <optional>

#include "elimination/leaves.hpp"
#include "elimination/metric.hpp"
#include "loops/loop_solver.hpp"
#include "loops/minimum_norm_multipliers.hpp"

namespace mbproj {

template <class D> class KktSolver final {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;
    using Wrench = Column<F, Scalar<D>>;

    // With a penalty factor, all joints stay in the loops: (M + α GᵀG)⁻¹ α Gᵀ = M⁻¹Gᵀ (S + 1/α)⁻¹.
    KktSolver(const Model<D>& model, std::optional<double> penalty)
        : model_(model), thresholds_(model.thresholds), compliance_(model), order_(model, !penalty),
          leaves_(model, order_.leaves), loops_(model, order_, compliance_), shift_(penalty ? 1.0 / *penalty : 0.0),
          lent_(lent_mass(model)), inertias_(model.size()), reference_(model.size() + 1, Point<D>::Zero()),
          is_bare_(model.size(), false), force_(model.size() + 1), delta_(model.size() + 1) {
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b)
            is_bare_[order_.loop_bodies[b]] = !loops_.is_hinged(b);
        for (const LoopHinge<D>& hinge : order_.loop_hinges)
            if (hinge.parent() < model.size()) is_bare_[hinge.parent()] = false;
        for (const Leaf<D>& leaf : order_.leaves)
            if (leaf.hinge.parent < model.size()) is_bare_[leaf.hinge.parent] = false;
        for (int b = 0; b < model.size(); ++b)
            if (!is_bare_[b] || model.bodies[b].is_light) with_inertia_.push_back(b);
    }

    // Leaves out these rows of the model, ascending, each of a joint in a loop, in the calls to come.
    void leave_out(const std::vector<int>& rows) {
        if (rows != loops_.left_out()) loops_.leave_out(rows);
    }
    const std::vector<int>& left_out() const { return loops_.left_out(); }

    // Factors at a pose. Rows whose squared distance from the span of the others is below the part `near` of its usual
    // value are left out of this factor; with `near` = 0 none is. False where a joint's rows are dependent, those of
    // `singular_joint`, or a motion carries no mass.
    bool factor(const Pose<D>& pose, Metric metric) { return factor(pose, metric, thresholds_.half_digits); }
    bool factor(const Pose<D>& pose, Metric metric, double near) {
        ++factorisations_;
        metric_ = metric;
        const Compliance<D>* stiff = metric == Metric::stiff ? &compliance_ : nullptr;
        if (const int joint = leaves_.set_pose(pose, reference_, stiff); joint >= 0) return fails(joint);
        if (stiff_.empty())
            for (const int b : with_inertia_) set_inertia(b, pose[b].rotation, metric);
        else
            for (int b = 0; b < model_.size(); ++b) set_inertia(b, pose[b].rotation, metric);
        if (const int joint = leaves_.factor(inertias_, reference_, metric != Metric::coordinates); joint >= 0)
            return fails(joint);
        if (order_.loop_bodies.empty()) return true;
        if (const int joint = loops_.set_hinges(pose); joint >= 0) return fails(joint);
        if (!set_halves(pose, metric)) return fails(-1);
        if (order_.loop_joints.empty()) return true;
        loops_.leave_none_out();
        const double shift = metric == Metric::penalised ? shift_ : 0.0;
        const int failed = loops_.factor(pose, thresholds_.no_digits, shift);
        if (failed >= 0 && stiff) return loops_.factor_by_qr(pose) || fails(-1);
        if (failed >= 0 || pivots_part() < near)
            if (near == 0.0 || !factor_near_singular(pose, shift, failed, near)) return fails(failed);
        return true;
    }

    // Whether rows were left out of the last factor because they are dependent at its pose alone.
    bool near_singular() const { return loops_.cholesky().leaves_out(); }
    // Whether rows would be left out whichever redundant rows are held.
    bool near_branch(const Pose<D>& pose) { return is_near_singular(pose, near_); }
    // Whether the last factor is that of S with all rows held.
    bool is_regular() const { return !near_singular() && !loops_.by_qr(); }
    // An estimate of the last factor's squared distance from dependent rows, in parts of its usual value.
    double nearness() const { return near_singular() ? 0.0 : pivots_part(); }

    // Whether no row is nearer than √near to dependence, where all bodies have the same mass.
    bool is_clear(const Pose<D>& pose, double near) {
        return is_regular() && metric_ == Metric::mass && near < even_nearness(pose);
    }

    // Whether rows are nearer than √near to dependence, where all bodies have the same mass: real masses do not count.
    bool is_near_singular(const Pose<D>& pose, double near) {
        ++close_looks_;
        return count_dependent(pose, near * model_.rows.even) > model_.rows.redundant;
    }
    // The number of rows that depend on the others at a pose, up to a distance of √smallest.
    int count_dependent(const Pose<D>& pose, double smallest) {
        return static_cast<int>(loops_.dependent_rows(pose, smallest).size());
    }
    // The rows without which those of a pose are best-conditioned, exactly as many as are redundant; nothing where more rows are
    // dependent.
    auto rows_to_leave_out(const Pose<D>& pose) {
        ++close_looks_;
        return loops_.rows_to_leave_out(pose, model_.rows.redundant);
    }
    // The smallest pivot of the rows held where all bodies have the same mass; and in parts of its usual value. The
    // current factor does not change.
    double even_pivot(const Pose<D>& pose) {
        ++close_looks_;
        return loops_.even_pivot(pose);
    }
    double even_nearness(const Pose<D>& pose) { return even_pivot(pose) / model_.rows.even; }
    // Sets the usual pivots of the rows held: masses and lengths of different orders make some small at every pose.
    void expect(const std::vector<double>& usual) { loops_.expect(usual); }
    // The number of searches for dependent rows or a singular pose.
    long close_looks() const { return close_looks_; }

    // Moments of inertia that the next factors add to the bodies', or none.
    void stiffen(const std::vector<Scalar<D>>& moments) { stiff_ = moments; }

    // Sets the forces on a body before `solve`: a force at its centre of mass and a moment, global axes.
    void set_force(int body, const Point<D>& force, const Turn<D>& torque) {
        force_[body].template head<D::axes>() = force;
        // The centre of mass is at -reference from the reference point.
        force_[body].template tail<S::turns>() = torque - moment(reference_[body], force);
    }
    // Adds to the force on a body.
    void add_force(int body, const Point<D>& force, const Turn<D>& torque) {
        force_[body].template head<D::axes>() += force;
        force_[body].template tail<S::turns>() += torque - moment(reference_[body], force);
    }
    void clear_forces() { std::fill(force_.begin(), force_.end(), Wrench::Zero()); }

    // Solves with the forces set before, which are used up, and G δ = c; multipliers on request, one for each row.
    // False where a body without mass is free to move.
    bool solve(const Scalar<D>* c, Scalar<D>* lambda = nullptr) {
        leaves_.solve_up(c, force_);
        const bool settled =
            order_.loop_bodies.empty() || loops_.solve(force_, c, delta_, metric_ == Metric::penalised);
        delta_.back().setZero();
        leaves_.solve_down(delta_, lambda);
        if (lambda) loops_.multipliers(lambda);
        return settled || fails(-1);
    }

    // Σ I s'² of the flywheels, of the last `solve` for velocities.
    Scalar<D> of_flywheels() const { return loops_.of_flywheels() + leaves_.of_flywheels(); }
    // The largest distance of a violation, in rows left out of the last factor, from the value implied by the others.
    Scalar<D> contradiction(const Scalar<D>* violation) { return loops_.contradiction(violation); }
    // λ of the last `solve`, distributed over redundant rows so that its norm is smallest. False where that has no solution.
    bool spread(const Pose<D>& pose, Scalar<D>* lambda) {
        loops_.multipliers(lambda);
        if (left_out().empty()) return true;
        return spread_over_all(pose, lambda, near_singular() ? thresholds_.half_digits : thresholds_.no_digits);
    }
    // Distributes any λ that balance the forces, with any factor.
    bool spread_over_all(const Pose<D>& pose, Scalar<D>* lambda) {
        return spread_over_all(pose, lambda, thresholds_.no_digits);
    }

    // (δr, δθ) or accelerations of a body, for its centre of mass, global axes.
    Turn<D> turn(int body) const { return delta_[body].template tail<S::turns>(); }
    Point<D> shift(int body) const {
        return delta_[body].template head<D::axes>() - turned_by(turn(body), reference_[body]);
    }

    // The compliant rows of the metric `stiff`.
    Compliance<D>& compliance() { return compliance_; }

    int singular_joint() const { return singular_joint_; }
    long factorisations() const { return factorisations_; }
    const EliminationOrder<D>& order() const { return order_; }
    const BlockCholesky<Scalar<D>>& cholesky() const { return loops_.cholesky(); }

private:
    bool spread_over_all(const Pose<D>& pose, Scalar<D>* lambda, double shift) {
        if (!smallest_) smallest_ = std::make_unique<MinimumNormMultipliers<D>>(model_, order_);
        return smallest_->spread(pose, shift, lambda);
    }
    bool fails(int joint) { return singular_joint_ = joint, false; }

    // Near a singular pose almost dependent rows have finite multipliers, but almost no gradient left. Leaving them out errs by
    // their distance from the span of the others; dividing by that distance errs without bound. Where no row is near dependent,
    // the masses are why S has few digits, or none.
    bool factor_near_singular(const Pose<D>& pose, double shift, int failed, double near) {
        ++close_looks_;
        near_ = near;
        const int dependent = loops_.leave_out_dependent(pose, near * model_.rows.even);
        if (dependent == 0 && failed >= 0) return loops_.factor_by_qr(pose);
        return loops_.factor(pose, thresholds_.no_digits, shift) < 0;
    }

    double pivots_part() const {
        if (metric_ == Metric::coordinates) return cholesky().smallest_pivot() / model_.rows.even;
        return cholesky().nearness();
    }

    bool lends_inertia(int body, Metric metric) const {
        return model_.bodies[body].is_light && metric != Metric::coordinates;
    }
    bool takes_inertia(int body, Metric metric) const {
        return !is_bare_[body] || lends_inertia(body, metric) || !stiff_.empty();
    }

    // The inverse roots of the loops' bodies; false where an inertia is singular.
    bool set_halves(const Pose<D>& pose, Metric metric) {
        const bool by_coordinates = metric == Metric::coordinates;
        loops_.set_lent_inertia(by_coordinates ? Wrench(Wrench::Zero()) : lent_);
        loops_.turn_flywheels(!by_coordinates);
        loops_.comply(metric == Metric::stiff);
        if (!loops_.set_hinged(inertias_)) return false;
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b) {
            const int body = order_.loop_bodies[b];
            if (loops_.is_hinged(b)) continue;
            if (takes_inertia(body, metric)) {
                Inertia<D> M = inertias_[body];
                if (lends_inertia(body, metric)) M.add_lent_inertia(lent_);
                if (!loops_.half(b).articulated(M)) return false;
            } else if (by_coordinates) {
                loops_.half(b).bare(1.0, pose[body].rotation, 2.0 * Matrix<S::turns, S::turns, Scalar<D>>::Identity());
            } else {
                loops_.half(b).bare(model_.bodies[body].mass, pose[body].rotation, model_.bodies[body].inverse_root);
            }
        }
        return true;
    }

    // A body's own inertia at its reference point: the joint that it hangs on, or its centre of mass in the loops.
    [[gnu::always_inline]] void set_inertia(int b, const Rotation<D>& A, Metric metric) {
        if (metric == Metric::coordinates)
            inertias_[b].set(1.0, 0.25 * Matrix<S::turns, S::turns, Scalar<D>>::Identity(), reference_[b]);
        else
            inertias_[b].set(model_.bodies[b].mass, inertia_in_global(A, model_.bodies[b].inertia), reference_[b]);
        if (!stiff_.empty()) inertias_[b].C.diagonal() += stiff_[b];
    }

    const Model<D>& model_;
    const Thresholds& thresholds_;
    Compliance<D> compliance_;
    EliminationOrder<D> order_;
    Leaves<D> leaves_;
    LoopSolver<D> loops_;
    std::unique_ptr<MinimumNormMultipliers<D>> smallest_;  // created on first use
    const double shift_;                                   // the shift of S, where the violation is penalised
    const Wrench lent_;                                    // the inertia lent to light bodies
    std::vector<Inertia<D>> inertias_;
    std::vector<Point<D>> reference_;    // from each body's centre of mass
    std::vector<bool> is_bare_;          // whether a body of the loops has no leaves and no hinge
    std::vector<int> with_inertia_;      // bodies that are not bare, or are lent inertia
    std::vector<Wrench> force_, delta_;  // at the reference points; the ground's last
    std::vector<Scalar<D>> stiff_;       // moments of inertia that are added
    int singular_joint_ = -1;
    double near_ = 0.0;  // rows nearer than this were left out
    Metric metric_ = Metric::mass;
    long factorisations_ = 0, close_looks_ = 0;
};

}  // namespace mbproj
