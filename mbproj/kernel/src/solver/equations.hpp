// The equations of motion as steps, contacts and runs see them: states are numbers y, and no dimension shows.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "kinematics/acting_laws.hpp"
#include "kinematics/angle.hpp"
#include "kinematics/supports.hpp"
#include "model/mechanism.hpp"
#include "model/rope_path.hpp"
#include "model/settings.hpp"
#include "solver/border.hpp"
#include "solver/formulation.hpp"
#include "solver/metric.hpp"

namespace mbproj {

// The smallest and the largest pivot of S over the poses of a step, in parts of the usual one; 0 where rows were left out.
struct Passed {
    double smallest = 1.0, largest = 0.0;
    void record(double nearness) {
        smallest = std::min(smallest, nearness);
        largest = std::max(largest, nearness);
    }
};

struct ValueAndRate {
    double value, rate;
};

// All quantities at one state, the state in place; evaluations overwrite this scratch.
class Equations {
public:
    using Vector = Eigen::VectorXd;

    Equations(const Equations&) = delete;
    Equations& operator=(const Equations&) = delete;
    virtual ~Equations() = default;
    const Mechanism& mechanism() const { return mechanism_; }
    // The layout of y.
    const Layout& layout() const { return mechanism_.layout; }
    virtual const Programs& programs() const = 0;
    // The number of laws of forces, of all coordinates along which forces act, and of bearings.
    virtual int law_count() const = 0;
    virtual int force_count() const = 0;
    virtual int bearing_count() const = 0;
    virtual int program_of(int law) const = 0;

    // y' at a state, with the rows that are held. Equal input has equal bits, whatever was evaluated before. False where the
    // equations have no unique solution, or a function has no value: see `broken`.
    virtual bool derivative(double t, const double* y, double* slope, double* lambda = nullptr) = 0;
    // `derivative` at a stage of a step: the row policy records how near the pose is to a singular one. False also
    // where other rows would serve: see `hold_others`.
    virtual bool watched_derivative(double t, const double* y, double* slope, double* lambda = nullptr) = 0;
    // `derivative` by the kernel alone, without another formulation.
    virtual bool own_derivative(double t, const double* y, double* slope, double* lambda) = 0;
    // y' with the pose in place and factored with the masses, and the velocities in place; multipliers on request.
    virtual bool slope_at(const double* y, double* slope, double* lambda = nullptr, bool watched = false) = 0;
    virtual bool own_slope_at(const double* y, double* slope, double* lambda = nullptr) = 0;

    // Sets a state at a time; then its velocities, with their right-hand sides, and C' on request.
    virtual void set_pose(double t, const double* y) = 0;
    virtual void set_velocities(const double* y, bool with_C_dot) = 0;
    // From now on functions of time are evaluated inside this window.
    virtual void set_window(const TimeWindow& window) = 0;
    const TimeWindow& window() const { return window_; }
    double time() const { return t_; }
    virtual bool is_finite() const = 0;  // the pose

    virtual bool factor(Metric metric) = 0;
    virtual long factorisations() const = 0;
    // Chooses the rows of a step from the pose in place, which is closed. False without a unique solution there.
    virtual bool start() = 0;
    // A step is tried from the last accepted state: the poses of a rejected step do not count.
    virtual void begin_step() = 0;
    virtual const Passed& passed() const = 0;
    // Where the rows held are dependent at the pose in place, or leave no unique solution: holds others for this step. False
    // where there are none.
    virtual bool hold_others() = 0;
    // Whether the pose in place is near a singular one.
    virtual bool is_near_singular() = 0;
    virtual int singular_joint() const = 0;
    // The rows left out now, the number of searches for dependent rows or a singular pose, and that of the loops' joints.
    virtual const std::vector<int>& left_out() const = 0;
    virtual long close_looks() const = 0;
    virtual std::size_t loop_joint_count() const = 0;
    // The law of a friction that leaves no unique solution at the last state, or -1.
    virtual int jammed() const = 0;
    virtual const double* constraint() = 0;
    // C' of the last `set_velocities`.
    virtual const double* C_dot() const = 0;
    double* multipliers() { return lambda_.data(); }  // of the last slope
    // Gears and screws count from the teeth that are in mesh now.
    virtual void start_teeth() = 0;
    // A coordinate that is an angle, in the state in place.
    virtual JointAngle<double> angle(int coordinate) const = 0;
    // The value that motion k prescribes at this time.
    virtual double prescribed(std::size_t k) const = 0;
    // The rope that has left its path; and the row of two curves that overlap, or -1 with the number of their coordinate.
    virtual std::optional<std::pair<int, RopeTrouble>> off_rope() const = 0;
    virtual std::optional<std::pair<int, int>> overlap() const = 0;

