// What a mechanism is whatever its dimension: its joints, couplings, states and switches, by numbers.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "model/layout.hpp"
#include "model/programs.hpp"
#include "model/thresholds.hpp"

namespace mbproj {

// A joint owns the instances `begin` to `end` of the set, and their rows. The joint of a stiff bushing has no instances: its rows
// are the bushing's coordinates.
struct Joint {
    int begin, end;
    int row, rows;
    std::vector<int> bodies;  // the bodies that move, each once
    int bushing = -1;
};

// A force that implicit steps linearise: a law or a bushing, by its number among the loads; the other is -1.
struct StiffForce {
    int law, bushing;
};

// The variables of functions besides the time and their own coordinate, as in mbproj.model.channels: a state of an element, a
// joint coordinate, or its rate, by number.
enum class ChannelKind : int { state, coordinate, rate };
struct Channel {
    ChannelKind kind;
    int index;
};

// An instruction of a program that changes its branch with the state, and the law or curve that owns the program, or -1.
struct Switch {
    int program, at, law, curve;
};

// A row that couples coordinates: their weighted sum, less a curve of the first coordinate (or -1), less a multiple of the period
// (one tooth, one thread; 0: none). A turn of the first coordinate adds `growth` to the curve. A row that `rolls` couples the lap
// of a curve, its period, and the turn of a roller.
struct Coupling {
    int row;
    double period;
    std::vector<int> coordinates;
    std::vector<double> weights;
    double growth;
    int curve;
    bool rolls;
};

// The action of a controller at an instant: it sets states of elements to the values of programs, all at once.
struct Action {
    std::vector<int> states, programs;
};

// A program of the value of a constraint instance. For a plane curve that is followed, it is a program of the foot's parameter,
// and its switches are the curve's knots. Such an instance may also be the coordinate of a law or of a stop, and counts while the
// law acts or the stop touches. Or it is a joint's coordinate, whose sign is the switch.
enum class Of : int { row, law, stop, coordinate };
struct Curve {
    int instance, program;
    Of of = Of::row;
    bool second = false;  // whether it is the second of two curves that touch
};

// Properties of the constraint rows that are found before the run. Learned during the run, they would depend on its history.
struct UsualRows {
    int redundant = 0;          // the number of rows that follow from the others at all poses
    std::vector<int> left_out;  // rows of loops' joints left out at most poses, ascending; if empty, see RowPolicy
    // The usual pivots of S with the other rows, all 1 where unknown. `even` is the smallest pivot where all bodies
    // have the same mass.
    std::vector<double> pivots;
    double even = 1.0;
};

// The coordinates that stops limit and dry friction resists: their offsets, and the joint coordinate from which an angle takes its
// whole turns, or -1.
struct Stops {
    std::vector<int> joint_coordinate;
    std::vector<double> bound;
};

// The numbers of a body's freedoms, of its pose, and of its state.
struct BodySizes {
    int freedoms, pose, state;
};

struct Mechanism {
    std::vector<Joint> joints;
    std::vector<double> row_scale;   // the scale of a row's violation; 1 for the row of a flywheel
    std::vector<bool> counts_turns;  // per coordinate: an angle
    double length = 0.0;             // the size of the mechanism
    UsualRows rows;
    std::vector<Coupling> couplings;
    std::vector<Curve> curves;
    int first_rate = 0;             // the first program of a rate
    std::vector<Channel> channels;  // the variables of programs from `law_variables` on
    std::vector<Switch> switches;   // program after program, in the order of their instructions
    Layout layout;                  // of y
    // Forces that implicit steps linearise (kinematics/compliant_rows.hpp); none for explicit steps. Each is a joint after those
    // of the flywheels.
    std::vector<StiffForce> stiff;
    int stiff_rows = 0;
    Stops stops;
    std::vector<Action> actions;
    Programs action_programs;  // the programs of the actions, with the same channels
    Thresholds thresholds;

    virtual ~Mechanism() = default;
    virtual int size() const = 0;              // the number of bodies
    virtual int row_count() const = 0;         // of C
    virtual int coordinate_count() const = 0;  // of the joints' coordinates
    virtual int driven_count() const = 0;      // of driven rows, the last of C
    virtual int driven_coordinate(int row) const = 0;
    virtual int flywheel_count() const = 0;
    virtual BodySizes sizes() const = 0;
    int joint_of(int row) const {
        int found = 0;
        while (row >= joints[found].row + joints[found].rows) ++found;
        return found;
    }
    // The row with the largest violation in parts of its scale, where that exceeds the limit; else -1.
    int open_by_more(const double* C, double limit) const {
        int worst = -1;
        for (int r = 0; r < row_count(); ++r)
            if (const double part = abs(C[r]) / row_scale[r]; !(part <= limit)) limit = part, worst = r;
        return worst;
    }
    // Whether the joints and motions leave no degree of freedom.
    bool is_held() const { return row_count() - rows.redundant >= sizes().freedoms * size(); }
    // The number of rows of C, of flywheels and of stiff forces, `all_rows`, and of coordinates that stops limit or dry
    // friction resists.
    int all_multipliers() const { return all_rows() + static_cast<int>(stops.bound.size()); }
    int all_rows() const { return row_count() + flywheel_count() + stiff_rows; }
    int first_stiff() const { return static_cast<int>(joints.size() - stiff.size()); }
    bool holds_flywheel(int joint) const { return joint < first_stiff() && joint >= first_stiff() - flywheel_count(); }
    bool is_compliant(int joint) const { return joint >= first_stiff(); }

protected:
    Mechanism() = default;
    Mechanism(const Mechanism&) = default;
    Mechanism(Mechanism&&) = default;
    Mechanism& operator=(const Mechanism&) = default;
    Mechanism& operator=(Mechanism&&) = default;
};

}  // namespace mbproj
