// The equations of motion of several cases at once, and their joints' rows: what `EquationsOfMotion` is for one case, without
// contacts, bearings and implicit stages. A lane for which anything else would have to be done leaves.
#pragma once

#include "dynamics/body_forces.hpp"
#include "dynamics/drive.hpp"
#include "dynamics/row_values.hpp"
#include "dynamics/state_rates.hpp"
#include "ensembles/packed_model.hpp"
#include "ensembles/packed_refinement.hpp"
#include "kinematics/couplings.hpp"

namespace mbproj {

// A count of each lane.
struct LaneCounts {
    long of[pack_width] = {};
    void add(const Mask& lanes) {
        for (int k = 0; k < pack_width; ++k) of[k] += lanes[k];
    }
};

template <class P> class PackedEquations final {
public:
    using S = Size<P>;

    explicit PackedEquations(const Model<P>& model)
        : model_(model), pose_(model), motion_(model), solver_(model, std::nullopt), drive_(model), applied_(model),
          couplings_(model), channels_(model), states_(model), expected_(model.layout.followed.size),
          gamma_(model.all_rows()), C_(model.all_rows()), C_dot_(model.all_rows()), lambda_(model.all_multipliers()) {
        solver_.leave_out(model.rows.left_out);
        usual_.assign(solver_.cholesky().pivots().size(), 1.0);
    }

    // Gives a lane to another case, with these usual pivots; 1 where they are unknown.
    void renew(int lane, const std::vector<double>& pivots) {
        const bool known = pivots.size() == usual_.size();
        for (std::size_t r = 0; r < usual_.size(); ++r) usual_[r].set(lane, known ? pivots[r] : 1.0);
        solver_.expect(usual_);
        factorisations.of[lane] = 0;
        set_window(lane, {});
    }
    // From now on a lane's functions of time are evaluated inside this window.
    void set_window(int lane, const TimeWindow& window) {
        window_.first.set(lane, window.first), window_.last.set(lane, window.last);
    }

    // y' at a state at t. Calls record(nearness) with the nearness of its pose to a singular one.
    template <class Record> void derivative(const Pack& t, const Pack* y, Pack* slope, Record&& record) {
        set_pose(t, y);
        factor(Metric::mass);
        const Pack nearness = solver_.nearness();
        Lanes::keep(is_clear(y, nearness));
        record(nearness);
        set_velocities(y, false);
        slope_at(y, slope);
    }

    void set_pose(const Pack& t, const Pack* y) {
        t_ = t;
        if (!drive_.empty() && !drive_.set(t, window_)) leave();
        set_pose(y);
    }
    void set_pose(const Pack* y) {  // at the same time
        pose_.update(y);
        const Block& followed = model_.layout.followed;
        std::copy(y + followed.first, y + followed.end(), expected_.begin());
        factored_ = false;
        known_ = false;
    }
    void set_velocities(const Pack* y, bool with_C_dot) {
        motion_.update(y, pose_);
        moving_rows(model_, pose_, motion_, with_C_dot ? C_dot_.data() : nullptr, gamma_.data());
        for (std::size_t k = 0; k < drive_.size(); ++k) {
            gamma_[model_.driven[k].row] += drive_[k].dd;
            if (with_C_dot) C_dot_[model_.driven[k].row] -= drive_[k].d;
        }
    }
    // y' with the pose in place and factored with the masses, and the velocities in place; multipliers on request.
    void slope_at(const Pack* y, Pack* slope, Pack* lambda = nullptr) {
        if (model_.loads || states_.any()) channels_.set(window_.clamped(t_), y, pose_, motion_);
        if (model_.loads && !applied_.update(*model_.loads, pose_, motion_, channels_)) return leave();
        if (states_.any() && !states_.set(channels_, slope)) return leave();
        mbproj::set_forces(model_, pose_, y, applied_, solver_);
        if (!lambda && !drive_.empty()) lambda = lambda_.data();
        if (!solver_.solve(gamma_.data(), lambda)) return leave();
        for (int b = 0; b < model_.size(); ++b) {
            const Part<P> part(y, b);
            WritablePart<P> out(slope, b);
            out.position() = part.velocity();
            out.orientation() = orientation_rate(Orientation<P>(part.orientation()), Turn<P>(part.omega()));
            out.velocity() = solver_.shift(b);
            out.omega() = to_body(pose_[b].rotation, solver_.turn(b));
        }
        set_work(model_.layout.quadratures, applied_, drive_, lambda, slope);
        const Block& followed = model_.layout.followed;
        for (int i = 0; i < followed.size; ++i)
            slope[followed.first + i] = model_.counts_turns[i] ? angle(i).speed : 0.0;
    }

    // Factors at the pose in place, unless it is factored.
    void factor(Metric metric) {
        const Mask missing = metric == metric_ ? Lanes::in() & ~factored_ : Lanes::in();
        if (missing.none()) return;
        factorisations.add(missing);
        metric_ = metric;
        held_ = solver_.factor(pose_, metric);
        if (!held_) leave();
        factored_ = Lanes::in();
    }
    // A step begins at the pose in place. Lanes in which other rows would serve leave.
    Pack start() {
        factor(Metric::mass);
        const Pack nearness = solver_.nearness();
        if (model_.rows.redundant > 0) Lanes::keep(nearness >= model_.thresholds.decline);
        return nearness;
    }
    // Whether there is a factor in this metric, be it of an earlier pose.
    bool holds(Metric metric) const { return held_ && metric == metric_; }

    const Pack* constraint() {
        if (std::exchange(known_, true)) return C_.data();
        mbproj::constraint(model_, pose_, C_.data());
        couplings_.count(pose_, expected_, C_.data());
        drive_.close(C_.data());
        return C_.data();
    }
    const Pack* constraint_velocity(const Pack* y) {
        motion_.update(y, pose_);
        moving_rows(model_, pose_, motion_, C_dot_.data(), static_cast<Pack*>(nullptr));
        for (std::size_t k = 0; k < drive_.size(); ++k) C_dot_[model_.driven[k].row] -= drive_[k].d;
        return C_dot_.data();
    }
    // Gears and screws are at the nearest tooth until `start_teeth`: lanes that are in count from the teeth in mesh.
    void forget_teeth() { teeth_ = couplings_.started(), couplings_.start_from({}), known_ = false; }
    void start_teeth() {
        couplings_.start(pose_, expected_, constraint());
        std::vector<Pack> all = couplings_.started();
        for (std::size_t c = 0; c < teeth_.size(); ++c) all[c] = where(Lanes::in(), all[c], teeth_[c]);
        couplings_.start_from(std::move(all));
        known_ = false;
    }
    const Pack* C_dot() const { return C_dot_.data(); }
    const Model<P>& model() const { return model_; }
    const Pose<P>& pose() const { return pose_; }
    JointAngle<P> angle(int coordinate) const { return joint_angle(model_, pose_, motion_, coordinate); }
    const Drive<P>& drive() const { return drive_; }
    KktSolver<P>& solver() { return solver_; }
    LaneCounts factorisations;

private:
    void leave() { Lanes::set(false); }

    // The lanes in which no row is so near to dependence that it is left out: see EquationsOfMotion::look_near.
    Mask is_clear(const Pack* y, const Pack& nearness) {
        const Mask clear = nearness >= model_.thresholds.near_branch;
        if ((Lanes::in() & ~clear).none()) return clear;
        constraint(), constraint_velocity(y);
        const Pack off = largest(model_, C_) + largest(model_, C_dot_) * time_scale(y);
        const Pack first = lane_by_lane(off, [this](double c) { return held_above(model_.thresholds, c); });
        const Mask held = clear | (nearness > first);
        if ((Lanes::in() & ~held).none()) return held;
        const OnlyLanes only(~held);
        return held | Mask(solver_.is_clear(pose_, first));
    }
    // As mbproj::time_scale, which would compare packs for all lanes alike.
    Pack time_scale(const Pack* y) const {
        const double rest = model_.thresholds.rest_rate;
        Pack speed = 0.0;
        for (int b = 0; b < model_.size(); ++b) {
            const Part<P> part(y, b);
            speed = max(max(speed, part.velocity().norm() / model_.length), part.omega().norm());
        }
        return speed / (speed * speed + rest * rest);
    }

    const Model<P>& model_;
    Pose<P> pose_;
    Motion<P> motion_;
    KktSolver<P> solver_;
    Drive<P> drive_;  // at t_
    Applied<P> applied_;
    Couplings<P> couplings_;
    Channels<P> channels_;
    StateRates<P> states_;
    TimeWindowOf<Pack> window_;
    std::vector<Pack> expected_;                            // the joints' coordinates that y follows
    std::vector<Pack> teeth_;                               // the sums from which couplings of other lanes count
    std::vector<Pack> gamma_, C_, C_dot_, lambda_, usual_;  // `usual_`: pivots
    Pack t_ = 0.0;
    Mask factored_ = false;
    bool held_ = false, known_ = false;
    Metric metric_ = Metric::mass;
};

}  // namespace mbproj
