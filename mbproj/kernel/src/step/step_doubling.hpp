// Steps past singular poses. On the constraints the motion goes through such a pose smoothly. But a stage violates them
// by some power of h, and there this error is divided by the distance of C_q from losing its rank: a coarse step may
// end anywhere, even on another branch of the motion, with velocities that agree with it. So a step within which this
// distance changes by a large part is repeated as two halves, and both must agree.
#pragma once

#include "solver/projector.hpp"
#include "step/stepper.hpp"

namespace mbproj {

class StepDoubling {
public:
    using Vector = Eigen::VectorXd;

    StepDoubling(const Stepper& stepper, Equations& equations, Projector& projector)
        : equations_(equations), projector_(projector), half_(stepper.copy()),
          middle_(Vector::Zero(equations.layout().size())), end_(middle_) {}

    // Whether the last step needs the check, by the poses of its stages; closed stages need none.
    bool is_near() const;

    // Two half steps from y at t, with its slope; false where they fail. Their evaluations count.
    bool repeat(double t, const Vector& y, const Vector& slope, double h, long& evaluations);

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
