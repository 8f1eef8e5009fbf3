// The Newton-Euler equations in the bodies' velocities, with the joints' multipliers: y' = f(y).
#pragma once

#include <limits>

#include "dynamics/bearing_loads.hpp"
#include "dynamics/body_forces.hpp"
#include "dynamics/drive.hpp"
#include "dynamics/formulation.hpp"
#include "dynamics/row_policy.hpp"
#include "dynamics/row_values.hpp"
#include "dynamics/state_rates.hpp"
#include "kinematics/couplings.hpp"
#include "kinematics/loads.hpp"

namespace mbproj {

// All quantities at one state, the state in place; evaluations overwrite this scratch.
template <class D> class EquationsOfMotion final {
public:
    using S = Size<D>;

    EquationsOfMotion(const Model<D>& model, const ProjectionSettings& projection)
        : model_(model), projection_(projection), pose_(model), motion_(model), solver_(model, projection.penalty()),
          policy_(model, solver_), gamma_(model.all_rows()), C_(model.all_rows()), C_dot_(model.all_rows()),
          lambda_(model.all_multipliers()), drive_(model), applied_(model), bearings_(model), contacts_(model),
          couplings_(model), expected_(model.layout.followed.size), channels_(model), states_(model) {}

    // The layout of y.
    const Layout& layout() const { return model_.layout; }

    // y' at a state, with the rows that are held. Equal input has equal bits, whatever was evaluated before. False where the
    // equations have no unique solution, or a function has no value: see `broken`.
    bool derivative(double t, const double* y, double* slope, double* lambda = nullptr) {
        return factor_stage(t, y) && slope_of_stage(y, slope, lambda);
    }
    // `derivative` at a stage of a step: the row policy records how near the pose is to a singular one. False also
    // where other rows would serve: see `hold_others`.
    bool watched_derivative(double t, const double* y, double* slope, double* lambda = nullptr) {
        if (!factor_stage(t, y)) return false;
        policy_.record_pose();
        return !policy_.wants_others(pose_) && slope_of_stage(y, slope, lambda, true);
    }
    // `derivative` by the kernel alone, without another formulation.
    bool own_derivative(double t, const double* y, double* slope, double* lambda) {
        return factor_stage(t, y) && (set_velocities(y, false), own_slope_at(y, slope, lambda));
    }

    // Sets the velocities at the pose in place, with their right-hand sides; C' on request.
    void set_velocities(const double* y, bool with_C_dot) {
        motion_.update(y, pose_);
        const bool baumgarte = projection_.correction == Correction::baumgarte;
        with_C_dot = with_C_dot || baumgarte;
        moving_rows(model_, pose_, motion_, with_C_dot ? C_dot_.data() : nullptr, gamma_.data());
        leave_flywheels(model_, C_dot_);
        for (std::size_t k = 0; k < drive_.size(); ++k) {
            gamma_[model_.driven[k].row] += drive_[k].dd;
            if (with_C_dot) C_dot_[model_.driven[k].row] -= drive_[k].d;
        }
        if (baumgarte) stabilise();
    }

    // y' with the pose in place and factored with the masses, and the velocities in place; multipliers on request.
    bool slope_at(const double* y, double* slope, double* lambda = nullptr, bool watched = false) {
        if (!own_slope_at(y, slope, lambda)) return false;
        return !other_ || metric_ == Metric::stiff || other_->slope_at(*this, y, slope, lambda, watched);
    }
    bool own_slope_at(const double* y, double* slope, double* lambda = nullptr) {
        if (bearings_.any() || contacts_.has_feet()) unload();
        if (contacts_.any() && !(contacts_.factor(pose_, solver_) && contacts_.cholesky().full())) return false;
        if (model_.loads || states_.any()) set_channels(window_.clamped(t_), y);
        if (broken_ || !set_forces(y) || (states_.any() && !states_.set(channels_, slope))) return broken(y);
        if (contacts_.has_feet() && !add_foot_friction(y)) return false;
        if (bearings_.any() && !settle_bearings(y)) return false;
        if (contacts_.any() && !settle_contacts(y)) return false;
        if (!solver_.solve(gamma_.data(), lambda || !drive_.empty() ? lambda_.data() : nullptr)) return false;
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> part(y, b);
            WritablePart<D> out(slope, b);
            out.position() = part.velocity();
            out.orientation() = orientation_rate(Column<S::orientation>(part.orientation()), Turn<D>(part.omega()));
            out.velocity() = solver_.shift(b);
            out.omega() = to_body(pose_[b].rotation, solver_.turn(b));
        }
        set_work(layout().quadratures, applied_, drive_, lambda_.data(), slope);
        for (int i = 0; i < layout().followed.size; ++i)
            slope[layout().followed.first + i] = model_.counts_turns[i] ? angle(i).speed : 0.0;
        if (contacts_.acts()) contacts_.write_forces(applied_, lambda_.data() + model_.all_rows());
        if (lambda) std::copy(lambda_.begin(), lambda_.end(), lambda);
        return true;
    }

