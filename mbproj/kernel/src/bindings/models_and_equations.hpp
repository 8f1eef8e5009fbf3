// Models and equations at single states of one dimension, for Python; with the runs, instantiated in plane.cpp and space.cpp.
#pragma once

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings/curves_from_numpy.hpp"
#include "bindings/layout_from_python.hpp"
#include "bindings/loads_from_numpy.hpp"
#include "bindings/runs.hpp"
#include "bindings/single_state.hpp"

namespace mbproj {

template <class D> void add_model(nb::module_& m, const char* primitives, const char* model) {
    nb::class_<PrimitiveSet<D>>(m, primitives)
        .def(
            "__init__",
            [](PrimitiveSet<D>* self, std::size_t bodies, Integers1 body, Integers1 is_point, Numbers2 local,
               Integers1 kind, Integers2 slots, Numbers2 parameters, Numbers1 offset, Numbers1 weight, Integers1 joins,
               Integers1 line, Integers1 other, const Lines& lines, Integers1 wire, const Wires& wires, Integers1 path,
               const Paths& paths) {
                new (self)
                    PrimitiveSet<D>(primitive_set<D>(bodies, body, is_point, local, kind, slots, parameters, offset,
                                                     weight, joins, line, other, lines, wire, wires, path, paths));
            },
            nb::kw_only(), nb::arg("bodies"), nb::arg("body"), nb::arg("is_point"), nb::arg("local"), nb::arg("kind"),
            nb::arg("slots"), nb::arg("parameters"), nb::arg("offset"), nb::arg("weight"), nb::arg("joins"),
            nb::arg("line"), nb::arg("other"), nb::arg("lines"), nb::arg("wire"), nb::arg("wires"), nb::arg("path"),
            nb::arg("paths"))
        .def_ro("rows", &PrimitiveSet<D>::rows);
    nb::class_<Model<D>>(m, model)
        .def(
            "__init__",
            [](Model<D>* self, const Thresholds& thresholds, Numbers1 mass, Numbers3 inertia, Numbers1 gravity,
               const PrimitiveSet<D>& constraints, Integers1 joint_begin, Numbers1 row_scale,
               const PrimitiveSet<D>& coordinates, double length, const std::vector<BlockNumbers>& blocks,
               const Programs& programs, int first_rate, Integers2 channels, Integers2 switches,
               std::shared_ptr<Loads<D>> loads, std::vector<double> motion_start,
               const std::vector<int>& motion_coordinate, const std::vector<CouplingNumbers>& couplings,
               const std::vector<FollowerNumbers>& followers, const PrimitiveSet<D>* flywheel_coordinates,
               std::vector<double> flywheels, const PrimitiveSet<D>* stop_coordinates,
               const std::vector<int>& stop_turns, std::vector<double> stop_bounds,
               const std::vector<BearingNumbers>& bearings, Numbers2 bearing_points, Numbers2 bearing_axes) {
                require(gravity, {D::axes}, "gravity");
                require(row_scale, {static_cast<std::size_t>(constraints.rows)}, "row_scale");
                Model<D> built;
                built.thresholds = thresholds;
                built.bodies = bodies<D>(mass, inertia, thresholds);
                built.gravity = matrix_at<D::axes>(gravity.data());
                built.constraints = constraints;
                built.coordinates = coordinates;
                built.joints = joints(constraints, built.size(), joint_begin);
                built.row_scale = numbers(row_scale, "row_scale");
                for (const Instance<D>& p : coordinates.instances) built.counts_turns.push_back(is_angle(p.kind));
                for (const Attachment<D>& a : coordinates.attachments)
                    if (a.body > built.size()) refuse("coordinates", "have a body that the model does not");
                for (const double scale : built.row_scale)
                    if (!(scale > 0.0)) refuse("row_scale", "is not positive");
                if (!(std::isfinite(length) && length > 0.0)) refuse("length", "is not positive");
                built.length = length;
                built.loads = std::move(loads);
                built.programs = programs;
                built.first_rate = index_below(first_rate, programs.start.size(), "first_rate");
                check_loads(built, bearings.size());
                built.bearings = mbproj::bearings(built, bearings, bearing_points, bearing_axes);
                built.driven = driven_rows(built, motion_start, motion_coordinate);
                if (stop_coordinates) add_stops(built, *stop_coordinates, stop_turns, std::move(stop_bounds));
                add_couplings(built, couplings);
                add_followers(built, followers);
                set_layout(built, blocks);
                add_channels(built, channels);
                add_switches(built, switches);
                if (flywheel_coordinates) add_flywheels(built, *flywheel_coordinates, flywheels);
                new (self) Model<D>(std::move(built));
            },
            nb::kw_only(), nb::arg("thresholds"), nb::arg("mass"), nb::arg("inertia"), nb::arg("gravity"),
            nb::arg("constraints"), nb::arg("joint_begin"), nb::arg("row_scale"), nb::arg("coordinates"),
            nb::arg("length"), nb::arg("layout"), nb::arg("programs"), nb::arg("first_rate"), nb::arg("channels"),
            nb::arg("switches"), nb::arg("loads").none() = nb::none(), nb::arg("motion_start") = std::vector<double>(),
            nb::arg("motion_coordinate") = std::vector<int>(), nb::arg("couplings") = std::vector<CouplingNumbers>(),
            nb::arg("followers") = std::vector<FollowerNumbers>(), nb::arg("flywheel_coordinates").none() = nb::none(),
            nb::arg("flywheels") = std::vector<double>(), nb::arg("stop_coordinates").none() = nb::none(),
            nb::arg("stop_turns") = std::vector<int>(), nb::arg("stop_bounds") = std::vector<double>(),
            nb::arg("bearings"), nb::arg("bearing_points"), nb::arg("bearing_axes"))
        .def("set_actions", &set_actions<D>)
        .def_prop_ro("bodies", &Model<D>::size)
        .def_prop_rw(
            "rows", [](const Model<D>& self) { return self.rows; },
            [](Model<D>& self, const UsualRows<>& rows) {
                rows_from(self, std::make_optional(rows.left_out));
                self.rows = rows;
            });
}

template <class D> void add_loads(nb::module_& m, const char* bushings, const char* name) {
    nb::class_<Bushings<D>>(m, bushings)
        .def(
            "__init__",
            [](Bushings<D>* self, std::size_t bodies, Integers1 body, Numbers2 origin, Numbers3 turn,
               Numbers3 stiffness, Numbers3 damping, Numbers2 preload, Numbers3 map, Integers1 turns_freely) {
                new (self) Bushings<D>(
                    mbproj::bushings<D>(bodies, body, origin, turn, stiffness, damping, preload, map, turns_freely));
            },
            nb::kw_only(), nb::arg("bodies"), nb::arg("body"), nb::arg("origin"), nb::arg("turn"), nb::arg("stiffness"),
            nb::arg("damping"), nb::arg("preload"), nb::arg("map"), nb::arg("turns_freely"));
    nb::class_<Loads<D>>(m, name).def(
        "__init__",
        [](Loads<D>* self, std::size_t bodies, const PrimitiveSet<D>& coordinates, Integers1 joint_coordinate,
           Numbers2 law, Integers1 law_program, Integers1 law_loses, Integers1 law_bearing, Integers1 law_apart,
           Integers1 law_partner, Numbers2 law_sliding, Integers1 body, Numbers2 point, Integers1 is_torque,
           Integers1 in_body, Numbers3 force_map, Numbers3 torque_map, Integers2 program, const Bushings<D>& bushings) {
            new (self) Loads<D>(loads<D>(bodies, coordinates, joint_coordinate, law, law_program, law_loses,
                                         law_bearing, law_apart, law_partner, law_sliding, body, point, is_torque,
                                         in_body, force_map, torque_map, program, bushings));
        },
        nb::kw_only(), nb::arg("bodies"), nb::arg("coordinates"), nb::arg("joint_coordinate"), nb::arg("law"),
        nb::arg("law_program"), nb::arg("law_loses"), nb::arg("law_bearing"), nb::arg("law_apart"),
        nb::arg("law_partner"), nb::arg("law_sliding"), nb::arg("body"), nb::arg("point"), nb::arg("is_torque"),
        nb::arg("in_body"), nb::arg("force_map"), nb::arg("torque_map"), nb::arg("program"), nb::arg("bushings"));
}

template <class D> void add_equations(nb::module_& m, const char* name) {
    using E = SingleState<D>;
    const auto checked = [](const E& self, const Numbers2& y) {
        require(y, {static_cast<std::size_t>(self.model().size()), Size<D>::state}, "y");
        return y.data();
    };
    const auto listed = [](std::vector<double> rows) {
        const auto count = rows.size();
        return array_of(std::move(rows), count);
    };
    const auto coordinates_of = [](const E& self, std::vector<double> coordinates) {
        const std::size_t own = self.model().coordinates.instances.size();
        if (coordinates.size() < own) coordinates.resize(own);
        if (coordinates.size() > own + self.model().layout.states.size) refuse("coordinates", "are too many");
        return coordinates;
    };
    using LeftOut = typename E::LeftOut;
    const auto rows = [](const E& self, const LeftOut& left_out) { return rows_from(self.model(), left_out); };
    nb::class_<E>(m, name)
        .def(nb::init<const Model<D>&, const ProjectionSettings&>())
        .def(
            "constraint", [=](E& self, Numbers2 y, double t) { return listed(self.constraint(t, checked(self, y))); },
            nb::arg("y"), nb::arg("t") = 0.0)
        .def(
            "constraint_velocity",
            [=](E& self, Numbers2 y, double t) { return listed(self.constraint_velocity(t, checked(self, y))); },
            nb::arg("y"), nb::arg("t") = 0.0)
        .def(
            "gamma", [=](E& self, Numbers2 y, double t) { return listed(self.gamma(t, checked(self, y))); },
            nb::arg("y"), nb::arg("t") = 0.0)
        .def(
            "jacobian",
            [=](E& self, Numbers2 y, double t) {
                auto rows = self.jacobian(t, checked(self, y));
                const auto count = rows.size() / std::max<std::size_t>(1, Size<D>::freedoms * self.model().size());
                return array_of(std::move(rows), count, self.model().size(), Size<D>::freedoms);
            },
            nb::arg("y"), nb::arg("t") = 0.0)
        .def(
            "accelerations",
            [=](E& self, Numbers2 y, double t, const std::vector<double>& coordinates,
                const LeftOut& left_out) -> nb::object {
                auto found =
                    self.accelerations(t, checked(self, y), coordinates_of(self, coordinates), rows(self, left_out));
                if (!found) return nb::none();
                const auto count = found->second.size();
                return nb::make_tuple(array_of(std::move(found->first), self.model().size(), Size<D>::freedoms),
                                      array_of(std::move(found->second), count));
            },
            nb::arg("y"), nb::arg("t") = 0.0, nb::arg("coordinates") = std::vector<double>(),
            nb::arg("left_out") = nb::none())
        .def(
            "smallest_multipliers",
            [=](E& self, Numbers3 y, Numbers1 t, Numbers2 coordinates, const std::optional<Numbers2>& forces) {
                const std::size_t count = t.shape(0);
                if (forces) require(*forces, {count, self.model().stops.bound.size()}, "forces");
                require(t, {count}, "t");
                require(y, {count, static_cast<std::size_t>(self.model().size()), Size<D>::state}, "y");
                require(coordinates, {count, self.beside()}, "coordinates");
                auto found = self.smallest_multipliers(count, t.data(), y.data(), coordinates.data(),
                                                       forces ? forces->data() : nullptr);
                return array_of(std::move(found), count, self.model().constraints.rows);
            },
            nb::arg("y"), nb::arg("t"), nb::arg("coordinates"), nb::arg("forces") = nb::none())
        .def(
            "spread",
            [=](E& self, Numbers3 y, Numbers1 t, Numbers2 carried) {
                const std::size_t count = t.shape(0);
                require(t, {count}, "t");
                require(y, {count, static_cast<std::size_t>(self.model().size()), Size<D>::state}, "y");
                require(carried, {count, static_cast<std::size_t>(self.model().constraints.rows)}, "carried");
                return array_of(self.spread(count, t.data(), y.data(), carried.data()), count, carried.shape(1));
            },
            nb::arg("y"), nb::arg("t"), nb::arg("carried"))
        .def(
            "left_out", [=](E& self, Numbers2 y, double t) { return self.left_out(t, checked(self, y)); }, nb::arg("y"),
            nb::arg("t") = 0.0)
        .def(
            "pivots",
            [=](E& self, Numbers2 y, double t, const std::vector<int>& left_out) {
                return self.pivots(t, checked(self, y), *rows(self, left_out));
            },
            nb::arg("y"), nb::arg("t"), nb::arg("left_out"))
        .def(
            "derivative",
            [=](E& self, Numbers2 y, double t, const std::vector<double>& coordinates,
                const LeftOut& left_out) -> nb::object {
                auto found =
                    self.derivative(t, checked(self, y), coordinates_of(self, coordinates), rows(self, left_out));
                if (!found) return nb::none();
                return array_of(std::move(*found), self.model().size(), Size<D>::state);
            },
            nb::arg("y"), nb::arg("t") = 0.0, nb::arg("coordinates") = std::vector<double>(),
            nb::arg("left_out") = nb::none())
        .def(
            "responses",
            [=](E& self, Numbers2 y, const std::vector<int>& laws, double t) -> nb::object {
                const int count = self.model().loads ? self.model().loads->size() : 0;
                for (const int law : laws)
                    if (law < 0 || law >= count) refuse("laws", "are out of range");
                auto found = self.responses(t, checked(self, y), laws);
                if (!found) return nb::none();
                return array_of(std::move(*found), laws.size(), laws.size());
            },
            nb::arg("y"), nb::arg("laws"), nb::arg("t") = 0.0)
        .def(
            "border",
            [=](E& self, Numbers2 y, const std::vector<std::pair<int, double>>& rows, double t) -> nb::object {
                std::vector<ContactRow> held;
                for (const auto& [number, sign] : rows) {
                    const std::vector<double>& bounds = self.model().stops.bound;
                    held.push_back({index_below(number, bounds.size(), "rows"), sign, bounds[number]});
                }
                const std::size_t count = held.size();
                auto found = self.border(t, checked(self, y), std::move(held));
                if (!found) return nb::none();
                return nb::make_tuple(array_of(std::move(found->first), count, count),
                                      array_of(std::move(found->second), count));
            },
            nb::arg("y"), nb::arg("rows"), nb::arg("t") = 0.0)
        .def(
            "newton",
            [=](E& self, Numbers2 y, double t) -> nb::object {
                auto found = self.newton(t, checked(self, y));
                if (!found) return nb::none();
                return array_of(std::move(*found), self.model().size(), Size<D>::state);
            },
            nb::arg("y"), nb::arg("t") = 0.0)
        .def(
            "corrected",
            [=](E& self, Numbers2 y, double t, const LeftOut& left_out) -> nb::object {
                auto found = self.corrected(t, checked(self, y), rows(self, left_out));
                if (!found) return nb::none();
                return array_of(std::move(*found), self.model().size(), Size<D>::state);
            },
            nb::arg("y"), nb::arg("t") = 0.0, nb::arg("left_out") = nb::none())
        .def(
            "dependent_rows",
            [=](E& self, Numbers2 y, double t, double smallest) {
                return self.dependent_rows(t, checked(self, y), smallest);
            },
            nb::arg("y"), nb::arg("t"), nb::arg("smallest"))
        .def_prop_ro("singular_joint", &E::singular_joint)
        .def_prop_ro("nearness", &E::nearness)
        .def_prop_ro("topology", [](const E& self) {
            const EliminationFacts facts = self.facts();
            nb::dict found;
            found["eliminated_bodies"] = facts.leaves;
            found["core_bodies"] = facts.loop_bodies;
            found["core_joints"] = facts.loop_joints;
            found["core_numbers"] = facts.stored;
            found["core_fill"] = facts.filled;
            return found;
        });
}

// Everything of a dimension; the classes are called name + "Model" and so on.
template <class D> void bind_dimension(nb::module_& m, const std::string& name) {
    add_model<D>(m, (name + "Primitives").c_str(), (name + "Model").c_str());
    add_loads<D>(m, (name + "Bushings").c_str(), (name + "Loads").c_str());
    add_equations<D>(m, (name + "Equations").c_str());
    add_run<D>(m, (name + "Run").c_str());
    add_tangents<D>(m, (name + "Tangents").c_str());
}

}  // namespace mbproj
