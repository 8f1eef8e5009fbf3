// The numbers of a model by which a run may be differentiated, in one order, and the model with numbers of another type.
#pragma once

#include <memory>

#include "kinematics/constraint_rows.hpp"
#include "model/dual.hpp"
#include "solver/drive.hpp"

namespace mbproj {

template <class D, class Number> using With = Dimension<D::axes, Number>;
template <class D> using WithDuals = With<D, Dual>;

template <class Matrix, class Visit> void visit_each(Matrix& matrix, Visit& visit) {
    for (auto& number : matrix) visit(number);
}

template <class Set, class Visit> void numbers_of_set(Set& set, Visit& visit) {
    for (auto& attachment : set.attachments) visit_each(attachment.local, visit);
    for (auto& p : set.instances) {
        for (int k = 0; k < form_of(p.kind).parameters; ++k) visit(p.parameters[k]);
        visit(p.offset);
        visit(p.weight);
    }
}

template <class Loads, class Visit> void numbers_of_loads(Loads& loads, Visit& visit) {
    numbers_of_set(loads.coordinates, visit);
    for (auto& law : loads.laws) visit(law.stiffness), visit(law.damping), visit(law.free);
    for (auto& given : loads.on_bodies) {
        visit_each(given.point, visit);
        visit_each(given.force_map, visit);
        visit_each(given.torque_map, visit);
    }
    for (auto& bushing : loads.bushings) {
        for (auto& origin : bushing.origin) visit_each(origin, visit);
        for (auto& turn : bushing.turn) visit_each(turn, visit);
        visit_each(bushing.stiffness, visit);
        visit_each(bushing.damping, visit);
        visit_each(bushing.preload, visit);
    }
}

// Constants of functions, and the pieces of their tables.
template <class Programs, class Visit> void numbers_of_programs(Programs& programs, Visit& visit) {
    for (std::size_t at = 0; at < programs.op.size(); ++at)
        if (programs.op[at] == Op::constant) visit(programs.constant[at]);
    visit_each(programs.origin, visit);
    visit_each(programs.piece, visit);
}

// Calls visit(number) for each number: masses and inertias, gravity, the points, vectors and offsets of joints and
// coordinates, forces, functions, and start values of motions. `loads`: those of the model, or null.
template <class Model, class Loads, class Visit> void each_number(Model& model, Loads* loads, Visit&& visit) {
    for (auto& body : model.bodies) {
        visit(body.mass);
        visit_each(body.inertia, visit);
    }
    visit_each(model.gravity, visit);
    numbers_of_set(model.constraints, visit);
    numbers_of_set(model.coordinates, visit);
    if (loads) numbers_of_loads(*loads, visit);
    for (auto& driven : model.driven) visit(driven.start);
    for (auto& flywheel : model.flywheels) visit(flywheel);
    numbers_of_programs(model.programs, visit);
}

template <class Number, int Rows, int Columns> Matrix<Rows, Columns, Number> with(const Matrix<Rows, Columns>& from) {
    Matrix<Rows, Columns, Number> to;
    std::copy(from.begin(), from.end(), to.begin());
    return to;
}

template <class Number, class D> PrimitiveSet<With<D, Number>> with(const PrimitiveSet<D>& from) {
    PrimitiveSet<With<D, Number>> to;
    to.rows = from.rows;
    for (const Attachment<D>& a : from.attachments)
        to.attachments.push_back({a.body, a.is_point, with<Number>(a.local), a.size});
    for (const Instance<D>& p : from.instances) {
        Instance<With<D, Number>> own{
            p.kind,    {},      p.slot_count, {},      p.row,  p.rows, p.offset,   p.weight,
            p.coupled, p.curve, p.line,       p.other, p.wire, p.path, p.follower, p.other_follower};
        std::copy(std::begin(p.slots), std::end(p.slots), own.slots);
        std::copy(std::begin(p.parameters), std::end(p.parameters), own.parameters);
        to.instances.push_back(own);
    }
    return to;
}

template <class Number, class D> Loads<With<D, Number>> with(const Loads<D>& from) {
    Loads<With<D, Number>> to{with<Number>(from.coordinates), {}, {}, {}};
    for (const Law<D>& law : from.laws)
        to.laws.push_back({law.coordinate, law.stiffness, law.damping, law.free, law.program, law.loses, law.bearing,
                           law.apart, law.partner, law.own, law.other});
    for (const BodyForce<D>& f : from.on_bodies)
        to.on_bodies.push_back({f.body,
                                with<Number>(f.point),
                                f.is_torque,
                                f.in_body,
                                with<Number>(f.force_map),
                                with<Number>(f.torque_map),
                                {f.programs[0], f.programs[1], f.programs[2]}});
    for (const Bushing<D>& b : from.bushings)
        to.bushings.push_back({{b.body[0], b.body[1]},
                               {with<Number>(b.origin[0]), with<Number>(b.origin[1])},
                               {with<Number>(b.turn[0]), with<Number>(b.turn[1])},
                               with<Number>(b.stiffness),
                               with<Number>(b.damping),
                               with<Number>(b.preload),
                               with<Number>(b.map),
                               b.turns_freely,
                               b.sees_pose});
    return to;
}

template <class Number> ProgramsOf<Number> with(const Programs& from) {
    const auto all = [](const std::vector<double>& own) { return std::vector<Number>(own.begin(), own.end()); };
    return {from.start,       from.op,         from.operand, all(from.constant), from.table_start, from.knot,
            all(from.origin), all(from.piece), from.kinked,  from.period,        from.variables};
}

// The model with numbers of this type, which still have the same values; without contacts and bearings.
template <class Number, class D> Model<With<D, Number>> with(const Model<D>& from) {
    Model<With<D, Number>> to;
    for (const Body<D>& body : from.bodies)
        to.bodies.push_back({body.mass, with<Number>(body.inertia), with<Number>(body.inverse_root), body.is_light});
    to.gravity = with<Number>(from.gravity);
    to.constraints = with<Number>(from.constraints);
    to.coordinates = with<Number>(from.coordinates);
    to.joints = from.joints, to.counts_turns = from.counts_turns;
    to.row_scale.assign(from.row_scale.begin(), from.row_scale.end());
    to.length = from.length;
    const auto& pivots = from.rows.pivots;
    to.rows = {from.rows.redundant, from.rows.left_out, {pivots.begin(), pivots.end()}, from.rows.even};
    if (from.loads) to.loads = std::make_shared<const Loads<With<D, Number>>>(with<Number>(*from.loads));
    for (const DrivenRow<D>& row : from.driven)
        to.driven.push_back({row.row, row.is_angle, row.start, row.coordinate, row.program});
    to.couplings = from.couplings, to.curves = from.curves;
    to.programs = with<Number>(from.programs), to.first_rate = from.first_rate;
    to.channels = from.channels, to.switches = from.switches, to.layout = from.layout;
    to.flywheels.assign(from.flywheels.begin(), from.flywheels.end());
    to.thresholds = from.thresholds;
    return to;
}

}  // namespace mbproj
