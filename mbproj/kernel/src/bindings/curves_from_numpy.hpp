// Plane and space curves, and the rows that follow them, from NumPy arrays.
#pragma once

#include "bindings/from_numpy.hpp"

namespace mbproj {

// The pieces and the places of a curve, with what all curves have beside them.
template <class Curve> std::pair<Numbers2, Numbers2> pieces_and_places(Record& given, Curve& curve, std::size_t width) {
    auto pieces = given.array<Numbers2>("pieces", {any_length, width}),
         places = given.array<Numbers2>("places", {any_length, 6});
    curve.end = given.take<double>("end");
    curve.closed = given.take<bool>("closed");
    curve.passes = given.take<int>("passes");
    curve.settled = given.take<double>("settled");
    curve.reach = given.take<double>("reach");
    if (pieces.shape(0) == 0 || places.shape(0) < 2 || curve.passes < 1) refuse("pieces", "are none");
    return {std::move(pieces), std::move(places)};
}

// Adds the next piece, which has no places yet.
template <class Curve> void add_piece(Curve& curve, typename Curve::Piece piece) {
    piece.first = piece.last = -1;
    if (!curve.pieces.empty() && !(piece.start > curve.pieces.back().start)) refuse("pieces", "do not increase");
    curve.pieces.push_back(piece);
}
// The piece of place i, from its number as given.
template <class Curve> int piece_of(Curve& curve, double number, std::size_t i) {
    const int found = index_below(static_cast<int64_t>(number), curve.pieces.size(), "places");
    auto& piece = curve.pieces[found];
    if (piece.first < 0) piece.first = static_cast<int>(i);
    piece.last = static_cast<int>(i);
    return found;
}
// Checks that every piece has its places.
template <class Curve> void check_places(const Curve& curve) {
    if (!(curve.end > curve.pieces.back().start)) refuse("end", "comes before the last piece");
    for (const auto& piece : curve.pieces)
        if (piece.first < 0 || piece.last <= piece.first) refuse("places", "leave a piece out");
}

// Pieces (start, origin, form, and the numbers of two functions), places (s, piece, x, y, length, angle).
inline PlaneCurve plane_curve(Record& given) {
    constexpr int numbers = PlaneCurve::numbers, terms = PlaneCurve::terms;
    PlaneCurve built{};
    const auto [pieces, places] = pieces_and_places(given, built, 3 + 2 * numbers);
    built.straight = given.take<double>("straight");
    built.beyond = given.take<double>("beyond");
    const auto count = [](const double* c) {
        int found = terms;
        while (found > 0 && c[found - 1] == 0.0) --found;
        return found;
    };
    for (std::size_t i = 0; i < pieces.shape(0); ++i) {
        const double* row = pieces.data() + i * pieces.shape(1);
        PlaneCurve::Piece piece{};
        piece.start = row[0];
        piece.origin = row[1];
        piece.form = static_cast<PlaneCurve::Form>(index_below(static_cast<int64_t>(row[2]), 3, "form"));
        std::copy_n(row + 3, numbers, piece.f);
        std::copy_n(row + 3 + numbers, numbers, piece.g);
        piece.f_terms = count(piece.f);
        piece.g_terms = count(piece.g);
        add_piece(built, piece);
    }
    for (std::size_t i = 0; i < places.shape(0); ++i) {
        const double* row = places.data() + 6 * i;
        const int number = piece_of(built, row[1], i);
        const PlaneCurve::Place place{row[0], row[2], row[3],           row[4],
                                      row[5], number, std::cos(row[5]), std::sin(row[5])};
        if (i > 0) {
            const PlaneCurve::Place& before = built.places.back();
            built.stride = std::max(built.stride, std::hypot(place.x - before.x, place.y - before.y));
        }
        built.places.push_back(place);
    }
    check_places(built);
    built.side = built.places.back().angle < built.places.front().angle ? -1.0 : 1.0;
    built.runs = built.turning_runs();
    return built;
}

// Pieces (start, origin, four coefficients of x, of y and of z, the direction across), places (s, piece, x, y, z, length).
inline SpaceCurve space_curve(Record& given) {
    SpaceCurve built{};
    const auto [pieces, places] = pieces_and_places(given, built, 17);
    for (std::size_t i = 0; i < pieces.shape(0); ++i) {
        const double* row = pieces.data() + i * pieces.shape(1);
        SpaceCurve::Piece piece{};
        piece.start = row[0];
        piece.origin = row[1];
        for (int k = 0; k < 3; ++k) {
            std::copy_n(row + 2 + 4 * k, 4, piece.c[k]);
            piece.axis[k] = row[14 + k];
        }
        add_piece(built, piece);
    }
    for (std::size_t i = 0; i < places.shape(0); ++i) {
        const double* row = places.data() + 6 * i;
        built.places.push_back({row[0], {row[2], row[3], row[4]}, row[5], piece_of(built, row[1], i)});
    }
    check_places(built);
    return built;
}

// The followers of curves: the list and number of each, the program whose switches are the curve's knots, and whether it is the
// second of two curves that touch.
using FollowerNumbers = std::tuple<int, int, int, int>;

template <class D> void add_followers(Record& given, Model<D>& model) {
    auto loads = model.loads ? std::make_shared<Loads<D>>(*model.loads) : nullptr;
    for (const auto& [kind, number, program, second] : given.take<std::vector<FollowerNumbers>>("followers", {})) {
        const Of of = static_cast<Of>(index_below(kind, 4, "followers"));
        if (of == Of::coordinate) {
            index_below(program, model.programs.size(), "followers");
            index_below(number, model.coordinates.instances.size(), "followers");
            model.curves.push_back({number, program, of});
            continue;
        }
        if (of == Of::law && !loads) refuse("followers", "have a law that the model does not");
        PrimitiveSet<D>& set = of == Of::row   ? model.constraints
                               : of == Of::law ? loads->coordinates
                                               : model.stop_coordinates;
        index_below(number, set.rows, "followers");
        const int at = model.programs.start[index_below(program, model.programs.size(), "followers")];
        if (model.programs.start[program + 1] != at + 2 || model.programs.op[at + 1] != Op::table)
            refuse("followers", "have a program that is no table");
        for (std::size_t i = 0; i < set.instances.size(); ++i)
            if (Instance<D>& p = set.instances[i]; p.row == number && p.rows == 1) {
                const int table = static_cast<int>(model.programs.operand[at + 1]);
                const auto& start = model.programs.table_start;
                if (!is_held(p.kind) || (second && !is_of_two(p.kind))) refuse("followers", "have another curve");
                const std::size_t pieces = is_in_space(p.kind) ? p.wire->pieces.size()
                                           : second            ? p.other->pieces.size()
                                                               : p.line->pieces.size();
                if (start[table + 1] - start[table] != static_cast<int>(pieces))
                    refuse("followers", "have another curve");
                (second ? p.other_follower : p.follower) = static_cast<int>(model.curves.size());
                for (Instance<D>& other : set.instances)  // the arc length there, in the row beside it
                    if (of == Of::row && (other.kind == Kind::lap || other.kind == Kind::beside_second) &&
                        std::equal(p.slots, p.slots + 4, other.slots))
                        other.follower = p.follower;
                model.curves.push_back({static_cast<int>(i), program, of, second != 0});
            }
    }
    model.loads = std::move(loads);
}

}  // namespace mbproj
