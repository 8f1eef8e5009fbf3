// The structure on which a run depends besides its model's numbers: slopes compare only models of the same structure.
#pragma once

#include <vector>

#include "model/model.hpp"
#include "solver/model_numbers.hpp"

namespace mbproj {

class Structure {
public:
    template <class... Numbers> void add(const Numbers&... numbers) {
        (found_.push_back(static_cast<double>(numbers)), ...);
    }
    template <class Numbers> void add_all(const Numbers& numbers) {
        add(numbers.size());
        for (const auto& number : numbers) add(number);
    }
    template <class D> void add_set(const PrimitiveSet<D>& set) {
        add(set.rows);
        for (const Attachment<D>& a : set.attachments) add(a.body, a.is_point);
        for (const Instance<D>& p : set.instances) {
            add(static_cast<int>(p.kind), p.slot_count, p.row, p.rows, p.coupled, p.curve, p.follower,
                p.other_follower);
            for (int k = 0; k < p.slot_count; ++k) add(p.slots[k]);
            for (const auto& line : {p.line, p.other})
                if (line) add_line(*line);
            if (p.wire) add_wire(*p.wire);
            if (p.path) add_path(*p.path);
        }
    }
    // Constants and pieces are numbers; knots, periods, and the exponents of powers belong here.
    template <class Number> void add_programs(const ProgramsOf<Number>& programs) {
        add_all(programs.start), add_all(programs.table_start), add_all(programs.knot), add_all(programs.kinked);
        add_all(programs.period);
        for (std::size_t at = 0; at < programs.op.size(); ++at)
            add(static_cast<int>(programs.op[at]), programs.operand[at]);
    }
    template <class D> void add_loads(const Loads<D>& loads) {
        add_set(loads.coordinates);
        for (const Law<D>& law : loads.laws)
            add(law.coordinate, law.program, law.loses, law.bearing, law.apart, law.partner, law.own, law.other);
        for (const BodyForce<D>& f : loads.on_bodies)
            add(f.body, f.is_torque, f.in_body, f.programs[0], f.programs[1], f.programs[2]);
        for (const Bushing<D>& b : loads.bushings) {
            add(b.body[0], b.body[1], b.turns_freely, b.sees_pose);
            for (const double number : b.map) add(number);
        }
    }
    std::vector<double> take() { return std::move(found_); }

private:
    void add_line(const PlaneCurve& line) {
        for (const PlaneCurve::Piece& piece : line.pieces) {
            add(piece.start, piece.origin, static_cast<int>(piece.form));
            for (int k = 0; k < PlaneCurve::numbers; ++k) add(piece.f[k], piece.g[k]);
        }
        add(line.end, line.closed);
    }
    void add_wire(const SpaceCurve& wire) {
        for (const SpaceCurve::Piece& piece : wire.pieces) {
            add(piece.start, piece.origin);
            for (const auto& row : piece.c)
                for (const double number : row) add(number);
        }
        add(wire.end, wire.closed);
    }
    void add_path(const RopePath& path) {
        add_all(path.radii), add_all(path.directions), add_all(path.by_length), add_all(path.by_angle),
            add_all(path.lifts);
        add(path.wound);
    }

    std::vector<double> found_;
};

template <class D> std::vector<double> structure_of(const Model<D>& model) {
    Structure found;
    for (const Body<D>& body : model.bodies) found.add(body.is_light);
    found.add_set(model.constraints), found.add_set(model.coordinates);
    for (const Joint& joint : model.joints) found.add(joint.begin, joint.end, joint.row, joint.rows);
    if (model.loads) found.add_loads(*model.loads);
    for (const DrivenRow<D>& row : model.driven) found.add(row.row, row.is_angle, row.coordinate, row.program);
    for (const Coupling& coupling : model.couplings)
        found.add(coupling.row, coupling.period, coupling.growth, coupling.curve, coupling.rolls);
    for (const Curve& curve : model.curves)
        found.add(curve.instance, curve.program, static_cast<int>(curve.of), curve.second);
    found.add_programs(model.programs);
    for (const Channel& channel : model.channels) found.add(static_cast<int>(channel.kind), channel.index);
    found.add(model.first_rate, model.flywheels.size(), model.layout.size());
    return found.take();
}

}  // namespace mbproj