    // The rates of work in the last slope at another state, with that slope's multipliers; for scenes with loads.
    bool settle_work(double t, const double* y, double* slope) {
        set_pose(t, y);
        motion_.update(y, pose_);
        const bool done = applied_.update(*model_.loads, pose_, motion_, set_channels(window_.clamped(t_), y));
        set_work(layout().quadratures, applied_, drive_, lambda_.data(), slope);
        return done || broken(y);
    }

    // Sets a state at a time.
    void set_pose(double t, const double* y) {
        pose_.update(y);
        const Block& followed = layout().followed;
        if (followed.size) std::copy(y + followed.first, y + followed.end(), expected_.begin());
        factored_ = known_ = false;
        if (t == t_ && !broken_) return;
        t_ = t;
        broken_ = !drive_.set(t, window_);
    }
    // From now on functions of time are evaluated inside this window.
    void set_window(const TimeWindow& window) { window_ = window, known_ = false, broken_ = !drive_.set(t_, window_); }
    void set_pose(const double* y) { set_pose(t_, y); }  // at the same time
    bool factor(Metric metric) {
        if (factored_ && metric == metric_) return true;
        metric_ = metric;
        return held_ = factored_ = solver_.factor(pose_, metric);
    }
    // Moments of inertia that the next factors add to the bodies', for corrections alone; empty for none.
    void stiffen(const std::vector<double>& moments) { held_ = factored_ = false, solver_.stiffen(moments); }
    // Factors with all rows, also those that are dependent at this pose alone; this factor is used once.
    bool factor_all(Metric metric) {
        held_ = factored_ = false;
        return solver_.factor(pose_, metric, 0.0);
    }
    // Sets the stiffness of forces at the start of a step.
    void begin_stiff(double t, const double* y, double g) {
        unload();
        set_pose(t, y);
        set_velocities(y, false);
        solver_.compliance().set(applied_, pose_, motion_, set_channels(window_.clamped(t_), y), g, {0, 0});
    }
    // Factors with the masses and the stiff forces of an implicit stage with this g, at the state in place, in a pass
    // of Newton's method. The rows do not change, however dependent on the compliant rows they are.
    bool factor_stiff(const double* y, double g, Pass pass) {
        metric_ = Metric::stiff;
        solver_.compliance().set(applied_, pose_, motion_, set_channels(window_.clamped(t_), y), g, pass);
        return held_ = factored_ = solver_.factor(pose_, Metric::stiff, 0.0);
    }
    // Chooses the rows of a step from the pose in place, which is closed. False without a unique solution there.
    bool start() {
        const bool usual = policy_.holds_usual();
        return factored_with_masses(usual ? policy_.settle(pose_, factor(Metric::mass)) : policy_.start(pose_));
    }
    bool wants_others() const { return policy_.wants_others(pose_); }
    // Where the rows held are dependent at the pose in place, or leave no unique solution: holds others for this step. False
    // where there are none.
    bool hold_others() {
        if (held_ && !wants_others()) return false;
        return factored_with_masses(policy_.hold_others(pose_));
    }
    // Whether the pose in place is near a singular one.
    bool is_near_singular() { return solver_.is_near_singular(pose_, model_.thresholds.near_branch); }
    // Whether there is a factor in this metric, which may belong to an earlier pose.
    bool holds(Metric metric) const { return held_ && metric == metric_; }
    const double* constraint() {
        if (std::exchange(known_, true)) return C_.data();
        mbproj::constraint(model_, pose_, C_.data());
        leave_flywheels(model_, C_);
        couplings_.count(pose_, expected_, C_.data());
        drive_.close(C_.data());
        return C_.data();
    }
    const double* constraint_velocity(const double* y) {
        motion_.update(y, pose_);
        moving_rows(model_, pose_, motion_, C_dot_.data(), static_cast<double*>(nullptr));
        leave_flywheels(model_, C_dot_);
        for (std::size_t k = 0; k < drive_.size(); ++k) C_dot_[model_.driven[k].row] -= drive_[k].d;
        return C_dot_.data();
    }
    // C of the last `constraint`, and C' of the last `set_velocities`.
    const double* C() const { return C_.data(); }
    double* gamma() { return gamma_.data(); }
    const double* C_dot() const { return C_dot_.data(); }

