// The equations at single states, for Python.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bind/from_numpy.hpp"
#include "bind/single_state.hpp"

namespace mbproj {

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

void bind_single_states(nb::module_& m) {
    add_equations<Plane<double>>(m, "PlaneEquations");
    add_equations<Space<double>>(m, "SpaceEquations");
}

}  // namespace mbproj
