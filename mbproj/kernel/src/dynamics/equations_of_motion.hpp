// The Newton-Euler equations in the bodies' velocities, with the joints' multipliers: y' = f(y).
#pragma once

#include "dynamics/bearing_loads.hpp"
#include "dynamics/body_forces.hpp"
#include "dynamics/drive.hpp"
#include "dynamics/equations.hpp"
#include "dynamics/row_policy.hpp"
#include "dynamics/row_values.hpp"
#include "dynamics/state_rates.hpp"
#include "kinematics/couplings.hpp"
#include "kinematics/curves/overlap.hpp"
#include "kinematics/loads.hpp"

namespace mbproj {

template <class D> class EquationsOfMotion final : public Equations {
public:
    using S = Size<D>;

    EquationsOfMotion(const Model<D>& model, const ProjectionSettings& projection)
        : Equations(model), model_(model), projection_(projection), pose_(model), motion_(model), seen_pose_(model),
          seen_motion_(model), solver_(model, projection.penalty()), policy_(model, solver_), gamma_(model.all_rows()),
          C_(model.all_rows()), C_dot_(model.all_rows()), drive_(model), applied_(model), bearings_(model),
          contacts_(model, pose_, motion_, solver_), couplings_(model), expected_(model.layout.followed.size),
          channels_(model), states_(model) {}

    const Programs& programs() const override { return model_.programs; }
    int law_count() const override { return model_.loads ? static_cast<int>(model_.loads->laws.size()) : 0; }
    int force_count() const override { return model_.loads ? model_.loads->size() : 0; }
    int bearing_count() const override { return static_cast<int>(model_.bearings.size()); }
    int program_of(int law) const override { return model_.loads->laws[law].program; }

    bool derivative(double t, const double* y, double* slope, double* lambda = nullptr) override {
        return factor_stage(t, y) && slope_of_stage(y, slope, lambda);
    }
    bool watched_derivative(double t, const double* y, double* slope, double* lambda = nullptr) override {
        if (!factor_stage(t, y)) return false;
        policy_.record_pose();
        return !policy_.wants_others(pose_) && slope_of_stage(y, slope, lambda, true);
    }
    bool own_derivative(double t, const double* y, double* slope, double* lambda) override {
        return factor_stage(t, y) && (set_velocities(y, false), own_slope_at(y, slope, lambda));
    }

    void set_velocities(const double* y, bool with_C_dot) override {
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

    bool slope_at(const double* y, double* slope, double* lambda = nullptr, bool watched = false) override {
        if (!own_slope_at(y, slope, lambda)) return false;
        return !other_ || metric_ == Metric::stiff || other_slope_at(y, slope, lambda, watched);
    }
    bool own_slope_at(const double* y, double* slope, double* lambda = nullptr) override {
        if (bearings_.any() || contacts_.has_feet()) unload();
        if (contacts_.any() && !(contacts_.factor() && contacts_.cholesky().full())) return false;
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

    void set_pose(double t, const double* y) override {
        pose_.update(y);
        const Block& followed = layout().followed;
        if (followed.size) std::copy(y + followed.first, y + followed.end(), expected_.begin());
        factored_ = known_ = false;
        if (t == t_ && !broken_) return;
        t_ = t;
        broken_ = !drive_.set(t, window_);
    }
    void set_window(const TimeWindow& window) override {
        window_ = window, known_ = false, broken_ = !drive_.set(t_, window_);
    }
    void set_pose(const double* y) { set_pose(t_, y); }  // at the same time
    bool factor(Metric metric) override {
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
    bool start() override {
        const bool usual = policy_.holds_usual();
        return factored_with_masses(usual ? policy_.settle(pose_, factor(Metric::mass)) : policy_.start(pose_));
    }
    bool wants_others() const { return policy_.wants_others(pose_); }
    bool hold_others() override {
        if (held_ && !wants_others()) return false;
        return factored_with_masses(policy_.hold_others(pose_));
    }
    bool is_near_singular() override { return solver_.is_near_singular(pose_, model_.thresholds.near_branch); }
    // Whether there is a factor in this metric, which may belong to an earlier pose.
    bool holds(Metric metric) const { return held_ && metric == metric_; }
    const double* constraint() override {
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
    const double* C_dot() const override { return C_dot_.data(); }

    void start_teeth() override { couplings_.start(pose_, expected_, constraint()), known_ = false; }
    JointAngle<double> angle(int coordinate) const override { return joint_angle(model_, pose_, motion_, coordinate); }
    double prescribed(std::size_t k) const override { return drive_.prescribed(k); }
    // The values that motions prescribe at this time.
    const Drive<D>& drive() const { return drive_; }
    int jammed() const override { return contacts_.jammed() < 0 ? bearings_.jammed() : contacts_.jammed(); }
    const Model<D>& model() const { return model_; }
    Pose<D>& pose() { return pose_; }
    const Pose<D>& pose() const { return pose_; }
    const Motion<D>& motion() const { return motion_; }
    Applied<D>& applied() { return applied_; }
    ActingLaws& acting_laws() override { return applied_; }
    // The variables of programs at the state in place, which is y, at t.
    Channels<D>& set_channels(double t, const double* y) { return channels_.set(t, y, pose_, motion_); }
    // The variables at t inside the window; and the variables of the last evaluation.
    Channels<D>& channels_at(double t, const double* y) { return set_channels(window_.clamped(t), y); }
    Channels<D>& channels() { return channels_; }
    StateRates<D>& states() { return states_; }
    void hold(const double* branches) override { applied_.held = states_.held = pose_.held = branches; }
    KktSolver<D>& solver() { return solver_; }
    const KktSolver<D>& solver() const { return solver_; }
    RowPolicy<D>& policy() { return policy_; }
    void begin_step() override { policy_.begin(); }
    const Passed& passed() const override { return policy_.passed(); }
    long factorisations() const override { return solver_.factorisations(); }
    int singular_joint() const override { return solver_.singular_joint(); }
    bool is_finite() const override { return pose_.finite(); }
    const std::vector<int>& left_out() const override { return solver_.left_out(); }
    long close_looks() const override { return solver_.close_looks(); }
    std::size_t loop_joint_count() const override { return solver_.order().loop_joints.size(); }
    ContactBorder<D>& contacts() override { return contacts_; }
    void hold_contacts(std::vector<ContactRow> rows, std::vector<SlidingRow> slides = {},
                       std::vector<ContactFoot> feet = {}) override {
        applied_.touch(rows);
        contacts_.hold(std::move(rows), std::move(slides), std::move(feet));
        std::fill(lambda_.begin() + model_.all_rows(), lambda_.end(), 0.0);
    }
    std::unique_ptr<Border> border() override {
        return std::make_unique<ContactBorder<D>>(model_, pose_, motion_, solver_);
    }

    std::optional<std::pair<int, RopeTrouble>> off_rope() const override {
        for (int c = 0; c < model_.coordinate_count(); ++c) {
            if (model_.coordinates.instances[c].kind != Kind::rope) continue;
            const Coordinate<D> rope(model_.coordinates, c, pose_);
            if (const RopeTrouble found = on_rope::trouble<D>(rope.p, rope.x, model_.thresholds))
                return std::make_pair(c, found);
        }
        return std::nullopt;
    }
    std::optional<std::pair<int, int>> overlap() const override {
        for (const PrimitiveSet<D>* set : {&model_.constraints, &model_.coordinates})
            for (int k = 0; k < static_cast<int>(set->instances.size()); ++k) {
                if (set->instances[k].kind != Kind::two_curves) continue;
                const Coordinate<D> distance(*set, k, pose_);
                if (overlaps<D>(distance.p, distance.x, model_.thresholds.overlap))
                    return set == &model_.constraints ? std::make_pair(distance.p.row, -1) : std::make_pair(-1, k);
            }
        return std::nullopt;
    }

    const Series<double>* variables_at(double t, const double* y) override { return channels_at(t, y).variables(); }
    void change_states(const double* y) override { channels_.set_states(y); }
    double given(int program, double rate = 0.0) override {
        return model_.programs.value(program, channels_.variables(0.0, rate), applied_.held);
    }
    void switch_arguments(double t, const double* y, const double* branches, std::vector<double>& found) override {
        applied_.switch_arguments(model_, pose_, motion_, channels_at(t, y), branches, found);
    }

    ValueAndRate at_stop(int number) const override { return at_stop(number, pose_, motion_); }
    void look(const double* y) override {
        seen_pose_.update(y);
        seen_motion_.update(y, seen_pose_);
    }
    ValueAndRate seen_at_stop(int number) const override { return at_stop(number, seen_pose_, seen_motion_); }
    bool is_angle_at_stop(int number) const override {
        return is_angle(model_.stop_coordinates.instances[number].kind);
    }

    Supports supports(int bearing, const double* lambda) const override {
        return supports_of(model_, pose_, model_.bearings[bearing], lambda);
    }
    using Equations::load;
    double load(int bearing, const Supports& carried) const override { return carried.load(model_.bearings[bearing]); }
    double preload(int bearing) const override { return model_.bearings[bearing].preload; }
    double arm(int bearing) const override {
        return std::max(model_.bearings[bearing].radial, model_.bearings[bearing].axial);
    }
    double borne(const Joint& joint, const double* lambda) const override {
        Matrix<6, S::freedoms> G;
        jacobian<D>(model_, pose_, joint, joint.bodies.front(), G);
        Column<S::freedoms> wrench = Column<S::freedoms>::Zero();
        for (int r = 0; r < joint.rows; ++r) wrench += lambda[joint.row + r] * G.row(r).transpose();
        return wrench.template head<D::axes>().norm() * model_.length + wrench.template tail<S::turns>().norm();
    }

    double fastest_part(const Vector& y) const override {
        double shift = 0.0, turn = 0.0;
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> part(y.data(), b);
            for (int i = 0; i < D::axes; ++i) shift = std::max(shift, std::abs(part.velocity()[i]));
            for (int i = 0; i < S::turns; ++i) turn = std::max(turn, std::abs(part.omega()[i]));
        }
        return shift / model_.length + turn;
    }
    // Flywheels have rows after those of C.
    double kinetic_energy(const Vector& y) const override {
        double sum = 0.0;
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> part(y.data(), b);
            const Turn<D> omega = part.omega();
            sum += model_.bodies[b].mass * part.velocity().squaredNorm() + omega.dot(model_.bodies[b].inertia * omega);
        }
        if (model_.flywheels.empty()) return 0.5 * sum;
        Motion<D> motion(model_);
        motion.update(y.data(), pose_);
        std::vector<double> rates(model_.all_rows());
        moving_rows(model_, pose_, motion, rates.data(), static_cast<double*>(nullptr));
        for (std::size_t k = 0; k < model_.flywheels.size(); ++k)
            sum += model_.flywheels[k] * std::pow(rates[model_.constraints.rows + k], 2);
        return 0.5 * sum;
    }
    void add_velocities(Vector& y) const override {
        for (int b = 0; b < model_.size(); ++b) {
            WritablePart<D> part(y.data(), b);
            part.velocity() += solver_.shift(b);
            part.omega() += to_body(pose_[b].rotation, solver_.turn(b));
        }
    }
    double distance(const Vector& x, const Vector& y, double h) const override {
        const double length = model_.length;
        double way = 0.0, change = 0.0, speed = 0.0;  // squares
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> a(y.data(), b), e(x.data(), b);
            way += (a.position() - e.position()).squaredNorm() + 0.5 * length * length * turned_between(a, e);
            change +=
                (a.velocity() - e.velocity()).squaredNorm() + length * length * (a.omega() - e.omega()).squaredNorm();
            speed += std::max(a.velocity().squaredNorm(), e.velocity().squaredNorm()) +
                     length * length * std::max(a.omega().squaredNorm(), e.omega().squaredNorm());
        }
        if (std::sqrt(speed) * h <= model_.thresholds.at_rest * length) return 0.0;
        return std::sqrt(std::max(way / (h * h), change) / speed);
    }

private:
    ValueAndRate at_stop(int number, const Pose<D>& pose, const Motion<D>& motion) const {
        const Coordinate<D> along(model_.stop_coordinates, number, pose);
        return {along.value(), along.rate(motion)};
    }
    // 2 |δθ|² of a small rotation between two poses.
    static double turned_between(const Part<D>& a, const Part<D>& b) {
        using Orientation = Column<S::orientation>;
        return (rotation(Orientation(a.orientation())) - rotation(Orientation(b.orientation()))).squaredNorm();
    }
    // Replaces the accelerations in the slope of the state in place by those of another formulation.
    bool other_slope_at(const double* y, double* slope, double* lambda, bool watched) {
        std::vector<double> forces(model_.stops.bound.size(), 0.0);
        contacts_.write_sliding_forces(applied_, forces.data());
        if (!other_->accelerate(asked(y), forces, watched, slope, lambda_.data())) return false;
        if (lambda) std::copy(lambda_.begin(), lambda_.end(), lambda);
        return true;
    }
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
        return bearings_.settle(applied_, solver_, contacts_, pose_, gamma_.data()) && (set_forces(y) || broken(y));
    }
    void unload() { std::fill(applied_.carried.begin(), applied_.carried.end(), 0.0), contacts_.load(applied_, false); }

    bool set_forces(const double* y) {
        if (model_.loads && !applied_.update(*model_.loads, pose_, motion_, channels_)) return false;
        mbproj::set_forces(model_, pose_, y, applied_, solver_);
        if (contacts_.gives()) contacts_.set_normals(), contacts_.pull();
        return true;
    }
    // Sets the solver's forces with those of contacts, and with the friction by their pushes.
    [[gnu::noinline, gnu::cold]] bool settle_contacts(const double* y) {
        if (!solver_.solve(gamma_.data())) return false;
        contacts_.settle(true);
        if (contacts_.has_feet() && !(contacts_.load(applied_), set_forces(y))) return broken(y);
        mbproj::set_forces(model_, pose_, y, applied_, solver_);
        contacts_.pull();
        return true;
    }
    // Adds friction at feet to the contacts' equations; the solver's forces are without it, as pushes are not known.
    [[gnu::noinline, gnu::cold]] bool add_foot_friction(const double* y) {
        if (!contacts_.add_friction(applied_)) return false;
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
    Pose<D> seen_pose_;  // of the last look beside the state in place
    Motion<D> seen_motion_;
    KktSolver<D> solver_;
    RowPolicy<D> policy_;
    std::vector<double> gamma_, C_, C_dot_;
    Drive<D> drive_;  // at t_
    Applied<D> applied_;
    BearingLoads<D> bearings_;
    ContactBorder<D> contacts_;
    Couplings<D> couplings_;
    std::vector<double> expected_;  // the joints' coordinates, followed to less than half a turn
    Channels<D> channels_;
    StateRates<D> states_;
    bool factored_ = false, held_ = false;
    bool known_ = false;  // whether C belongs to the pose in place
    Metric metric_ = Metric::mass;
};

}  // namespace mbproj