    // Gears and screws count from the teeth that are in mesh now.
    void start_teeth() { couplings_.start(pose_, expected_, constraint()), known_ = false; }
    // A coordinate that is an angle, in the state in place.
    JointAngle<D> angle(int coordinate) const { return joint_angle(model_, pose_, motion_, coordinate); }
    // The values that motions prescribe at this time.
    const Drive<D>& drive() const { return drive_; }
    // The state, at `time`, at which a function of the scene had no finite value; empty where none failed.
    const std::vector<double>& broken_state() const { return broken_state_; }
    bool broken(const double* y) {
        broken_ = true;
        broken_state_.assign(y, y + layout().size());
        return false;
    }
    void forget_broken_state() { broken_state_.clear(); }
    double time() const { return t_; }
    // The law of a friction that leaves no unique solution at the last state, or -1.
    int jammed() const { return contacts_.jammed() < 0 ? bearings_.jammed() : contacts_.jammed(); }
    const Model<D>& model() const { return model_; }
    Pose<D>& pose() { return pose_; }
    const Pose<D>& pose() const { return pose_; }
    const Motion<D>& motion() const { return motion_; }
    Applied<D>& applied() { return applied_; }
    // The variables of programs at the state in place, which is y, at t.
    Channels<D>& set_channels(double t, const double* y) { return channels_.set(t, y, pose_, motion_); }
    // The variables at t inside the window; and the variables of the last evaluation.
    Channels<D>& channels_at(double t, const double* y) { return set_channels(window_.clamped(t), y); }
    Channels<D>& channels() { return channels_; }
    StateRates<D>& states() { return states_; }
    // Programs are on these branches from now on.
    void hold(const double* branches) { applied_.held = states_.held = pose_.held = branches; }
    KktSolver<D>& solver() { return solver_; }
    const KktSolver<D>& solver() const { return solver_; }
    RowPolicy<D>& policy() { return policy_; }
    // From now on contacts hold these rows, and others slide; their forces follow the rows' multipliers.
    void hold_contacts(std::vector<ContactRow> rows, std::vector<SlidingRow> slides = {},
                       std::vector<ContactFoot> feet = {}) {
        applied_.touch(rows);
        contacts_.hold(std::move(rows), std::move(slides), std::move(feet));
        std::fill(lambda_.begin() + model_.all_rows(), lambda_.end(), 0.0);
    }
    ContactBorder<D>& contacts() { return contacts_; }
    void follow(Formulation* other) { other_ = other; }  // makes accelerations and projections from now on
    Formulation* other() const { return other_; }
    const TimeWindow& window() const { return window_; }
    double* multipliers() { return lambda_.data(); }  // of the last slope

private:
    bool factored_with_masses(bool found) { return metric_ = Metric::mass, held_ = factored_ = found; }
    bool factor_stage(double t, const double* y) {
        set_pose(t, y);
        return factor(Metric::mass) && factor_for_violation(y);
    }
    bool slope_of_stage(const double* y, double* slope, double* lambda = nullptr, bool watched = false) {
        set_velocities(y, false);
        return slope_at(y, slope, lambda, watched);
    }

