#include "stepping/step_end.hpp"

namespace mbproj {

Outcome StepEnd::close(double t, const Vector& y, double t_new, Vector& y_new, Counted& counted,
                       const StepDoubling* halves, Counters& counters, Peaks& peaks) {
    Formulation* other = equations_.other();
    if (other) other->enter_end();
    const Outcome found = closed(t, y, t_new, y_new, counted, halves, counters, peaks);
    if (other && !found.stops()) other->arrive(y_new.data());
    return found;
}

Outcome StepEnd::close_sample(double t, Vector& y) {
    turns_.lead(t, y);
    const Projected done = projector_.anywhere(t, y.data());
    if (!done.regular) return failed_at(t);
    const double* C = equations_.constraint();
    const int worst = model_.open_by_more(C, limit(done));
    if (worst < 0) return {};
    return Outcome::left_open(t, worst, std::abs(C[worst]), done.position_passes, done.failures > 0);
}

Outcome StepEnd::failed_at(double t) {
    if (!equations_.broken_state().empty()) return {Status::broken, equations_.time()};
    if (!equations_.is_finite()) return {Status::not_finite, t};
    if (equations_.jammed() >= 0) return Outcome::jammed(t, equations_.jammed());
    Outcome found{Status::singular, t};
    found.joint = equations_.singular_joint();
    return found;
}

void StepEnd::take_back() {
    if (auto* rows = invariants()) rows->take_back();
    if (equations_.other()) equations_.other()->take_back();
}

Outcome StepEnd::closed(double t, const Vector& y, double t_new, Vector& y_new, Counted& counted,
                        const StepDoubling* halves, Counters& counters, Peaks& peaks) {
    turns_.lead(t_new, y_new);
    const Projected done = projector_.after_step(counters.steps, t_new, y.data(), y_new.data());
    count(done, counters);
    if (!done.regular) return failed_at(t_new);
    if (const Outcome other = other_branch(done, t_new, y_new, t_new - t, halves); other.stops()) return other;
    const double* C = equations_.constraint();
    equations_.set_velocities(y_new.data(), true);
    const int worst = model_.open_by_more(C, limit(done));
    if (const Slip slip = worst >= 0 ? turns_.far(counted, t_new - t) : turns_.advance(counted, t, y, t_new, y_new))
        return Outcome::untold(slip, t_new, t_new - t);
    peaks.watch(C, equations_.C_dot(), model_.row_count(), model_.driven_count(), t_new);
    if (worst < 0) {
        if (const auto off = equations_.off_rope()) return Outcome::off_rope(t_new, off->first, off->second);
        if (const auto found = equations_.overlap())
            return Outcome::overlap(t_new, found->first < 0 ? -1 : model_.joint_of(found->first), found->second);
        return lost(done, t_new, t_new - t);
    }
    if (!done.near_singular)
        return Outcome::left_open(t_new, worst, std::abs(C[worst]), done.position_passes, done.failures > 0);
    Outcome found = failed_at(t_new);
    found.joint = model_.joint_of(worst);
    return found;
}

void StepEnd::count(const Projected& done, Counters& counters) {
    counters.projections += done.projections;
    counters.projection_iterations += done.position_passes;
    counters.velocity_iterations += done.velocity_passes;
    counters.projection_failures += done.failures;
    counters.projection_fallbacks += done.fallbacks;
}

Outcome StepEnd::lost(const Projected& done, double t, double h) const {
    const bool found = done.velocity_change > model_.thresholds.lost_velocity &&
                       done.speed_change * h > model_.thresholds.lost_way * model_.length;
    return found ? Outcome::at_branch(Status::branch, t, done.velocity_change, false) : Outcome{};
}

Outcome StepEnd::other_branch(const Projected& done, double t, const Vector& y, double h, const StepDoubling* halves) {
    const bool jumps = done.velocity_change > model_.thresholds.branch_change &&
                       done.speed_change * h > model_.thresholds.at_rest * model_.length;
    if (jumps && equations_.is_near_singular())
        return Outcome::at_branch(Status::branch, t, done.velocity_change, true);
    const double off = halves ? equations_.distance(halves->end(), y, h) : 0.0;
    if (off > model_.thresholds.agreement && equations_.is_near_singular())
        return Outcome::at_branch(Status::unresolved, t, off, true);
    return {};
}

}  // namespace mbproj
