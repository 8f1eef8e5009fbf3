// The mechanism: bodies, and constraint primitives bound to points and vectors that are fixed in them.
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
    TurnMatrix<D> inverse_root;  // K⁻¹ with J = K Kᵀ; not used for a light body
    bool is_light;               // no mass, or no inertia about some axis
};

// A point or vector fixed in a body, in its axes; body n is the ground.
template <class D> struct Attachment {
    int body;
    bool is_point;
    Point<D> local;
    Scalar<D> size;  // largest coordinate of `local`, 0 for a vector
};

// One primitive: its attachments, its first row, and the offset of its value. A row that couples coordinates is a sum of
// consecutive instances, each with a weight; only the first of these has a row.
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
    int curve;  // the model's curve, a function of this instance, that the row subtracts; or -1
    std::shared_ptr<const PlaneCurve> line;   // the plane curve that it follows
    std::shared_ptr<const PlaneCurve> other;  // the second of two curves that touch
    std::shared_ptr<const SpaceCurve> wire;   // the space curve that it follows
    std::shared_ptr<const RopePath> path;     // the path of a rope
    int follower = -1;        // its number among the model's curves, where its foot stays on one piece; or -1
    int other_follower = -1;  // the same for the second curve

    bool on_line() const { return kind >= Kind::profile && kind <= Kind::space_arc; }
};

template <class D> struct PrimitiveSet {
    std::vector<Attachment<D>> attachments;
    std::vector<Instance<D>> instances;
    int rows = 0;
};

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

// Rows at the end of the constraints that functions of time drive: s(q) - start - f(t), with s one of the coordinates and f
// one of the programs.
template <class D> struct DrivenRow {
    int row;
    bool is_angle;
    Scalar<D> start;
    int coordinate, program;
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

// The coordinates that stops limit and dry friction resists, one instance each; their offsets, and the joint coordinate from
// which an angle takes its whole turns, or -1.
template <class D> struct Stops {
    PrimitiveSet<D> coordinates;
    std::vector<int> joint_coordinate;
    std::vector<double> bound;
};

// The load of a joint, which multiplies dry friction. F and T are the force and moment on body 2 at `point`, z is
// `axis`, both in its axes. The load is preload + radial (|f₁| + |f₂|) + axial |F·z| with f₁, f₂ = ½ (F - (F·z) z) ± (T
// × z)/length. In the plane the axis is normal to it. With `parts`, pairs of a row and a factor of its multiplier, the
// load is their sum: the push of a contact or, with an axial arm, the pull of a rope, whatever its sign.
template <class D> struct Bearing {
    int joint, body;
    Point<D> point, axis;
    Scalar<D> radial, axial, length, preload;
    std::vector<std::pair<int, double>> parts;

    bool is_of_rows() const { return !parts.empty(); }
    bool is_push() const { return is_of_rows() && axial == 0.0; }
};

// The angle plus the whole turns that bring it closest to the expected value.
template <class S> inline S near(const S& angle, const S& expected) {
    return angle + 2.0 * M_PI * nearbyint((expected - angle) / (2.0 * M_PI));
}

// Properties of the constraint rows that are found before the run. Learned during the run, they would depend on its history.
struct UsualRows {
    int redundant = 0;          // the number of rows that follow from the others at all poses
    std::vector<int> left_out;  // rows of loops' joints left out at most poses, ascending; if empty, see RowPolicy
    // The usual pivots of S with the other rows, all 1 where unknown. `even` is the smallest pivot where all bodies
    // have the same mass.
    std::vector<double> pivots;
    double even = 1.0;
};

template <class D> struct Loads;

template <class D> struct Model {
    std::vector<Body<D>> bodies;
    Point<D> gravity;
    PrimitiveSet<D> constraints;
    PrimitiveSet<D> coordinates;
    std::vector<Joint> joints;
    std::vector<double> row_scale;   // the scale of a row's violation; 1 for the row of a flywheel
    std::vector<bool> counts_turns;  // per coordinate: an angle
    double length;                   // the size of the mechanism
    UsualRows rows;
    std::shared_ptr<const Loads<D>> loads;  // the forces other than gravity, or none
    std::vector<DrivenRow<D>> driven;
    std::vector<Coupling> couplings;
    std::vector<Curve> curves;
    ProgramsOf<Scalar<D>>
        programs;        // functions of forces, rates of states, then functions of couplings and of driven rows
    int first_rate = 0;  // the first program of a rate
    std::vector<Channel> channels;  // the variables of programs from `law_variables` on
    std::vector<Switch> switches;   // program after program, in the order of their instructions
    Layout layout;                  // of y
    // Inertias I of flywheels that coordinates turn, with the energy ½ I s'². Each is a joint after all others, with a row after
    // those of C for the flywheel's own rate: s'(bodies) - s'(flywheel) = 0.
    std::vector<Scalar<D>> flywheels;
    // Forces that implicit steps linearise (kinematics/compliant_rows.hpp); none for explicit steps. Each is a joint after those
    // of the flywheels.
    std::vector<StiffForce> stiff;
    int stiff_rows = 0;
    Stops<D> stops;
    std::vector<Bearing<D>> bearings;
    std::vector<Action> actions;
    Programs action_programs;  // the programs of the actions, with the same channels
    Thresholds thresholds;

    int joint_of(int row) const {
        int found = 0;
        while (row >= joints[found].row + joints[found].rows) ++found;
        return found;
    }
    // The row with the largest violation in parts of its scale, where that exceeds the limit; else -1.
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
    // Whether each row of C is at velocity level; empty where no row is. The coordinates of flywheels and of stiff forces may be
    // slips, too: their rows come after those of C and are always independent.
    std::vector<char> slips() const {
        std::vector<char> found;
        for (const Instance<D>& p : constraints.instances)
            if (is_slip(p.kind) && p.row < constraints.rows) found.resize(constraints.rows), found[p.row] = 1;
        return found;
    }
    // Whether the joints and motions leave no degree of freedom.
    bool is_held() const { return constraints.rows - rows.redundant >= Size<D>::freedoms * size(); }
    // The number of rows of C, of flywheels and of stiff forces, `all_rows`, and of coordinates that stops limit or dry
    // friction resists.
    int all_multipliers() const { return all_rows() + static_cast<int>(stops.bound.size()); }
    int all_rows() const { return constraints.rows + static_cast<int>(flywheels.size()) + stiff_rows; }
    int first_stiff() const { return static_cast<int>(joints.size() - stiff.size()); }
    bool holds_flywheel(int joint) const {
        return joint < first_stiff() && joint >= first_stiff() - static_cast<int>(flywheels.size());
    }
    bool is_compliant(int joint) const { return joint >= first_stiff(); }
};

}  // namespace mbproj
