// The mechanism: bodies, and constraint primitives bound to points and vectors that are fixed in them.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <vector>

#include "model/dimension.hpp"
#include "model/kinds.hpp"
#include "model/mechanism.hpp"
#include "model/plane_curve.hpp"
#include "model/programs.hpp"
#include "model/rope_path.hpp"
#include "model/space_curve.hpp"
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

    bool on_line() const { return is(Form::on_line, kind); }
};

template <class D> struct PrimitiveSet {
    std::vector<Attachment<D>> attachments;
    std::vector<Instance<D>> instances;
    int rows = 0;
};

// Rows at the end of the constraints that functions of time drive: s(q) - start - f(t), with s one of the coordinates and f
// one of the programs.
template <class D> struct DrivenRow {
    int row;
    bool is_angle;
    Scalar<D> start;
    int coordinate, program;
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

template <class D> struct Loads;

template <class D> struct Model final : Mechanism {
    std::vector<Body<D>> bodies;
    Point<D> gravity;
    PrimitiveSet<D> constraints;
    PrimitiveSet<D> coordinates;
    std::shared_ptr<const Loads<D>> loads;  // the forces other than gravity, or none
    std::vector<DrivenRow<D>> driven;
    // Functions of forces, rates of states, then functions of couplings and of driven rows.
    ProgramsOf<Scalar<D>> programs;
    // Inertias I of flywheels that coordinates turn, with the energy ½ I s'². Each is a joint after all others, with a row after
    // those of C for the flywheel's own rate: s'(bodies) - s'(flywheel) = 0.
    std::vector<Scalar<D>> flywheels;
    PrimitiveSet<D> stop_coordinates;  // that stops limit and dry friction resists, one instance each
    std::vector<Bearing<D>> bearings;

    Model();
    Model(const Model&);
    Model(Model&&) noexcept;
    Model& operator=(Model&&) noexcept;
    ~Model() override;

    int size() const override { return static_cast<int>(bodies.size()); }
    int row_count() const override { return constraints.rows; }
    int coordinate_count() const override { return static_cast<int>(coordinates.instances.size()); }
    int driven_count() const override { return static_cast<int>(driven.size()); }
    int driven_coordinate(int row) const override { return driven[row].coordinate; }
    int flywheel_count() const override { return static_cast<int>(flywheels.size()); }
    BodySizes sizes() const override { return {Size<D>::freedoms, Size<D>::pose, Size<D>::state}; }
    // Whether each row of C is at velocity level; empty where no row is. The coordinates of flywheels and of stiff forces may be
    // slips, too: their rows come after those of C and are always independent.
    std::vector<char> slips() const {
        std::vector<char> found;
        for (const Instance<D>& p : constraints.instances)
            if (is_slip(p.kind) && p.row < constraints.rows) found.resize(constraints.rows), found[p.row] = 1;
        return found;
    }
};

extern template struct Model<Plane<double>>;
extern template struct Model<Space<double>>;

}  // namespace mbproj
