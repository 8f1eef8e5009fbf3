#include "bind/functions.hpp"

#include <cmath>
#include <iterator>

#include <nanobind/stl/tuple.h>

#include "bind/from_numpy.hpp"

namespace mbproj {

namespace {

// The stack of a program must hold its arguments at every step, and one value at the end.
void check_stack(const Record& given, const Programs& programs) {
    const auto tables = static_cast<double>(programs.table_start.size() - 1);
    for (int p = 0; p < programs.size(); ++p) {
        int depth = 0;
        for (int at = programs.start[p]; at < programs.start[p + 1]; ++at) {
            const int taken = arguments(programs.op[at]);
            if (depth < taken || depth - taken + 1 > deepest_stack)
                given.refuse("op", "has a stack that is too small or too deep");
            depth += 1 - taken;
            const double operand = programs.operand[at];
            if (programs.op[at] == Op::variable && !(operand >= 0.0 && operand < programs.variables))
                given.refuse("operand", "names no variable");
            if (programs.op[at] == Op::table && !(operand >= 0.0 && operand < tables))
                given.refuse("operand", "names no table");
        }
        if (depth != 1) given.refuse("op", "leaves not one value");
    }
}

// Starts of runs from the first of `size` entries, in ascending order.
std::vector<int> starts(Record& given, const char* name, std::size_t size) {
    std::vector<int> found = given.indices(name, {Record::any}, size + 1).values;
    if (found.empty()) given.refuse(name, "is empty");
    if (!std::is_sorted(found.begin(), found.end())) given.refuse(name, "does not increase");
    return found;
}

// A curve of these pieces and places, in their order. Each piece has places at both of its ends.
template <class Curve> Curve curve_of(Record& curve, Record& thresholds, std::vector<typename Curve::Piece> pieces,
                                      std::vector<typename Curve::Place> places) {
    Curve built{};
    built.pieces = std::move(pieces);
    built.places = std::move(places);
    built.end = curve.number("end");
    built.closed = curve.flag("closed");
    built.settled = curve.number("settled");
    built.reach = curve.number("reach");
    built.passes = static_cast<int>(thresholds.positive("most_passes"));
    if (built.pieces.empty() || built.places.size() < 2) curve.refuse("pieces", "are none");
    for (auto& piece : built.pieces) piece.first = piece.last = -1;
    for (std::size_t i = 0; i < built.places.size(); ++i) {
        auto& piece = built.pieces[built.places[i].piece];
        if (piece.first < 0) piece.first = static_cast<int>(i);
        piece.last = static_cast<int>(i);
    }
    for (std::size_t i = 0; i < built.pieces.size(); ++i) {
        const auto& piece = built.pieces[i];
        if (piece.first < 0 || piece.last <= piece.first) curve.refuse("places", "leave a piece out");
        if (!((i + 1 < built.pieces.size() ? built.pieces[i + 1].start : built.end) > piece.start))
            curve.refuse("pieces", "do not increase");
    }
    return built;
}

Programs programs(Record& given) {
    Record functions = given.part("functions");
    return programs_of(functions);
}

PlaneCurve plane_curve(Record& given) {
    using Piece = PlaneCurve::Piece;
    using Place = PlaneCurve::Place;
    constexpr int numbers = PlaneCurve::numbers;
    Record curve = given.part("curve");
    Columns<Piece> pieces(curve.part("arrays"));
    pieces("start", &Piece::start)("origin", &Piece::origin).index("form", &Piece::form, 3);
    pieces.each("numbers", {pieces.count(), 2, numbers}, [](Piece& piece, const double* from) {
        const auto terms = [](const double* c) {
            int found = PlaneCurve::terms;
            while (found > 0 && c[found - 1] == 0.0) --found;
            return found;
        };
        std::copy_n(from, numbers, piece.f), std::copy_n(from + numbers, numbers, piece.g);
        piece.f_terms = terms(piece.f), piece.g_terms = terms(piece.g);
    });
    Columns<Place> places(curve.part("places"));
    places("s", &Place::s)("length", &Place::length)("angle", &Place::angle);
    places.index("piece", &Place::piece, pieces.count());
    places.each("point", {places.count(), 2}, [](Place& place, const double* from) {
        place.x = from[0], place.y = from[1];
        place.cosine = std::cos(place.angle), place.sine = std::sin(place.angle);
    });
    Record thresholds = given.part("thresholds");
    auto built = curve_of<PlaneCurve>(curve, thresholds, std::move(pieces.items), std::move(places.items));
    built.straight = thresholds.positive("rounding");
    built.beyond = thresholds.positive("place_turn");
    for (std::size_t i = 1; i < built.places.size(); ++i) {
        const Place &place = built.places[i], &before = built.places[i - 1];
        built.stride = std::max(built.stride, std::hypot(place.x - before.x, place.y - before.y));
    }
    built.side = built.places.back().angle < built.places.front().angle ? -1.0 : 1.0;
    built.runs = built.turning_runs();
    return built;
}

SpaceCurve space_curve(Record& given) {
    using Piece = SpaceCurve::Piece;
    using Place = SpaceCurve::Place;
    Record curve = given.part("curve");
    Columns<Piece> pieces(curve);
    pieces("starts", &Piece::start)("origins", &Piece::origin)("coefficients", &Piece::c)("axes", &Piece::axis);
    Columns<Place> places(curve.part("places"));
    places("s", &Place::s)("point", &Place::point)("length", &Place::length);
    places.index("piece", &Place::piece, pieces.count());
    Record thresholds = given.part("thresholds");
    return curve_of<SpaceCurve>(curve, thresholds, std::move(pieces.items), std::move(places.items));
}

}  // namespace

Programs programs_of(Record& given) {
    Programs built;
    const std::vector<int> ops = given.indices("op", {Record::any}, op_count).values;
    built.operand = given.numbers("operand", ops.size());
    for (const int op : ops) {
        double& operand = built.operand[built.op.size()];
        built.op.push_back(static_cast<Op>(op));
        built.constant.push_back(built.op.back() == Op::constant ? std::exchange(operand, 0.0) : 0.0);
    }
    built.start = starts(given, "start", ops.size());
    built.knot = given.array("knot", {Record::any}, false).values;  // a table that does not repeat begins at -infinity
    const std::size_t pieces = built.knot.size();
    built.table_start = starts(given, "table_start", pieces);
    built.origin = given.numbers("origin", pieces);
    built.piece = given.array("piece", {pieces, 4}).values;
    for (const double kinked : given.numbers("kinked", pieces)) built.kinked.push_back(kinked != 0.0);
    built.period = given.numbers("period", built.table_start.size() - 1);
    built.variables = given.index("variables", 1u << 30);
    check_stack(given, built);
    return built;
}

RopePath rope_path_of(Record& given) {
    RopePath path;
    path.radii = given.numbers("radii");
    const std::size_t centres = path.radii.size();
    if (centres < 2 || centres > most_centres) given.refuse("radii", "has a wrong shape");
    path.directions = given.numbers("directions", centres - 1);
    path.by_length = given.numbers("by_length", centres - 1);
    path.by_angle = given.numbers("by_angle", centres - 1);
    path.lifts.assign(centres, 0.0);
    for (const int circle : given.indices("lifts", {Record::any}, centres).values) path.lifts[circle] = 1.0;
    path.wound = given.number("wound");
    for (const double angle : path.directions) {
        path.cosine.push_back(std::cos(angle));
        path.sine.push_back(std::sin(angle));
    }
    return path;
}

void bind_functions(nb::module_& m) {
    record_class(m, "Programs", &programs)
        .def("run", [](const Programs& self, int program, double t, double s, double s_dot) {
            index_below(program, self.size(), "program");
            require_variables(self, law_variables, "program");
            const Series<double> variables[law_variables] = {{t, 1.0, 0.0}, {s, 0.0, 0.0}, {s_dot, 0.0, 0.0}};
            const Series<double> found = self.run(program, variables);
            return std::make_tuple(found.x, found.d, found.dd);
        });
    record_class(m, "PlaneCurve", &plane_curve);
    record_class(m, "SpaceCurve", &space_curve);
}

}  // namespace mbproj
