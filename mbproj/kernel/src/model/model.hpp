// The mechanism as the kernel keeps it: bodies, and primitives bound to points and vectors that are fixed in them.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "model/dimension.hpp"
#include "model/kinds.hpp"
#include "model/layout.hpp"
#include "model/plane_curve.hpp"
#include "model/programs.hpp"
#include "model/rope_path.hpp"
#include "model/space_curve.hpp"
#include "model/thresholds.hpp"
#include "model/two_curves.hpp"

namespace mbproj {

template <class D> struct Body {
    Scalar<D> mass;
    TurnMatrix<D> inertia;       // about the centre of mass, body axes
    TurnMatrix<D> inverse_root;  // K⁻¹ with J = K Kᵀ; of a light body, not in use
    bool is_light;               // no mass, or no inertia about some axis
};

// A point or vector fixed in a body, in its axes; body n is the ground.
template <class D> struct Attachment {
    int body;
    bool is_point;
    Point<D> local;
    Scalar<D> size;  // largest coordinate of `local`, 0 for a vector
};

// One primitive: the attachments it binds, its first row, and what its value counts from. A row that couples coordinates is a
// sum of several, one after another: each with its weight, and all but the first without a row of their own.
template <class D> struct Instance {
    Kind kind;
    int slots[most_slots];
    int slot_count;
    Scalar<D> parameters[most_parameters];
    int row;
    int rows;
    Scalar<D> offset;
    Scalar<D> weight;
    bool coupled;
    int curve;  // of the model: what the row is less, a function of this instance's value; or -1
    std::shared_ptr<const PlaneCurve> line;   // of what follows a curve in a plane
    std::shared_ptr<const PlaneCurve> other;  // of two that touch, the second
    std::shared_ptr<const SpaceCurve> wire;   // of what follows a curve in space
    std::shared_ptr<const RopePath> path;     // of a rope, which has as many slots as it needs
    int follower = -1;                        // its number among the curves of the model, of what is held on pieces
    int other_follower = -1;                  // likewise of the second curve

    bool on_line() const { return kind >= Kind::profile && kind <= Kind::space_arc; }
};

template <class D> struct PrimitiveSet {
    std::vector<Attachment<D>> attachments;
    std::vector<Instance<D>> instances;
    int rows = 0;
};

// A joint is a run of instances, `begin` to `end` of the set, and of rows. That of a stiff bushing has no instances: its
// rows are the bushing's coordinates.
struct Joint {
    int begin, end;
    int row, rows;
    std::vector<int> bodies;  // those that move, each once
    int bushing = -1;
};

// A force that implicit steps linearise: a law or a bushing, by its number among the loads; the other is -1.
struct StiffForce {
    int law, bushing;
};

// Rows at the end of the constraints that functions of time drive: s(q) - start - f(t), with s one of the coordinates and f
// one of the programs.
template <class D> struct DrivenRow {
    int row;
    bool is_angle;
    Scalar<D> start;
    int coordinate, program;
};

// What functions name beside the time and what they act along, as mbproj.model.channels has it: a state of elements, one of
// the joints' coordinates, or its rate, by number.
enum class ChannelKind : int { state, coordinate, rate };
struct Channel {
    ChannelKind kind;
    int index;
};

// An instruction of a program that changes its branch with the state; the law or the curve whose program it is, or -1.
struct Switch {
    int program, at, law, curve;
};

// A row that couples coordinates: their weighed sum, less a curve of the first, or none (-1), and less a multiple of a period
// (one tooth, one thread; 0: none). A turn of the first adds the `growth` to the curve. What `rolls` on a curve couples a lap, the
// period, and the turn of a roller.
struct Coupling {
    int row;
    double period;
    std::vector<int> coordinates;
    std::vector<double> weights;
    double growth;
    int curve;
    bool rolls;
};

// What a controller does at an instant: it sets states of elements to what programs are there, all at once.
struct Action {
    std::vector<int> states, programs;
};

// A program of the value of an instance of the constraints; of one that follows a curve in a plane, of the parameter of
// its foot, and the program's switch is the knots of that. Such an instance may be the coordinate of a law or a stop, too:
// it follows while the law acts, or the stop touches. Or of a joint's coordinate, whose sign is the switch.
enum class Of : int { row, law, stop, coordinate };
struct Curve {
    int instance, program;
    Of of = Of::row;
    bool second = false;  // of two curves that touch
};

// Coordinates that stops limit and dry friction resists, one instance each: what they are measured from, and from which of
// the joints' coordinates an angle takes its turns, or -1.
template <class D> struct Stops {
    PrimitiveSet<D> coordinates;
    std::vector<int> joint_coordinate;
    std::vector<double> bound;
};

// What a joint carries, by which dry friction goes: with the force F and the moment T on body 2 at `point`, along `axis` z (both
// in its axes), preload + radial (|f₁| + |f₂|) + axial |F·z| with f₁, f₂ = ½ (F - (F·z) z) ± (T × z)/length. In a plane the axis
// is normal to it. What is the sum of these `parts` of multipliers, by the numbers of their rows, is the push of a contact; or
// with an axial arm the pull of a rope, which counts whatever its sign is.
template <class D> struct Bearing {
    int joint, body;
    Point<D> point, axis;
    Scalar<D> radial, axial, length, preload;
    std::vector<std::pair<int, double>> parts;

    bool is_of_rows() const { return !parts.empty(); }
    bool is_push() const { return is_of_rows() && axial == 0.0; }
};

// An angle with the whole turns that bring it next to what is expected of it.
template <class S> inline S near(const S& angle, const S& expected) {
    return angle + 2.0 * M_PI * nearbyint((expected - angle) / (2.0 * M_PI));
}

// What is known of the constraint rows before a run: what it learned of the poses passed would be a history of its derivative.
template <class Number = double> struct UsualRows {
    int redundant = 0;  // rows that follow from the others wherever the mechanism goes
    std::vector<int>
        left_out;  // rows of joints in loops that are left out at most poses, ascending; none: see RowPolicy
    // Of S with the others at most poses: the pivots, all 1 where there are none; and the smallest where all bodies weigh the
    // same.
    std::vector<Number> pivots;
    Number even = 1.0;
};

template <class D> struct Loads;

template <class D> struct Model {
    std::vector<Body<D>> bodies;
    Point<D> gravity;
    PrimitiveSet<D> constraints;
    PrimitiveSet<D> coordinates;
    std::vector<Joint> joints;
    std::vector<Measure<D>> row_scale;   // what a row's violation is measured against; 1 where it holds a flywheel
    std::vector<bool> counts_turns;  // per coordinate: an angle
    Measure<D> length;               // the size of the mechanism
    UsualRows<Measure<D>> rows;
    std::shared_ptr<const Loads<D>> loads;  // none, or the forces but gravity
    std::vector<DrivenRow<D>> driven;
    std::vector<Coupling> couplings;
    std::vector<Curve> curves;
    ProgramsOf<Scalar<D>> programs;  // the functions of forces, the rates of states, then those of couplings, of driven rows
    int first_rate = 0;  // of the programs
    std::vector<Channel> channels;  // what programs name from `law_variables` on
    std::vector<Switch> switches;   // program after program, in the order of their instructions
    Layout layout;                  // of y
    // I of flywheels that coordinates turn, ½ I s'². Each is a joint after all others, with a row after those of C, which
    // holds the flywheel's own rate: s'(bodies) - s'(flywheel) = 0.
    std::vector<Scalar<D>> flywheels;
    // Forces that implicit steps linearise (kinematics/compliant_rows.hpp); none where steps are explicit. Each is a joint
    // after those of the flywheels.
    std::vector<StiffForce> stiff;
    int stiff_rows = 0;
    Stops<D> stops;
    std::vector<Bearing<D>> bearings;
    std::vector<Action> actions;
    Programs action_programs;  // theirs, of the same channels
    Thresholds thresholds;

    int joint_of(int row) const {
        int found = 0;
        while (row >= joints[found].row + joints[found].rows) ++found;
        return found;
    }
    // The row that is furthest open, where that is by more than a part of its own scale; else -1.
    int open_by_more(const Scalar<D>* C, Scalar<D> limit) const {
        int worst = -1;
        for (int r = 0; r < constraints.rows; ++r)
            if (const Scalar<D> part = abs(C[r]) / row_scale[r]; !(part <= limit)) {
                limit = part;
                worst = r;
            }
        return worst;
    }
    int size() const { return static_cast<int>(bodies.size()); }
    // Which rows are at velocity level; none where there are none.
    std::vector<char> slips() const {
        std::vector<char> found;
        for (const Instance<D>& p : constraints.instances)
            if (is_slip(p.kind)) found.resize(constraints.rows), found[p.row] = 1;
        return found;
    }
    // Whether joints and motions alone say where each body is.
    bool is_held() const { return constraints.rows - rows.redundant >= Size<D>::freedoms * size(); }
    // The rows of C, those that hold flywheels, and those of stiff forces.
    // Of all rows, and then the pushes of the stops.
    int all_multipliers() const { return all_rows() + static_cast<int>(stops.bound.size()); }
    int all_rows() const { return constraints.rows + static_cast<int>(flywheels.size()) + stiff_rows; }
    int first_stiff() const { return static_cast<int>(joints.size() - stiff.size()); }
    bool holds_flywheel(int joint) const {
        return joint < first_stiff() && joint >= first_stiff() - static_cast<int>(flywheels.size());
    }
    bool is_compliant(int joint) const { return joint >= first_stiff(); }
};

}  // namespace mbproj
