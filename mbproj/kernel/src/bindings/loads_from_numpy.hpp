// From NumPy arrays to functions, forces and motions.
#pragma once

#include "bindings/from_numpy.hpp"
#include "kinematics/loads.hpp"
#include "model/switches.hpp"

namespace mbproj {

inline std::vector<int> indices(Record& given, std::size_t below, const char* name) {
    std::vector<int> found;
    const auto array = given.take<Integers1>(name);
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

inline Programs programs(Record& given) {
    Programs built;
    const auto op = given.take<Integers1>("op");
    const auto operand = given.array<Numbers1>("operand", {op.size()});
    built.start = indices(given, op.size() + 1, "start");
    for (std::size_t i = 0; i < op.size(); ++i) {
        built.op.push_back(static_cast<Op>(index_below(op.data()[i], op_count, "op")));
        const bool is_constant = built.op[i] == Op::constant;
        built.operand.push_back(is_constant ? 0.0 : operand.data()[i]);
        built.constant.push_back(is_constant ? operand.data()[i] : 0.0);
    }
    const auto knot = given.take<Numbers1>("knot");  // the first of each table that does not repeat is -infinity
    const auto piece = given.array<Numbers2>("piece", {knot.size(), 4});
    const auto kinked = given.array<Integers1>("kinked", {knot.size()});
    built.table_start = indices(given, knot.size() + 1, "table_start");
    built.knot.assign(knot.data(), knot.data() + knot.size());
    built.origin = given.numbers("origin", knot.size());
    built.piece.assign(piece.data(), piece.data() + piece.size());
    for (std::size_t i = 0; i < kinked.size(); ++i) built.kinked.push_back(kinked.data()[i] != 0);
    if (built.start.empty() || built.table_start.empty()) refuse("start", "is empty");
    if (!std::is_sorted(built.start.begin(), built.start.end()) ||
        !std::is_sorted(built.table_start.begin(), built.table_start.end()))
        refuse("start", "does not increase");
    built.period = given.numbers("period", built.table_start.size() - 1);
    built.variables = given.take<int>("variables");
    check_stack(built, built.table_start.size() - 1);
    return built;
}

// Checks that programs name only variables that exist.
inline void require_variables(const Programs& programs, int variables, const char* name) {
    if (programs.variables > variables) refuse(name, "have variables that are not there");
}

template <class D> Loads<D> loads(Record& given) {
    constexpr int W = Size<D>::turns;
    const auto& coordinates = given.object<PrimitiveSet<D>>("coordinates");
    const auto bodies = given.take<std::size_t>("bodies");
    const std::size_t laws = coordinates.instances.size(), count = 1u << 30;
    const auto of_laws = [&](const char* name) { return given.array<Integers1>(name, {laws}); };
    const auto joint_coordinate = of_laws("joint_coordinate"), law_program = of_laws("law_program"),
               law_loses = of_laws("law_loses"), law_bearing = of_laws("law_bearing"), law_apart = of_laws("law_apart"),
               law_partner = of_laws("law_partner");
    const auto law = given.array<Numbers2>("law", {laws, 3});
    const auto law_sliding = given.array<Numbers2>("law_sliding", {laws, 2});
    const auto body = given.take<Integers1>("body");
    const std::size_t forces = body.size();
    const auto point = given.array<Numbers2>("point", {forces, D::axes});
    const auto is_torque = given.array<Integers1>("is_torque", {forces});
    const auto in_body = given.array<Integers1>("in_body", {forces});
    const auto force_map = given.array<Numbers3>("force_map", {forces, D::axes, 3});
    const auto torque_map = given.array<Numbers3>("torque_map", {forces, W, 3});
    const auto program = given.array<Integers2>("program", {forces, 3});
    Loads<D> built{coordinates, {}, {}, given.object<Bushings<D>>("bushings").each};
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
    for (std::size_t f = 0; f < forces; ++f) {
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
template <class D> void check_loads(const Model<D>& model) {
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
        if (law.bearing >= static_cast<int>(model.bearings.size()))
            refuse("loads", "have a bearing that the model does not");
    }
}

// The variables of programs: the kind and the number of each channel.
template <class D> void add_channels(Record& given, Model<D>& model) {
    const auto channels = given.array<Integers2>("channels", {any_length, 2});
    for (std::size_t c = 0; c < channels.shape(0); ++c) {
        const int kind = index_below(channels.data()[2 * c], 3, "channels");
        const std::size_t below = kind == 0 ? model.layout.states.size : model.coordinates.instances.size();
        model.channels.push_back(
            {static_cast<ChannelKind>(kind), index_below(channels.data()[2 * c + 1], below, "channels")});
    }
    require_variables(model.programs, law_variables + static_cast<int>(channels.shape(0)), "programs");
}

// Switches (program, instruction), program after program in the order of their instructions.
template <class D> void add_switches(Record& given, Model<D>& model) {
    const auto switches = given.array<Integers2>("switches", {any_length, 2});
    const Programs& programs = model.programs;
    for (std::size_t k = 0; k < switches.shape(0); ++k) {
        const int p = index_below(switches.data()[2 * k], programs.size(), "switches");
        const int at = index_below(switches.data()[2 * k + 1], programs.op.size(), "switches");
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
template <class D> void add_flywheels(Record& given, Model<D>& model) {
    if (!given.has("flywheels")) return;
    const auto inertia = given.take<std::vector<double>>("flywheels");
    const auto& coordinates = given.object<PrimitiveSet<D>>("flywheel_coordinates");
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
template <class D> std::vector<Bearing<D>> bearings(Record& given, const Model<D>& model) {
    const auto numbers = given.take<std::vector<BearingNumbers>>("bearings");
    const auto points = given.array<Numbers2>("bearing_points", {numbers.size(), D::axes});
    const auto axes = given.array<Numbers2>("bearing_axes", {numbers.size(), D::axes});
    std::vector<Bearing<D>> found;
    for (const auto& [joint, body, radial, axial, length, preload, parts] : numbers) {
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
template <class D> void add_stops(Record& given, Model<D>& model) {
    if (!given.has("stop_coordinates")) return;
    const auto& coordinates = given.object<PrimitiveSet<D>>("stop_coordinates");
    const auto turns = given.take<std::vector<int>>("stop_turns");
    const auto bounds = given.take<std::vector<double>>("stop_bounds");
    const std::size_t count = coordinates.instances.size();
    if (turns.size() != count || bounds.size() != count) refuse("stop_coordinates", "do not fit their bounds");
    for (const int number : turns)
        if (number != -1) index_below(number, model.coordinates.instances.size(), "stop_turns");
    for (const Attachment<D>& a : coordinates.attachments)
        if (a.body > model.size()) refuse("stop_coordinates", "have a body that the model does not");
    for (const double bound : bounds)
        if (!std::isfinite(bound)) refuse("stop_bounds", "hold a number that is not finite");
    model.stop_coordinates = coordinates, model.stops = {turns, bounds};
}

// The last rows of the constraints, one for each function of time: the last programs.
template <class D> std::vector<DrivenRow<D>> driven_rows(Record& given, const Model<D>& model) {
    const auto start = given.take<std::vector<double>>("motion_start", {});
    const auto coordinate = given.take<std::vector<int>>("motion_coordinate", {});
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

template <class D> void add_couplings(Record& given, Model<D>& model) {
    for (const auto& [row, period, own, weights, program, growth] :
         given.take<std::vector<CouplingNumbers>>("couplings", {})) {
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
