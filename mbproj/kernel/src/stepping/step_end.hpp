// The end of a step: the state there is projected, checked, and its turns are counted.
#pragma once

#include "projection/projector.hpp"
#include "stepping/samples.hpp"
#include "stepping/step_doubling.hpp"
#include "stepping/turn_counter.hpp"

namespace mbproj {

class StepEnd {
public:
    using Vector = Eigen::VectorXd;
    using Counted = TurnCounter::Counted;

    StepEnd(Equations& equations, Projector& projector, const TurnCounter& turns)
        : model_(equations.mechanism()), equations_(equations), projector_(projector), turns_(turns) {}

    // The step number `counters.steps` from y at t led to y_new at t_new. Closes and counts it in place; `halves` is
    // the check by step doubling, or null. Returns why the run cannot go on from there; `running` where it can.
    Outcome close(double t, const Vector& y, double t_new, Vector& y_new, Counted& counted, const StepDoubling* halves,
                  Counters& counters, Peaks& peaks);

    // Moves a state inside a step to the constraints. Returns why it cannot be recorded; `running` where it can.
    Outcome close_sample(double t, Vector& y);

    // Why the equations have just had no solution.
    Outcome failed_at(double t);

    // The rows of conserved quantities, or null.
    Invariants* invariants() { return projector_.invariants(); }
    // The step that was closed is made again.
    void take_back();

private:
    Outcome closed(double t, const Vector& y, double t_new, Vector& y_new, Counted& counted, const StepDoubling* halves,
                   Counters& counters, Peaks& peaks);
    // By how much a joint may be open.
    double limit(const Projected& done) const {
        return done.failures ? model_.thresholds.open_limit : model_.thresholds.lost_limit;
    }

    static void count(const Projected& done, Counters& counters);

    // Whether the step has led so far off the constraints that its projection is arbitrary.
    Outcome lost(const Projected& done, double t, double h) const;

    // Whether a step past a singular pose has met another branch of the motion: velocities are continuous, but branches
    // cross in singular poses at an angle. Or whether its halves end elsewhere.
    Outcome other_branch(const Projected& done, double t, const Vector& y, double h, const StepDoubling* halves);

    const Mechanism& model_;
    Equations& equations_;
    Projector& projector_;
    const TurnCounter& turns_;
};

}  // namespace mbproj
