// Steps past singular poses. On the constraints the motion goes through such a pose smoothly. But a stage violates them
// by some power of h, and there this error is divided by the distance of C_q from losing its rank: a coarse step may
// end anywhere, even on another branch of the motion, with velocities that agree with it. So a step within which this
// distance changes by a large part is repeated as two halves, and both must agree.
#pragma once

#include "projection/projector.hpp"
#include "steppers/stepper.hpp"

namespace mbproj {

class StepDoubling {
public:
    using Vector = Eigen::VectorXd;

    StepDoubling(const Stepper& stepper, Equations& equations, Projector& projector)
        : equations_(equations), projector_(projector), half_(stepper.copy()),
          middle_(Vector::Zero(equations.layout().size())), end_(middle_) {}

    // Whether the last step needs the check, by the poses of its stages; closed stages need none.
    bool is_near() const {
        if (half_->closes_stages()) return false;
        const Thresholds& thresholds = equations_.mechanism().thresholds;
        const Passed& passed = equations_.passed();
        return passed.smallest < thresholds.passing && passed.smallest < thresholds.nearing * passed.largest;
    }

    // Two half steps from y at t, with its slope; false where they fail. Their evaluations count.
    bool repeat(double t, const Vector& y, const Vector& slope, double h, long& evaluations) {
        half_->first() = slope;
        const bool reaches_middle = half_->attempt(t, y, 0.5 * h, middle_);
        evaluations += half_->attempt_cost();
        if (!reaches_middle || !projector_.anywhere(t + 0.5 * h, middle_.data()).regular) return false;
        evaluations += half_->arrival_cost();
        if (!half_->follow_on(t + 0.5 * h, middle_)) return false;
        const bool reaches_end = half_->attempt(t + 0.5 * h, middle_, 0.5 * h, end_);
        evaluations += half_->attempt_cost();
        return reaches_end && projector_.anywhere(t + h, end_.data()).regular;
    }

    // The states at the ends of the half steps.
    const Vector& middle() const { return middle_; }
    const Vector& end() const { return end_; }

private:
    Equations& equations_;
    Projector& projector_;
    std::unique_ptr<Stepper> half_;
    Vector middle_, end_;
};

}  // namespace mbproj