    // The variables of programs at the state in place, which is y, at t inside the window; they change with states alone.
    virtual const Series<double>* variables_at(double t, const double* y) = 0;
    virtual void change_states(const double* y) = 0;
    // The value of a program at these variables, along a coordinate with this rate.
    virtual double given(int program, double rate = 0.0) = 0;
    // The arguments of the model's switches at the state in place, which is y, on these branches, or on free ones.
    virtual void switch_arguments(double t, const double* y, const double* branches, std::vector<double>& found) = 0;
    // Programs are on these branches from now on.
    virtual void hold(const double* branches) = 0;
    virtual ActingLaws& acting_laws() = 0;

    // The state, at `time`, at which a function of the scene had no finite value; empty where none failed.
    const std::vector<double>& broken_state() const { return broken_state_; }
    bool broken(const double* y) {
        broken_ = true;
        broken_state_.assign(y, y + layout().size());
        return false;
    }
    void forget_broken_state() { broken_state_.clear(); }

    void follow(Formulation* other) { other_ = other; }  // makes accelerations and projections from now on
    Formulation* other() const { return other_; }
    // The state in place, whose numbers are y.
    AskedState asked(const double* y) {
        return {t_, y, window_, acting_laws().held, contacts().any() ? contacts().rows() : std::vector<ContactRow>()};
    }

    virtual std::unique_ptr<Border> border() = 0;
    // The rows that contacts hold; `hold_contacts` sets them, and those that slide: their forces follow the rows' multipliers.
    virtual Border& contacts() = 0;
    virtual void hold_contacts(std::vector<ContactRow> rows, std::vector<SlidingRow> slides = {},
                               std::vector<ContactFoot> feet = {}) = 0;
    // A coordinate of stops and frictions, in the state in place; or in one beside it, that of the last `look`.
    virtual ValueAndRate at_stop(int number) const = 0;
    virtual void look(const double* y) = 0;
    virtual ValueAndRate seen_at_stop(int number) const = 0;
    virtual bool is_angle_at_stop(int number) const = 0;

    // Of bearings with these multipliers: the forces on the supports, and the load, without the preload, and with it.
    virtual Supports supports(int bearing, const double* lambda) const = 0;
    virtual double load(int bearing, const Supports& carried) const = 0;
    virtual double preload(int bearing) const = 0;
    double load(int bearing, const double* lambda) const {
        return preload(bearing) + load(bearing, supports(bearing, lambda));
    }
    // How much of a force a bearing's load may be.
    virtual double arm(int bearing) const = 0;
    // The force and moment, in lengths of the mechanism, that a joint bears with these multipliers.
    virtual double borne(const Joint& joint, const double* lambda) const = 0;

    // The speed of the fastest part at y, in lengths of the mechanism and rad per s.
    virtual double fastest_part(const Vector& y) const = 0;
    // The kinetic energy at y, with its pose in place.
    virtual double kinetic_energy(const Vector& y) const = 0;
    // Adds the velocities that the solver has found for impulses.
    virtual void add_velocities(Vector& y) const = 0;
    // The distance of two states, as a part of the velocity or of the way made in a step.
    virtual double distance(const Vector& x, const Vector& y, double h) const = 0;

protected:
    explicit Equations(const Mechanism& mechanism) : mechanism_(mechanism), lambda_(mechanism.all_multipliers()) {}

    const Mechanism& mechanism_;
    std::vector<double> lambda_, broken_state_;
    TimeWindow window_;
    double t_ = std::numeric_limits<double>::quiet_NaN();
    bool broken_ = false;
    Formulation* other_ = nullptr;
};

}  // namespace mbproj
