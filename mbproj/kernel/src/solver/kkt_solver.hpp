// The KKT system [W Gᵀ; G 0] (δ, λ) = (f, c) of Eq. 14 in tangent coordinates, and of Eqs. 39-74 with f = 0 and
// c = -C or -C': factored at a pose, solved for any right-hand side.
#pragma once

#include <optional>

#include "solver/leaves.hpp"
#include "solver/loop_solver.hpp"
#include "solver/metric.hpp"
#include "solver/minimum_norm_multipliers.hpp"

namespace mbproj {

template <class D> class KktSolver final {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;
    using Wrench = Column<F, double>;

    // With a penalty factor, all joints stay in the loops: (M + α GᵀG)⁻¹ α Gᵀ = M⁻¹Gᵀ (S + 1/α)⁻¹.
    KktSolver(const Model<D>& model, std::optional<double> penalty);
    ~KktSolver();

    // Leaves out these rows of the model, ascending, each of a joint in a loop, in the calls to come.
    void leave_out(const std::vector<int>& rows);
    const std::vector<int>& left_out() const { return loops_.left_out(); }

    // Factors at a pose. Rows whose squared distance from the span of the others is below the part `near` of its usual
    // value are left out of this factor; with `near` = 0 none is. False where a joint's rows are dependent, those of
    // `singular_joint`, or a motion carries no mass.
    bool factor(const Pose<D>& pose, Metric metric) { return factor(pose, metric, thresholds_.half_digits); }
    bool factor(const Pose<D>& pose, Metric metric, double near);

    // Whether rows were left out of the last factor because they are dependent at its pose alone.
    bool near_singular() const { return loops_.cholesky().leaves_out(); }
    // Whether rows would be left out whichever redundant rows are held.
    bool near_branch(const Pose<D>& pose) { return is_near_singular(pose, near_); }
    // Whether the last factor is that of S with all rows held.
    bool is_regular() const { return !near_singular() && !loops_.by_qr(); }
    // An estimate of the last factor's squared distance from dependent rows, in parts of its usual value.
    double nearness() const { return near_singular() ? 0.0 : pivots_part(); }

    // Whether no row is nearer than √near to dependence, where all bodies have the same mass.
    bool is_clear(const Pose<D>& pose, double near);

    // Whether rows are nearer than √near to dependence, where all bodies have the same mass: real masses do not count.
    bool is_near_singular(const Pose<D>& pose, double near);
    // The number of rows that depend on the others at a pose, up to a distance of √smallest.
    int count_dependent(const Pose<D>& pose, double smallest);
    // The rows without which those of a pose are best-conditioned, exactly as many as are redundant; nothing where more rows are
    // dependent.
    std::optional<std::vector<int>> rows_to_leave_out(const Pose<D>& pose);
    // The smallest pivot of the rows held where all bodies have the same mass; and in parts of its usual value. The
    // current factor does not change.
    double even_pivot(const Pose<D>& pose);
    double even_nearness(const Pose<D>& pose) { return even_pivot(pose) / model_.rows.even; }
    // Sets the usual pivots of the rows held: masses and lengths of different orders make some small at every pose.
    void expect(const std::vector<double>& usual) { loops_.expect(usual); }
    // The number of searches for dependent rows or a singular pose.
    long close_looks() const { return close_looks_; }

    // Moments of inertia that the next factors add to the bodies', or none.
    void stiffen(const std::vector<double>& moments) { stiff_ = moments; }

    // Sets the forces on a body before `solve`: a force at its centre of mass and a moment, global axes.
    [[gnu::always_inline]] void set_force(int body, const Point<D>& force, const Turn<D>& torque) {
        force_[body].template head<D::axes>() = force;
        // The centre of mass is at -reference from the reference point.
        force_[body].template tail<S::turns>() = torque - moment(reference_[body], force);
    }
    // Adds to the force on a body.
    [[gnu::always_inline]] void add_force(int body, const Point<D>& force, const Turn<D>& torque) {
        force_[body].template head<D::axes>() += force;
        force_[body].template tail<S::turns>() += torque - moment(reference_[body], force);
    }
    void clear_forces() { std::fill(force_.begin(), force_.end(), Wrench::Zero()); }

    // Solves with the forces set before, which are used up, and G δ = c; multipliers on request, one for each row.
    // False where a body without mass is free to move.
    bool solve(const double* c, double* lambda = nullptr);

    // Σ I s'² of the flywheels, of the last `solve` for velocities.
    double of_flywheels() const;
    // The largest distance of a violation, in rows left out of the last factor, from the value implied by the others.
    double contradiction(const double* violation);
    // λ of the last `solve`, distributed over redundant rows so that its norm is smallest. False where that has no solution.
    bool spread(const Pose<D>& pose, double* lambda);
    // Distributes any λ that balance the forces, with any factor.
    bool spread_over_all(const Pose<D>& pose, double* lambda);

    // (δr, δθ) or accelerations of a body, for its centre of mass, global axes.
    [[gnu::always_inline]] Turn<D> turn(int body) const { return delta_[body].template tail<S::turns>(); }
    [[gnu::always_inline]] Point<D> shift(int body) const {
        return delta_[body].template head<D::axes>() - turned_by(turn(body), reference_[body]);
    }

    // The compliant rows of the metric `stiff`.
    Compliance<D>& compliance() { return compliance_; }

    int singular_joint() const { return singular_joint_; }
    long factorisations() const { return factorisations_; }
    const EliminationOrder<D>& order() const { return order_; }
    const BlockCholesky& cholesky() const { return loops_.cholesky(); }

private:
    bool spread_over_all(const Pose<D>& pose, double* lambda, double shift);
    bool fails(int joint) { return singular_joint_ = joint, false; }

    // Near a singular pose almost dependent rows have finite multipliers, but almost no gradient left. Leaving them out errs by
    // their distance from the span of the others; dividing by that distance errs without bound. Where no row is near dependent,
    // the masses are why S has few digits, or none.
    bool factor_near_singular(const Pose<D>& pose, double shift, int failed, double near);
    double pivots_part() const;
    bool lends_inertia(int body, Metric metric) const;
    bool takes_inertia(int body, Metric metric) const;

    // The inverse roots of the loops' bodies; false where an inertia is singular.
    bool set_halves(const Pose<D>& pose, Metric metric);

    // A body's own inertia at its reference point: the joint that it hangs on, or its centre of mass in the loops.
    [[gnu::always_inline]] void set_inertia(int b, const Rotation<D>& A, Metric metric) {
        if (metric == Metric::coordinates)
            inertias_[b].set(1.0, 0.25 * Matrix<S::turns, S::turns, double>::Identity(), reference_[b]);
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
    std::vector<double> stiff_;          // moments of inertia that are added
    int singular_joint_ = -1;
    double near_ = 0.0;  // rows nearer than this were left out
    Metric metric_ = Metric::mass;
    long factorisations_ = 0, close_looks_ = 0;
};

extern template class KktSolver<Plane<double>>;
extern template class KktSolver<Space<double>>;

}  // namespace mbproj
