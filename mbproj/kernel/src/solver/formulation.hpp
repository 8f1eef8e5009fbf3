// Another formulation of the mechanism, which makes accelerations and projections in the kernel's place: the full one,
// in NumPy. All else stays the kernel's: steps, events, contacts, forces of sliding frictions, states, work.
#pragma once

#include "model/settings.hpp"
#include "solver/border.hpp"

namespace mbproj {

struct Projected {
    int projections = 0, position_passes = 0, velocity_passes = 0, failures = 0, fallbacks = 0;
    double velocity_change = 0.0;                // by the correction, as a part of the velocity
    double speed_change = 0.0;                   // and as it is, rotations times the mechanism's length
    bool regular = true, near_singular = false;  // the second: near a pose where rows become dependent

    // Adds a second projection, with other rows, whose result counts.
    void take(const Projected& second) {
        position_passes += second.position_passes;
        velocity_passes += second.velocity_passes;
        failures = second.failures;
        fallbacks += second.fallbacks;
        velocity_change = std::max(velocity_change, second.velocity_change);
        speed_change = std::max(speed_change, second.speed_change);
        regular = second.regular;
        near_singular = second.near_singular;
    }
};

// A state y at t. Functions of time are evaluated inside the window, programs on these branches, one for each
// instruction, or on free ones where it is null. Contacts hold these rows.
struct AskedState {
    double t;
    const double* y;
    TimeWindow window;
    const double* branches;
    std::vector<ContactRow> rows;
};

class Formulation {
public:
    Formulation(const Formulation&) = delete;
    Formulation& operator=(const Formulation&) = delete;
    virtual ~Formulation() = default;

    // Sets the accelerations of all bodies in a slope, and λ of the rows of C, with these forces along coordinates of
    // stops and frictions. `watched`: at a stage of a step. False where the equations have no solution.
    virtual bool accelerate(const AskedState& at, const std::vector<double>& forces, bool watched, double* slope,
                            double* lambda) = 0;
    // After step number `step`, or 0 between two steps: y is moved to the constraints.
    virtual Projected project(long step, const AskedState& at, double* y) = 0;

    // A step is tried from the last end; it comes to its own end; this is closed at y; the step is made again.
    virtual void begin_step() = 0;
    virtual void enter_end() = 0;
    virtual void arrive(const double* y) = 0;
    virtual void take_back() = 0;

    // The numbers besides y on which the next step depends; `resume` is false where they are not of this formulation.
    virtual std::vector<double> save() = 0;
    virtual bool resume(const std::vector<double>& saved) = 0;
    // Throws the exception that has ended the other formulation.
    virtual void rethrow() = 0;

protected:
    Formulation() = default;
};

}  // namespace mbproj
