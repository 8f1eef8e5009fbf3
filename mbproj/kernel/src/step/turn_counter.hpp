// Whole turns of the joints' angles, counted step by step. The definitions are those of
// mbproj.equations.turning: rates predict an angle after a step, by the trapezoidal rule; where the pose does
// not agree, by the stages of the step, or by the angle that y follows. Its motion predicts a driven angle. Where the
// pose does not agree then either, the step is too coarse to tell the turns.
#pragma once

#include <cmath>

#include "step/outcome.hpp"
#include "step/stepper.hpp"

namespace mbproj {

class TurnCounter {
public:
    using Vector = Eigen::VectorXd;
    // The angles at one point of the motion: the direction and the rate of each, the value that a motion prescribes;
    // and their turns.
    struct Angle : JointAngle<double> {
        double prescribed = 0.0;
    };
    struct Counted {
        std::vector<Angle> angles;
        std::vector<long> turns;
        double value(int i) const { return angles[i].value() + 2.0 * M_PI * static_cast<double>(turns[i]); }
        std::vector<double> values() const {
            std::vector<double> found(angles.size());
            for (std::size_t i = 0; i < found.size(); ++i) found[i] = value(static_cast<int>(i));
            return found;
        }
    };

    TurnCounter(Equations& equations, const Stepper& stepper);

    // The angles at the start of a run, at y, the state in place.
    Counted start(std::vector<long> turns, double t, Vector& y) const;

    // After velocities have jumped, those in place: turns are counted on from the rates after the jump.
    void take_speeds(Counted& counted) const;

    // Before the state y at a time is closed: sets angles that are followed and driven to the values of their motions.
    void lead(double t, Vector& y) const;

    // Counts turns from y at t to y_new, in place. Returns the worst coordinate whose turns the step cannot tell.
    Slip advance(Counted& counted, double t, const Vector& y, double t_new, Vector& y_new) const;

    // The coordinate that turns by most in a step of size h from here, where that is more than half a turn.
    Slip far(const Counted& counted, double h) const;

    // The angles at a time within a step whose ends are counted, for y in place: near the cubics through both ends.
    Counted inside(const Counted& before, double t, const Counted& after, double t_new, double time,
                   const Vector& y) const;

private:
    // A coordinate that counts turns, and the motion that drives it, or -1.
    struct Counting {
        int coordinate, motion;
    };

    // The whole turns that bring a value nearest to the expected one, and how far off it is then.
    static long turns(double expected, double value, double& off);

    // Sets angles that are followed to their counted values.
    void follow(const Counted& counted, Vector& y) const;

    // How far an angle turns in a step by the rates at its stages. Leaves y_new in place.
    double rotation(const Counting& each, double t, const Vector& y, double t_new, const Vector& y_new) const;
    Angle angle_now(const Counting& each) const {
        return {equations_.angle(each.coordinate), each.motion < 0 ? 0.0 : equations_.prescribed(each.motion)};
    }

    const Mechanism& model_;
    const Block followed_;  // in y
    Equations& equations_;
    const Stepper& stepper_;
    std::vector<Counting> counting_;
};

}  // namespace mbproj
