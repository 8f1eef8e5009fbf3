#include "solver/newton_projector.hpp"

namespace mbproj {

template <class D>
NewtonProjector<D>::NewtonProjector(EquationsOfMotion<D>& equations, const ProjectionSettings& settings, Phases& phases)
    : equations_(equations), model_(equations.model()), thresholds_(model_.thresholds), settings_(settings),
      phases_(phases), trust_region_(equations), metric_(metric_of(settings.correction)),
      length2_(model_.length * model_.length) {}

template <class D> Projected NewtonProjector<D>::after_step(long step, double t, const double* before, double* y) {
    if (invariants_) invariants_->enter_step(before);
    const Projected done = close(step, t, y);
    if (invariants_ && keeps(done.velocity_passes > 0 || frees_all(step), done)) invariants_->after_step(t, y);
    return done;
}

template <class D> Projected NewtonProjector<D>::anywhere(double t, double* y) {
    const Projected done = equations_.other() ? by_other(0, t, y) : anywhere_alone(t, y);
    if (invariants_ && keeps(settings_.velocity, done)) invariants_->inside_step(t, y);
    return done;
}

template <class D> void NewtonProjector<D>::keep(bool energy, const std::vector<double>& fields, double tolerance) {
    std::vector<RigidField<D>> found(fields.size() / S::freedoms);
    for (std::size_t k = 0; k < found.size(); ++k) {
        found[k].shift = matrix_at<D::axes>(&fields[S::freedoms * k]);
        found[k].turn = matrix_at<S::turns>(&fields[S::freedoms * k + D::axes]);
    }
    invariants_ =
        std::make_unique<InvariantRows<D>>(equations_, trust_region_, metric_, energy, std::move(found), tolerance);
}

template <class D> bool NewtonProjector<D>::newton(double t, double* y) {
    equations_.set_pose(t, y);
    if (!equations_.factor(metric_)) return false;
    if (!trust_region_.solve(equations_.constraint())) return false;
    trust_region_.move(y, 1.0);
    return true;
}

template <class D> Projected NewtonProjector<D>::close(long step, double t, double* y) {
    if (equations_.other()) return by_other(step, t, y);
    normalise(y);
    equations_.set_pose(t, y);
    const bool due = closes() && step % settings_.every == 0;
    bool position = due && settings_.position, velocity = due && settings_.velocity;
    if (due && settings_.threshold >= 0.0) {
        position = position && largest(equations_.constraint()) > settings_.threshold;
        velocity = velocity && (position || largest(equations_.constraint_velocity(y)) > settings_.threshold);
    }
    // The factor of the step's last stage, at a pose nearby, is used where there is one.
    Projected done;
    done.projections = position || velocity;
    if (position) correct_position(y, done, !equations_.holds(metric_));
    phases_.mark(Phase::position);
    if (velocity && done.regular) correct_velocity(y, done);
    phases_.mark(Phase::velocity);
    // Rows that have become dependent leave some constraint open, which other rows close.
    const bool fails = !done.regular || equations_.wants_others();
    if (done.projections && fails && equations_.hold_others()) done.take(correct(y, position, velocity));
    return done;
}

template <class D> Projected NewtonProjector<D>::anywhere_alone(double t, double* y) {
    normalise(y);
    equations_.set_pose(t, y);
    const bool due = closes();
    return correct(y, due && settings_.position, due && settings_.velocity);
}

template <class D> Projected NewtonProjector<D>::by_other(long step, double t, double* y) {
    start_.assign(y, y + equations_.layout().bodies.size);
    equations_.set_pose(t, y);
    Projected done = equations_.other()->project(step, equations_.asked(y), y);
    equations_.set_pose(t, y);
    double change2 = 0.0, speed2 = 0.0;
    for (int b = 0; b < model_.size(); ++b) {
        const Part<D> before(start_.data(), b), after(y, b);
        change2 += (after.velocity() - before.velocity()).squaredNorm() +
                   length2_ * (after.omega() - before.omega()).squaredNorm();
        speed2 += before.velocity().squaredNorm() + length2_ * before.omega().squaredNorm();
    }
    done.speed_change = std::sqrt(change2);
    done.velocity_change = change2 > 0.0 ? std::sqrt(change2 / speed2) : 0.0;
    return done;
}

template <class D> Metric NewtonProjector<D>::metric_of(Correction correction) {
    if (correction == Correction::coordinates) return Metric::coordinates;
    return correction == Correction::penalty ? Metric::penalised : Metric::mass;
}

template <class D> bool NewtonProjector<D>::keeps(bool due, const Projected& done) {
    return due && done.regular && !done.failures && equations_.factor(metric_);
}

template <class D> double NewtonProjector<D>::largest(const double* rows) const {
    double most = 0.0;
    for (int r = 0; r < model_.constraints.rows; ++r) most = larger(most, std::abs(rows[r]));
    return most;
}

template <class D> void NewtonProjector<D>::normalise(double* y) const {
    for (int b = 0; b < model_.size(); ++b) {
        const auto orientation = WritablePart<D>(y, b).orientation();
        WritablePart<D>(y, b).orientation() = normalised(Column<S::orientation>(orientation));
    }
}

template <class D> Projected NewtonProjector<D>::correct(double* y, bool position, bool velocity) {
    Projected done;
    if (position) correct_position(y, done, true);
    if (velocity && done.regular) correct_velocity(y, done);
    return done;
}

template <class D> void NewtonProjector<D>::correct_position(double* y, Projected& done, bool fresh) {
    if (settings_.fallback) start_.assign(y, y + equations_.layout().bodies.size);
    settings_.paper_test ? by_paper(y, done) : by_violation(y, done, metric_, fresh);
    if (!settings_.fallback || !done.failures) return;
    std::copy(start_.begin(), start_.end(), y);
    equations_.set_pose(y);
    done.failures = 0;
    ++done.fallbacks;
    by_violation(y, done, Metric::coordinates, true);
}

template <class D> void NewtonProjector<D>::by_violation(double* y, Projected& done, Metric metric, bool fresh) {
    double left = trust_region_.scaled(equations_.constraint());
    const int most = done.position_passes + settings_.max_iterations;
    while (!meets(equations_.C())) {
        if (done.position_passes == most) return close_in_full(y, left, done, metric);
        if (fresh && !(done.regular = equations_.factor(metric))) return;
        if (!(done.regular = trust_region_.solve(equations_.C()))) return;
        ++done.position_passes;
        const double before = left;
        const bool last = fresh && may_be_round_off(equations_.C());
        if (fresh && !last ? trust_region_.damped(y, left, metric) : trust_region_.whole(y, left)) {
            fresh = !(left < thresholds_.slow * before) || !equations_.holds(metric);
        } else if (fresh) {
            return last ? void() : close_in_full(y, left, done, metric);
        } else {
            fresh = true;
        }
    }
}

template <class D> void NewtonProjector<D>::close_in_full(double* y, double left, Projected& done, Metric metric) {
    done.near_singular = equations_.solver().near_singular();
    const int most = done.position_passes + settings_.max_iterations;
    while (done.near_singular && !meets(equations_.C()) && done.position_passes < most &&
           equations_.factor_all(metric) && trust_region_.solve(equations_.C())) {
        ++done.position_passes;
        if (!trust_region_.shortened(y, left)) break;
    }
    if (!(done.near_singular && left < thresholds_.half_digits)) ++done.failures;
}

template <class D> void NewtonProjector<D>::by_paper(double* y, Projected& done) {
    const double tolerance = settings_.tolerance < 0.0 ? thresholds_.paper_tolerance : settings_.tolerance;
    for (int pass = 0; pass < settings_.max_iterations; ++pass) {
        const double* C = equations_.constraint();
        if (!(done.regular = equations_.factor(metric_) && trust_region_.solve(C))) return;
        const double change = energy() + std::inner_product(C, C + model_.constraints.rows, C, 0.0);
        trust_region_.move(y, 1.0);
        ++done.position_passes;
        if (change <= tolerance) return;
    }
    ++done.failures;
}

template <class D> void NewtonProjector<D>::correct_velocity(double* y, Projected& done) {
    const double* C_dot = equations_.constraint_velocity(y);
    if (!(done.regular = equations_.factor(metric_))) return;
    double left = largest(C_dot), change2 = 0.0, speed2 = 0.0;
    do {
        if (!(done.regular = trust_region_.solve_velocities(C_dot))) return;
        for (int b = 0; b < model_.size(); ++b) {
            const Point<D> shift = equations_.solver().shift(b);
            const Turn<D> turn = equations_.solver().turn(b);
            WritablePart<D> part(y, b);
            change2 += shift.squaredNorm() + length2_ * turn.squaredNorm();
            speed2 += part.velocity().squaredNorm() + length2_ * part.omega().squaredNorm();
            part.velocity() += shift;
            part.omega() += to_body(equations_.pose()[b].rotation, turn);
        }
        ++done.velocity_passes;
    } while (metric_ == Metric::penalised && done.velocity_passes < settings_.max_iterations && falls(y, left));
    done.velocity_change = std::sqrt(change2 / speed2);
    done.speed_change = std::sqrt(change2);
}

template <class D> bool NewtonProjector<D>::falls(double* y, double& left) {
    const double before = left;
    left = largest(equations_.constraint_velocity(y));
    return left < 0.5 * before;
}

template <class D> double NewtonProjector<D>::energy() const {
    double sum = equations_.solver().of_flywheels();
    for (int b = 0; b < model_.size(); ++b) {
        const Turn<D> local = to_body(equations_.pose()[b].rotation, equations_.solver().turn(b));
        const Body<D>& body = model_.bodies[b];
        sum += body.mass * equations_.solver().shift(b).squaredNorm() + local.dot(body.inertia * local);
    }
    return sum;
}

template <class D> bool NewtonProjector<D>::rows_meet(const double* C) const {
    const double most = largest(C);
    if (settings_.tolerance >= 0.0) return most <= settings_.tolerance;
    return most <= thresholds_.closed_to * std::min(1.0, model_.length) ||
           within(C, thresholds_.closed_grains, thresholds_.closed_to);
}

template <class D> bool NewtonProjector<D>::contacts_meet() const {
    const bool set = settings_.tolerance >= 0.0;
    return equations_.contacts().within(set ? 0.0 : thresholds_.closed_grains,
                                        set ? settings_.tolerance : thresholds_.closed_to);
}

template <class D> bool NewtonProjector<D>::may_be_round_off(const double* C) const {
    const double tolerance = settings_.tolerance >= 0.0 ? settings_.tolerance : thresholds_.closed_to;
    return within(C, thresholds_.round_off_grains, tolerance) &&
           (!equations_.contacts().any() || equations_.contacts().within(thresholds_.round_off_grains, tolerance));
}

template <class D> bool NewtonProjector<D>::within(const double* C, double grains, double least) const {
    for (const Instance<D>& p : model_.constraints.instances)
        for (int r = p.row; r < p.row + p.rows; ++r) {
            const double smallest = least * std::min(1.0, model_.row_scale[r]);
            if (!(std::abs(C[r]) <= std::max(smallest, grains * equations_.pose().grain(p, r)))) return false;
        }
    return true;
}

template <class D> NewtonProjector<D>::~NewtonProjector() = default;

template class NewtonProjector<Plane<double>>;
template class NewtonProjector<Space<double>>;

}  // namespace mbproj
