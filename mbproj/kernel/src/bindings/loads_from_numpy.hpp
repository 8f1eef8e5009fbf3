// From NumPy arrays to functions, forces and motions.
#pragma once

#include "bindings/bushings_from_numpy.hpp"
#include "kinematics/loads.hpp"
#include "model/switches.hpp"

namespace mbproj {

inline std::vector<int> indices(const Integers1& array, std::size_t below, const char* name) {
    std::vector<int> found;
    for (std::size_t i = 0; i < array.size(); ++i) found.push_back(index_below(array.data()[i], below, name));
    return found;
}

// An index, or -1 for none.
inline int optional_index(int64_t index, std::size_t below, const char* name) {
    return index == -1 ? -1 : index_below(index, below, name);
}

// The stack of a program must hold its arguments at every step, and one value at the end.
inline void check_stack(const Programs& programs, std::size_t tables) {
    for (std::size_t p = 0; p + 1 < programs.start.size(); ++p) {
        int depth = 0;
        for (int at = programs.start[p]; at < programs.start[p + 1]; ++at) {
            const int taken = arguments(programs.op[at]);
            if (depth < taken || depth - taken + 1 > deepest_stack)
                refuse("op", "has a stack that is too small or too deep");
            depth += 1 - taken;
            const double operand = programs.operand[at];
            if (programs.op[at] == Op::variable && !(operand >= 0.0 && operand < programs.variables))
                refuse("operand", "names no variable");
            if (programs.op[at] == Op::table && !(operand >= 0.0 && operand < static_cast<double>(tables)))
                refuse("operand", "names no table");
        }
        if (depth != 1) refuse("op", "leaves not one value");
    }
}

inline Programs programs(const Integers1& start, const Integers1& op, const Numbers1& operand,
                         const Integers1& table_start, const Numbers1& knot, const Numbers1& origin,
                         const Numbers2& piece, const Integers1& kinked, const Numbers1& period, int variables) {
    Programs built;
    built.start = indices(start, op.size() + 1, "start");
    for (std::size_t i = 0; i < op.size(); ++i)
        built.op.push_back(static_cast<Op>(index_below(op.data()[i], op_count, "op")));
    require(operand, {op.size()}, "operand");
    for (std::size_t i = 0; i < op.size(); ++i) {
        const bool is_constant = built.op[i] == Op::constant;
        built.operand.push_back(is_constant ? 0.0 : operand.data()[i]);
        built.constant.push_back(is_constant ? operand.data()[i] : 0.0);
    }
    built.table_start = indices(table_start, knot.size() + 1, "table_start");
    built.knot.assign(knot.data(),
                      knot.data() + knot.size());  // the first knot of each table that does not repeat is -infinity
    built.origin = numbers(origin, "origin");
    require(piece, {knot.size(), 4}, "piece");
    if (origin.size() != knot.size()) refuse("origin", "has a wrong shape");
    built.piece.assign(piece.data(), piece.data() + piece.size());
    if (built.start.empty() || built.table_start.empty()) refuse("start", "is empty");
    if (!std::is_sorted(built.start.begin(), built.start.end()) ||
        !std::is_sorted(built.table_start.begin(), built.table_start.end()))
        refuse("start", "does not increase");
    if (kinked.size() != knot.size()) refuse("kinked", "has a wrong shape");
    for (std::size_t i = 0; i < kinked.size(); ++i) built.kinked.push_back(kinked.data()[i] != 0);
    built.period = numbers(period, "period");
    require(period, {built.table_start.size() - 1}, "period");
    built.variables = variables;
    check_stack(built, built.table_start.size() - 1);
    return built;
}

// Checks that programs name only variables that exist.
inline void require_variables(const Programs& programs, int variables, const char* name) {
    if (programs.variables > variables) refuse(name, "have variables that are not there");
}

template <class D> Loads<D> loads(std::size_t bodies, const PrimitiveSet<D>& coordinates,
                                  const Integers1& joint_coordinate, const Numbers2& law, const Integers1& law_program,
                                  const Integers1& law_loses, const Integers1& law_bearing, const Integers1& law_apart,
                                  const Integers1& law_partner, const Numbers2& law_sliding, const Integers1& body,
                                  const Numbers2& point, const Integers1& is_torque, const Integers1& in_body,
                                  const Numbers3& force_map, const Numbers3& torque_map, const Integers2& program,
                                  const Bushings<D>& bushings) {
    constexpr int W = Size<D>::turns;
    const std::size_t laws = coordinates.instances.size(), given = body.size(), count = 1u << 30;
    require(joint_coordinate, {laws}, "joint_coordinate");
    require(law, {laws, 3}, "law");
    require(law_program, {laws}, "law_program");
    require(law_loses, {laws}, "law_loses");
    require(law_bearing, {laws}, "law_bearing");
    require(law_apart, {laws}, "law_apart");
    require(law_partner, {laws}, "law_partner");
    require(law_sliding, {laws, 2}, "law_sliding");
    require(point, {given, D::axes}, "point");
    require(is_torque, {given}, "is_torque");
    require(in_body, {given}, "in_body");
    require(force_map, {given, D::axes, 3}, "force_map");
    require(torque_map, {given, W, 3}, "torque_map");
    require(program, {given, 3}, "program");
    Loads<D> built{coordinates, {}, {}, bushings.each};
    int apart = 0;
    for (std::size_t l = 0; l < laws; ++l) {
        const double* numbers = law.data() + 3 * l;
        const int coordinate = optional_index(joint_coordinate.data()[l], 1u << 30, "joint_coordinate");
        if (coordinate < 0 && is_angle(coordinates.instances[l].kind))
            refuse("joint_coordinate", "leaves an angle out");
        const int function = optional_index(law_program.data()[l], count, "law_program");
        const int bearing = optional_index(law_bearing.data()[l], 1u << 30, "law_bearing");
        const int own = law_apart.data()[l] != 0 ? apart++ : -1;
        const int partner = optional_index(law_partner.data()[l], laws, "law_partner");
        built.laws.push_back({coordinate, numbers[0], numbers[1], numbers[2], function, law_loses.data()[l] != 0,
                              bearing, own, partner, law_sliding.data()[2 * l], law_sliding.data()[2 * l + 1]});
    }
    for (std::size_t f = 0; f < given; ++f) {
        BodyForce<D> force;
        force.body = index_below(body.data()[f], bodies + 1, "body");
        force.point = matrix_at<D::axes>(point.data() + D::axes * f);
        force.is_torque = is_torque.data()[f] != 0;
        force.in_body = in_body.data()[f] != 0;
        force.force_map = matrix_by_rows<D::axes, 3>(force_map.data() + 3 * D::axes * f);
        force.torque_map = matrix_by_rows<W, 3>(torque_map.data() + 3 * W * f);
        for (int k = 0; k < 3; ++k) force.programs[k] = index_below(program.data()[3 * f + k], count, "program");
        built.on_bodies.push_back(force);
    }
    return built;
}

// Checks that loads name the model's bodies, joint coordinates, and the programs before the rates of states.
template <class D> void check_loads(const Model<D>& model, std::size_t bearings) {
    const Loads<D>* loads = model.loads.get();
    const int bodies = model.size(), coordinates = static_cast<int>(model.coordinates.instances.size());
    if (!loads) return;
    for (const Attachment<D>& a : loads->coordinates.attachments)
        if (a.body > bodies) refuse("loads", "have a body that the model does not");
    for (const BodyForce<D>& force : loads->on_bodies)
        if (force.body > bodies) refuse("loads", "have a body that the model does not");
    for (const BodyForce<D>& force : loads->on_bodies)
        for (const int program : force.programs)
            if (program >= model.first_rate) refuse("loads", "have a program that the model does not");
    for (const Bushing<D>& bushing : loads->bushings)
        for (const int body : bushing.body)
            if (body > bodies) refuse("loads", "have a body that the model does not");
    for (const Law<D>& law : loads->laws) {
        if (law.coordinate >= coordinates) refuse("loads", "have a coordinate that the model does not");
        if (law.program >= model.first_rate) refuse("loads", "have a program that the model does not");
        if (law.bearing >= static_cast<int>(bearings)) refuse("loads", "have a bearing that the model does not");
    }
}

// The variables of programs: the kind and the number of each channel.
template <class D> void add_channels(Model<D>& model, const Integers2& channels) {
    require(channels, {channels.shape(0), 2}, "channels");
    for (std::size_t c = 0; c < channels.shape(0); ++c) {
        const int kind = index_below(channels.data()[2 * c], 3, "channels");
        const std::size_t below = kind == 0 ? model.layout.states.size : model.coordinates.instances.size();
        model.channels.push_back(
            {static_cast<ChannelKind>(kind), index_below(channels.data()[2 * c + 1], below, "channels")});
    }
    require_variables(model.programs, law_variables + static_cast<int>(channels.shape(0)), "programs");
}

// Switches (program, instruction), program after program in the order of their instructions.
template <class D> void add_switches(Model<D>& model, const Integers2& given) {
    require(given, {given.shape(0), 2}, "switches");
    const Programs& programs = model.programs;
    for (std::size_t k = 0; k < given.shape(0); ++k) {
        const int p = index_below(given.data()[2 * k], programs.size(), "switches");
        const int at = index_below(given.data()[2 * k + 1], programs.op.size(), "switches");
        if (at < programs.start[p] || at >= programs.start[p + 1] || !is_switching(programs.op[at]))
            refuse("switches", "hold what is no switch of its program");
        if (k > 0 && model.switches.back().at >= at) refuse("switches", "do not increase");
        int law = -1, curve = -1;
        for (std::size_t l = 0; model.loads && l < model.loads->laws.size(); ++l)
            if (model.loads->laws[l].program == p) law = static_cast<int>(l);
        for (std::size_t c = 0; c < model.curves.size(); ++c)
            if (model.curves[c].program == p) curve = static_cast<int>(c);
        model.switches.push_back({p, at, law, curve});
    }
}

// Flywheels that coordinates turn: their rows follow those of C, and each is a joint of its own.
template <class D>
void add_flywheels(Model<D>& model, const PrimitiveSet<D>& coordinates, const std::vector<double>& inertia) {
    PrimitiveSet<D>& set = model.constraints;
    const int slots = static_cast<int>(set.attachments.size()), rows = set.rows;
    if (coordinates.instances.size() != inertia.size() || coordinates.rows != static_cast<int>(inertia.size()))
        refuse("flywheels", "does not fit its coordinates");
    set.attachments.insert(set.attachments.end(), coordinates.attachments.begin(), coordinates.attachments.end());
    for (Instance<D> p : coordinates.instances) {
        for (int s = 0; s < p.slot_count; ++s) p.slots[s] += slots;
        p.row += rows;
        set.instances.push_back(p);
        const int last = static_cast<int>(set.instances.size());
        model.joints.push_back(joint_of(set, model.size(), last - 1, last));
    }
    for (const double I : inertia) require_positive(I, "flywheels");
    model.flywheels = inertia;
    model.row_scale.resize(model.all_rows(), 1.0);
}

// A bearing: its joint and body 2; its arms, its length and its preload; joints, the number of one of their rows, and its part.
using BearingNumbers = std::tuple<int, int, double, double, double, double, std::vector<std::tuple<int, int, double>>>;

// The bearings; points and axes are in the axes of the bodies.
template <class D> std::vector<Bearing<D>> bearings(const Model<D>& model, const std::vector<BearingNumbers>& given,
                                                    const Numbers2& points, const Numbers2& axes) {
    require(points, {given.size(), D::axes}, "bearing_points");
    require(axes, {given.size(), D::axes}, "bearing_axes");
    std::vector<Bearing<D>> found;
    for (const auto& [joint, body, radial, axial, length, preload, parts] : given) {
        const std::size_t at = D::axes * found.size();
        std::vector<std::pair<int, double>> rows;
        for (const auto& [number, row, part] : parts) {
            const Joint& own = model.joints[index_below(number, model.joints.size(), "bearings")];
            rows.emplace_back(own.row + index_below(row, own.rows, "bearings"), part);
        }
        found.push_back({index_below(joint, model.joints.size(), "bearings"),
                         index_below(body, model.bodies.size() + 1, "bearings"), matrix_at<D::axes>(points.data() + at),
                         matrix_at<D::axes>(axes.data() + at), radial, axial, length, preload, std::move(rows)});
    }
    return found;
}

// The coordinates that stops limit, one instance each.
template <class D> void add_stops(Model<D>& model, const PrimitiveSet<D>& coordinates, const std::vector<int>& turns,
                                  std::vector<double> bounds) {
    const std::size_t count = coordinates.instances.size();
    if (turns.size() != count || bounds.size() != count) refuse("stop_coordinates", "do not fit their bounds");
    for (const int number : turns)
        if (number != -1) index_below(number, model.coordinates.instances.size(), "stop_turns");
    for (const Attachment<D>& a : coordinates.attachments)
        if (a.body > model.size()) refuse("stop_coordinates", "have a body that the model does not");
    for (const double bound : bounds)
        if (!std::isfinite(bound)) refuse("stop_bounds", "hold a number that is not finite");
    model.stops = {coordinates, turns, std::move(bounds)};
}

// The last rows of the constraints, one for each function of time: the last programs.
template <class D> std::vector<DrivenRow<D>> driven_rows(const Model<D>& model, const std::vector<double>& start,
                                                         const std::vector<int>& coordinate) {
    std::vector<DrivenRow<D>> rows;
    const PrimitiveSet<D>& set = model.constraints;
    const std::size_t count = start.size(), instances = set.instances.size(), programs = model.programs.size();
    if (count > instances || count > programs) refuse("motion_start", "does not fit the motions");
    if (coordinate.size() != count) refuse("motion_coordinate", "does not fit the motions");
    for (std::size_t k = 0; k < count; ++k) {
        const Instance<D>& p = set.instances[instances - count + k];
        if (p.rows != 1) refuse("constraints", "has a driven row that is not one");
        if (!std::isfinite(start[k])) refuse("motion_start", "holds a number that is not finite");
        const int program = static_cast<int>(programs - count + k);
        if (model.programs.names(program, 1)) refuse("programs", "have a motion that is no function of the time");
        rows.push_back({p.row, is_angle(p.kind), start[k],
                        index_below(coordinate[k], model.coordinates.instances.size(), "motion_coordinate"), program});
    }
    return rows;
}

// Whether a law acts on an angle.
template <class D> bool has_angles(const Loads<D>* loads) {
    if (!loads) return false;
    const auto& instances = loads->coordinates.instances;
    return std::any_of(instances.begin(), instances.end(), [](const Instance<D>& p) { return is_angle(p.kind); });
}

// A row that couples coordinates: its number, its period, the coordinates, their weights, its program, or -1, and the change of
// the program by a turn.
using CouplingNumbers = std::tuple<int, double, std::vector<int>, std::vector<double>, int, double>;

template <class D> void add_couplings(Model<D>& model, const std::vector<CouplingNumbers>& given) {
    for (const auto& [row, period, own, weights, program, growth] : given) {
        if (own.size() != weights.size() || own.empty()) refuse("couplings", "do not fit their weights");
        for (const int coordinate : own) index_below(coordinate, model.coordinates.instances.size(), "couplings");
        for (const double weight : weights)
            if (!std::isfinite(weight)) refuse("couplings", "hold a number that is not finite");
        if (!(period >= 0.0)) refuse("couplings", "have a period that is negative");
        if (!std::isfinite(growth)) refuse("couplings", "hold a number that is not finite");
        model.couplings.push_back(
            {index_below(row, model.constraints.rows, "couplings"), period, own, weights, growth, -1, false});
        for (const int coordinate : own)
            if (model.coordinates.instances[coordinate].kind == Kind::lap) model.couplings.back().rolls = true;
        if (model.couplings.back().rolls && own.size() != 2) refuse("couplings", "roll without a roller");
        if (program == -1) continue;
        model.couplings.back().curve = static_cast<int>(model.curves.size());
        if (model.programs.names(index_below(program, model.programs.size(), "couplings"), 2))
            refuse("programs", "have a coupling that is no function of its first coordinate");
        for (std::size_t i = 0; i < model.constraints.instances.size(); ++i)
            if (Instance<D>& p = model.constraints.instances[i]; p.row == row && p.rows == 1) {
                p.curve = model.couplings.back().curve;
                model.curves.push_back({static_cast<int>(i), program});
            }
    }
}

}  // namespace mbproj
