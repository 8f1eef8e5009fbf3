// The Newton-Euler equations in the bodies' velocities, with the joints' multipliers: y' = f(y).
#pragma once

#include "kinematics/couplings.hpp"
#include "kinematics/curves/overlap.hpp"
#include "kinematics/loads.hpp"
#include "solver/bearing_loads.hpp"
#include "solver/body_forces.hpp"
#include "solver/drive.hpp"
#include "solver/equations.hpp"
#include "solver/row_policy.hpp"
#include "solver/row_values.hpp"
#include "solver/state_rates.hpp"

namespace mbproj {

template <class D> class EquationsOfMotion final : public Equations {
public:
    using S = Size<D>;

    EquationsOfMotion(const Model<D>& model, const ProjectionSettings& projection);
    ~EquationsOfMotion() override;
    const Programs& programs() const override { return model_.programs; }
    int law_count() const override { return model_.loads ? static_cast<int>(model_.loads->laws.size()) : 0; }
    int force_count() const override { return model_.loads ? model_.loads->size() : 0; }
    int bearing_count() const override { return static_cast<int>(model_.bearings.size()); }
    int program_of(int law) const override { return model_.loads->laws[law].program; }

    bool derivative(double t, const double* y, double* slope, double* lambda = nullptr) override;
    bool watched_derivative(double t, const double* y, double* slope, double* lambda = nullptr) override;
    bool own_derivative(double t, const double* y, double* slope, double* lambda) override;
    void set_velocities(const double* y, bool with_C_dot) override;
    bool slope_at(const double* y, double* slope, double* lambda = nullptr, bool watched = false) override;
    bool own_slope_at(const double* y, double* slope, double* lambda = nullptr) override;

    // The rates of work in the last slope at another state, with that slope's multipliers; for scenes with loads.
    bool settle_work(double t, const double* y, double* slope);
    void set_pose(double t, const double* y) override;
    void set_window(const TimeWindow& window) override;
    void set_pose(const double* y) { set_pose(t_, y); }  // at the same time
    bool factor(Metric metric) override;
    // Moments of inertia that the next factors add to the bodies', for corrections alone; empty for none.
    void stiffen(const std::vector<double>& moments) { held_ = factored_ = false, solver_.stiffen(moments); }
    // Factors with all rows, also those that are dependent at this pose alone; this factor is used once.
    bool factor_all(Metric metric);
    // Sets the stiffness of forces at the start of a step.
    void begin_stiff(double t, const double* y, double g);
    // Factors with the masses and the stiff forces of an implicit stage with this g, at the state in place, in a pass
    // of Newton's method. The rows do not change, however dependent on the compliant rows they are.
    bool factor_stiff(const double* y, double g, Pass pass);
    bool start() override;
    bool wants_others() const { return policy_.wants_others(pose_); }
    bool hold_others() override;
    bool is_near_singular() override { return solver_.is_near_singular(pose_, model_.thresholds.near_branch); }
    // Whether there is a factor in this metric, which may belong to an earlier pose.
    bool holds(Metric metric) const { return held_ && metric == metric_; }
    const double* constraint() override;
    const double* constraint_velocity(const double* y);
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
                       std::vector<ContactFoot> feet = {}) override;
    std::unique_ptr<Border> border() override;
    std::optional<std::pair<int, RopeTrouble>> off_rope() const override;
    std::optional<std::pair<int, int>> overlap() const override;
    const Series<double>* variables_at(double t, const double* y) override { return channels_at(t, y).variables(); }
    void change_states(const double* y) override { channels_.set_states(y); }
    double given(int program, double rate = 0.0) override;
    void switch_arguments(double t, const double* y, const double* branches, std::vector<double>& found) override;
    ValueAndRate at_stop(int number) const override { return at_stop(number, pose_, motion_); }
    void look(const double* y) override;
    ValueAndRate seen_at_stop(int number) const override { return at_stop(number, seen_pose_, seen_motion_); }
    bool is_angle_at_stop(int number) const override;
    Supports supports(int bearing, const double* lambda) const override;
    using Equations::load;
    double load(int bearing, const Supports& carried) const override { return carried.load(model_.bearings[bearing]); }
    double preload(int bearing) const override { return model_.bearings[bearing].preload; }
    double arm(int bearing) const override;
    double borne(const Joint& joint, const double* lambda) const override;
    double fastest_part(const Vector& y) const override;
    // Flywheels have rows after those of C.
    double kinetic_energy(const Vector& y) const override;
    void add_velocities(Vector& y) const override;
    double distance(const Vector& x, const Vector& y, double h) const override;

private:
    ValueAndRate at_stop(int number, const Pose<D>& pose, const Motion<D>& motion) const;
    // 2 |δθ|² of a small rotation between two poses.
    static double turned_between(const Part<D>& a, const Part<D>& b);
    // Replaces the accelerations in the slope of the state in place by those of another formulation.
    bool other_slope_at(const double* y, double* slope, double* lambda, bool watched);
    bool factored_with_masses(bool found) { return metric_ = Metric::mass, held_ = factored_ = found; }
    bool factor_stage(double t, const double* y);
    bool slope_of_stage(const double* y, double* slope, double* lambda = nullptr, bool watched = false);
    bool factor_for_violation(const double* y);

    // From here on friction that depends on bearing loads is included.
    bool settle_bearings(const double* y);
    void unload() { std::fill(applied_.carried.begin(), applied_.carried.end(), 0.0), contacts_.load(applied_, false); }

    bool set_forces(const double* y);
    // Sets the solver's forces with those of contacts, and with the friction by their pushes.
    [[gnu::noinline, gnu::cold]] bool settle_contacts(const double* y);
    // Adds friction at feet to the contacts' equations; the solver's forces are without it, as pushes are not known.
    [[gnu::noinline, gnu::cold]] bool add_foot_friction(const double* y);

    // Baumgarte (ref. 9): C'' + 2α C' + β² C = 0.
    void stabilise();

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
    std::vector<int> ropes_;                                               // coordinates
    std::vector<std::pair<const PrimitiveSet<D>*, int>> pairs_of_curves_;  // their sets, and places there
    bool factored_ = false, held_ = false;
    bool known_ = false;  // whether C belongs to the pose in place
    Metric metric_ = Metric::mass;
};

extern template class EquationsOfMotion<Plane<double>>;
extern template class EquationsOfMotion<Space<double>>;

}  // namespace mbproj