    bool factor_for_violation(const double* y) {
        if (solver_.nearness() >= model_.thresholds.near_branch) return true;
        constraint();
        constraint_velocity(y);
        return held_ = factored_ = policy_.factor_for_violation(pose_, C_, C_dot_, time_scale(model_, y));
    }

    // From here on friction that depends on bearing loads is included.
    bool settle_bearings(const double* y) {
        return bearings_.settle(applied_, solver_, contacts_, pose_, motion_, gamma_.data()) &&
               (set_forces(y) || broken(y));
    }
    void unload() { std::fill(applied_.carried.begin(), applied_.carried.end(), 0.0), contacts_.load(applied_, false); }

    bool set_forces(const double* y) {
        if (model_.loads && !applied_.update(*model_.loads, pose_, motion_, channels_)) return false;
        mbproj::set_forces(model_, pose_, y, applied_, solver_);
        if (contacts_.gives()) contacts_.set_normals(pose_), contacts_.pull(solver_);
        return true;
    }
    // Sets the solver's forces with those of contacts, and with the friction by their pushes.
    [[gnu::noinline, gnu::cold]] bool settle_contacts(const double* y) {
        if (!solver_.solve(gamma_.data())) return false;
        contacts_.settle(solver_, &motion_);
        if (contacts_.has_feet() && !(contacts_.load(applied_), set_forces(y))) return broken(y);
        mbproj::set_forces(model_, pose_, y, applied_, solver_);
        contacts_.pull(solver_);
        return true;
    }
    // Adds friction at feet to the contacts' equations; the solver's forces are without it, as pushes are not known.
    [[gnu::noinline, gnu::cold]] bool add_foot_friction(const double* y) {
        if (!contacts_.add_friction(pose_, applied_, solver_)) return false;
        return mbproj::set_forces(model_, pose_, y, applied_, solver_), true;
    }

    // Baumgarte (ref. 9): C'' + 2α C' + β² C = 0.
    void stabilise() {
        const double* C = constraint();
        for (std::size_t r = 0; r < gamma_.size(); ++r)
            gamma_[r] -= 2.0 * projection_.alpha * C_dot_[r] + projection_.beta * projection_.beta * C[r];
    }

    const Model<D>& model_;
    const ProjectionSettings& projection_;
    Pose<D> pose_;
    Motion<D> motion_;
    KktSolver<D> solver_;
    RowPolicy<D> policy_;
    std::vector<double> gamma_, C_, C_dot_, lambda_;
    Drive<D> drive_;  // at t_
    TimeWindow window_;
    Applied<D> applied_;
    BearingLoads<D> bearings_;
    ContactBorder<D> contacts_;
    Couplings<D> couplings_;
    std::vector<double> expected_;  // the joints' coordinates, followed to less than half a turn
    Channels<D> channels_;
    StateRates<D> states_;
    std::vector<double> broken_state_;
    double t_ = std::numeric_limits<double>::quiet_NaN();
    bool factored_ = false, held_ = false, broken_ = false;
    bool known_ = false;  // whether C belongs to the pose in place
    Metric metric_ = Metric::mass;
    Formulation* other_ = nullptr;
};

}  // namespace mbproj
