#include "solver/equations_of_motion.hpp"

namespace mbproj {

template <class D> EquationsOfMotion<D>::EquationsOfMotion(const Model<D>& model, const ProjectionSettings& projection)
    : Equations(model), model_(model), projection_(projection), pose_(model), motion_(model), seen_pose_(model),
      seen_motion_(model), solver_(model, projection.penalty()), policy_(model, solver_), gamma_(model.all_rows()),
      C_(model.all_rows()), C_dot_(model.all_rows()), drive_(model), applied_(model), bearings_(model),
      contacts_(model, pose_, motion_, solver_), couplings_(model), expected_(model.layout.followed.size),
      channels_(model), states_(model) {
    for (int c = 0; c < model.coordinate_count(); ++c)
        if (model.coordinates.instances[c].kind == Kind::rope) ropes_.push_back(c);
    for (const PrimitiveSet<D>* set : {&model.constraints, &model.coordinates})
        for (int k = 0; k < static_cast<int>(set->instances.size()); ++k)
            if (set->instances[k].kind == Kind::two_curves) pairs_of_curves_.emplace_back(set, k);
}

template <class D> bool EquationsOfMotion<D>::derivative(double t, const double* y, double* slope, double* lambda) {
    return factor_stage(t, y) && slope_of_stage(y, slope, lambda);
}

template <class D>
bool EquationsOfMotion<D>::watched_derivative(double t, const double* y, double* slope, double* lambda) {
    if (!factor_stage(t, y)) return false;
    policy_.record_pose();
    return !policy_.wants_others(pose_) && slope_of_stage(y, slope, lambda, true);
}

template <class D> bool EquationsOfMotion<D>::own_derivative(double t, const double* y, double* slope, double* lambda) {
    return factor_stage(t, y) && (set_velocities(y, false), own_slope_at(y, slope, lambda));
}

template <class D> void EquationsOfMotion<D>::set_velocities(const double* y, bool with_C_dot) {
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

template <class D> bool EquationsOfMotion<D>::slope_at(const double* y, double* slope, double* lambda, bool watched) {
    if (!own_slope_at(y, slope, lambda)) return false;
    return !other_ || metric_ == Metric::stiff || other_slope_at(y, slope, lambda, watched);
}

template <class D> bool EquationsOfMotion<D>::own_slope_at(const double* y, double* slope, double* lambda) {
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

template <class D> bool EquationsOfMotion<D>::settle_work(double t, const double* y, double* slope) {
    set_pose(t, y);
    motion_.update(y, pose_);
    const bool done = applied_.update(*model_.loads, pose_, motion_, set_channels(window_.clamped(t_), y));
    set_work(layout().quadratures, applied_, drive_, lambda_.data(), slope);
    return done || broken(y);
}

template <class D> void EquationsOfMotion<D>::set_pose(double t, const double* y) {
    pose_.update(y);
    const Block& followed = layout().followed;
    if (followed.size) std::copy(y + followed.first, y + followed.end(), expected_.begin());
    factored_ = known_ = false;
    if (t == t_ && !broken_) return;
    t_ = t;
    broken_ = !drive_.set(t, window_);
}

template <class D> void EquationsOfMotion<D>::set_window(const TimeWindow& window) {
    window_ = window, known_ = false, broken_ = !drive_.set(t_, window_);
}

template <class D> bool EquationsOfMotion<D>::factor(Metric metric) {
    if (factored_ && metric == metric_) return true;
    metric_ = metric;
    return held_ = factored_ = solver_.factor(pose_, metric);
}

template <class D> bool EquationsOfMotion<D>::factor_all(Metric metric) {
    held_ = factored_ = false;
    return solver_.factor(pose_, metric, 0.0);
}

template <class D> void EquationsOfMotion<D>::begin_stiff(double t, const double* y, double g) {
    unload();
    set_pose(t, y);
    set_velocities(y, false);
    solver_.compliance().set(applied_, pose_, motion_, set_channels(window_.clamped(t_), y), g, {0, 0});
}

template <class D> bool EquationsOfMotion<D>::factor_stiff(const double* y, double g, Pass pass) {
    metric_ = Metric::stiff;
    solver_.compliance().set(applied_, pose_, motion_, set_channels(window_.clamped(t_), y), g, pass);
    return held_ = factored_ = solver_.factor(pose_, Metric::stiff, 0.0);
}

template <class D> bool EquationsOfMotion<D>::start() {
    const bool usual = policy_.holds_usual();
    return factored_with_masses(usual ? policy_.settle(pose_, factor(Metric::mass)) : policy_.start(pose_));
}

template <class D> bool EquationsOfMotion<D>::hold_others() {
    if (held_ && !wants_others()) return false;
    return factored_with_masses(policy_.hold_others(pose_));
}

template <class D> const double* EquationsOfMotion<D>::constraint() {
    if (std::exchange(known_, true)) return C_.data();
    mbproj::constraint(model_, pose_, C_.data());
    leave_flywheels(model_, C_);
    couplings_.count(pose_, expected_, C_.data());
    drive_.close(C_.data());
    return C_.data();
}

template <class D> const double* EquationsOfMotion<D>::constraint_velocity(const double* y) {
    motion_.update(y, pose_);
    moving_rows(model_, pose_, motion_, C_dot_.data(), static_cast<double*>(nullptr));
    leave_flywheels(model_, C_dot_);
    for (std::size_t k = 0; k < drive_.size(); ++k) C_dot_[model_.driven[k].row] -= drive_[k].d;
    return C_dot_.data();
}

template <class D> void EquationsOfMotion<D>::hold_contacts(std::vector<ContactRow> rows,
                                                            std::vector<SlidingRow> slides,
                                                            std::vector<ContactFoot> feet) {
    applied_.touch(rows);
    contacts_.hold(std::move(rows), std::move(slides), std::move(feet));
    std::fill(lambda_.begin() + model_.all_rows(), lambda_.end(), 0.0);
}

template <class D> std::unique_ptr<Border> EquationsOfMotion<D>::border() {
    return std::make_unique<ContactBorder<D>>(model_, pose_, motion_, solver_);
}

template <class D> std::optional<std::pair<int, RopeTrouble>> EquationsOfMotion<D>::off_rope() const {
    for (const int c : ropes_) {
        const Coordinate<D> rope(model_.coordinates, c, pose_);
        if (const RopeTrouble found = on_rope::trouble<D>(rope.p, rope.x, model_.thresholds))
            return std::make_pair(c, found);
    }
    return std::nullopt;
}

template <class D> std::optional<std::pair<int, int>> EquationsOfMotion<D>::overlap() const {
    for (const auto& [set, k] : pairs_of_curves_) {
        const Coordinate<D> distance(*set, k, pose_);
        if (overlaps<D>(distance.p, distance.x, model_.thresholds.overlap))
            return set == &model_.constraints ? std::make_pair(distance.p.row, -1) : std::make_pair(-1, k);
    }
    return std::nullopt;
}

template <class D> double EquationsOfMotion<D>::given(int program, double rate) {
    return model_.programs.value(program, channels_.variables(0.0, rate), applied_.held);
}

template <class D> void EquationsOfMotion<D>::switch_arguments(double t, const double* y, const double* branches,
                                                               std::vector<double>& found) {
    applied_.switch_arguments(model_, pose_, motion_, channels_at(t, y), branches, found);
}

template <class D> void EquationsOfMotion<D>::look(const double* y) {
    seen_pose_.update(y);
    seen_motion_.update(y, seen_pose_);
}

template <class D> bool EquationsOfMotion<D>::is_angle_at_stop(int number) const {
    return is_angle(model_.stop_coordinates.instances[number].kind);
}

template <class D> Supports EquationsOfMotion<D>::supports(int bearing, const double* lambda) const {
    return supports_of(model_, pose_, model_.bearings[bearing], lambda);
}

template <class D> double EquationsOfMotion<D>::arm(int bearing) const {
    return std::max(model_.bearings[bearing].radial, model_.bearings[bearing].axial);
}

template <class D> double EquationsOfMotion<D>::borne(const Joint& joint, const double* lambda) const {
    Matrix<6, S::freedoms> G;
    jacobian<D>(model_, pose_, joint, joint.bodies.front(), G);
    Column<S::freedoms> wrench = Column<S::freedoms>::Zero();
    for (int r = 0; r < joint.rows; ++r) wrench += lambda[joint.row + r] * G.row(r).transpose();
    return wrench.template head<D::axes>().norm() * model_.length + wrench.template tail<S::turns>().norm();
}

template <class D> double EquationsOfMotion<D>::fastest_part(const Vector& y) const {
    double shift = 0.0, turn = 0.0;
    for (int b = 0; b < model_.size(); ++b) {
        const Part<D> part(y.data(), b);
        for (int i = 0; i < D::axes; ++i) shift = std::max(shift, std::abs(part.velocity()[i]));
        for (int i = 0; i < S::turns; ++i) turn = std::max(turn, std::abs(part.omega()[i]));
    }
    return shift / model_.length + turn;
}

template <class D> double EquationsOfMotion<D>::kinetic_energy(const Vector& y) const {
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

template <class D> void EquationsOfMotion<D>::add_velocities(Vector& y) const {
    for (int b = 0; b < model_.size(); ++b) {
        WritablePart<D> part(y.data(), b);
        part.velocity() += solver_.shift(b);
        part.omega() += to_body(pose_[b].rotation, solver_.turn(b));
    }
}

template <class D> double EquationsOfMotion<D>::distance(const Vector& x, const Vector& y, double h) const {
    const double length = model_.length;
    double way = 0.0, change = 0.0, speed = 0.0;  // squares
    for (int b = 0; b < model_.size(); ++b) {
        const Part<D> a(y.data(), b), e(x.data(), b);
        way += (a.position() - e.position()).squaredNorm() + 0.5 * length * length * turned_between(a, e);
        change += (a.velocity() - e.velocity()).squaredNorm() + length * length * (a.omega() - e.omega()).squaredNorm();
        speed += std::max(a.velocity().squaredNorm(), e.velocity().squaredNorm()) +
                 length * length * std::max(a.omega().squaredNorm(), e.omega().squaredNorm());
    }
    if (std::sqrt(speed) * h <= model_.thresholds.at_rest * length) return 0.0;
    return std::sqrt(std::max(way / (h * h), change) / speed);
}

template <class D>
ValueAndRate EquationsOfMotion<D>::at_stop(int number, const Pose<D>& pose, const Motion<D>& motion) const {
    const Coordinate<D> along(model_.stop_coordinates, number, pose);
    return {along.value(), along.rate(motion)};
}

template <class D> double EquationsOfMotion<D>::turned_between(const Part<D>& a, const Part<D>& b) {
    using Orientation = Column<S::orientation>;
    return (rotation(Orientation(a.orientation())) - rotation(Orientation(b.orientation()))).squaredNorm();
}

template <class D>
bool EquationsOfMotion<D>::other_slope_at(const double* y, double* slope, double* lambda, bool watched) {
    std::vector<double> forces(model_.stops.bound.size(), 0.0);
    contacts_.write_sliding_forces(applied_, forces.data());
    if (!other_->accelerate(asked(y), forces, watched, slope, lambda_.data())) return false;
    if (lambda) std::copy(lambda_.begin(), lambda_.end(), lambda);
    return true;
}

template <class D> bool EquationsOfMotion<D>::factor_stage(double t, const double* y) {
    set_pose(t, y);
    return factor(Metric::mass) && factor_for_violation(y);
}

template <class D>
bool EquationsOfMotion<D>::slope_of_stage(const double* y, double* slope, double* lambda, bool watched) {
    set_velocities(y, false);
    return slope_at(y, slope, lambda, watched);
}

template <class D> bool EquationsOfMotion<D>::factor_for_violation(const double* y) {
    if (solver_.nearness() >= model_.thresholds.near_branch) return true;
    constraint();
    constraint_velocity(y);
    return held_ = factored_ = policy_.factor_for_violation(pose_, C_, C_dot_, time_scale(model_, y));
}

template <class D> bool EquationsOfMotion<D>::settle_bearings(const double* y) {
    return bearings_.settle(applied_, solver_, contacts_, pose_, gamma_.data()) && (set_forces(y) || broken(y));
}

template <class D> bool EquationsOfMotion<D>::set_forces(const double* y) {
    if (model_.loads && !applied_.update(*model_.loads, pose_, motion_, channels_)) return false;
    mbproj::set_forces(model_, pose_, y, applied_, solver_);
    if (contacts_.gives()) contacts_.set_normals(), contacts_.pull();
    return true;
}

template <class D> bool EquationsOfMotion<D>::settle_contacts(const double* y) {
    if (!solver_.solve(gamma_.data())) return false;
    contacts_.settle(true);
    if (contacts_.has_feet() && !(contacts_.load(applied_), set_forces(y))) return broken(y);
    mbproj::set_forces(model_, pose_, y, applied_, solver_);
    contacts_.pull();
    return true;
}

template <class D> bool EquationsOfMotion<D>::add_foot_friction(const double* y) {
    if (!contacts_.add_friction(applied_)) return false;
    return mbproj::set_forces(model_, pose_, y, applied_, solver_), true;
}

template <class D> void EquationsOfMotion<D>::stabilise() {
    const double* C = constraint();
    for (std::size_t r = 0; r < gamma_.size(); ++r)
        gamma_[r] -= 2.0 * projection_.alpha * C_dot_[r] + projection_.beta * projection_.beta * C[r];
}

template <class D> EquationsOfMotion<D>::~EquationsOfMotion() = default;

template class ContactBorder<Plane<double>>;
template class ContactBorder<Space<double>>;
template class EquationsOfMotion<Plane<double>>;
template class EquationsOfMotion<Space<double>>;

}  // namespace mbproj
