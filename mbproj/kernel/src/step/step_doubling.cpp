#include "step/step_doubling.hpp"

namespace mbproj {

bool StepDoubling::is_near() const {
    if (half_->closes_stages()) return false;
    const Thresholds& thresholds = equations_.mechanism().thresholds;
    const Passed& passed = equations_.passed();
    return passed.smallest < thresholds.passing && passed.smallest < thresholds.nearing * passed.largest;
}

bool StepDoubling::repeat(double t, const Vector& y, const Vector& slope, double h, long& evaluations) {
    half_->begin(slope);
    const bool reaches_middle = half_->attempt(t, y, 0.5 * h, middle_);
    evaluations += half_->attempt_cost();
    if (!reaches_middle || !projector_.anywhere(t + 0.5 * h, middle_.data()).regular) return false;
    evaluations += half_->arrival_cost();
    if (!half_->follow_on(t + 0.5 * h, middle_)) return false;
    const bool reaches_end = half_->attempt(t + 0.5 * h, middle_, 0.5 * h, end_);
    evaluations += half_->attempt_cost();
    return reaches_end && projector_.anywhere(t + h, end_.data()).regular;
}

}  // namespace mbproj
