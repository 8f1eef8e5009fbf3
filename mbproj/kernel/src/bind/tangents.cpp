// How the states of a run change with numbers of its model and with its start, for Python.
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bind/from_numpy.hpp"
#include "solver/run_tangents.hpp"

namespace mbproj {

template <class D> void add_tangents(nb::module_& m, const char* name) {
    using T = RunTangents<D>;
    nb::class_<T>(m, name)
        .def_static(
            "numbers",
            [](const Model<D>& model) {
                std::vector<double> found = numbers_of(model);
                const auto count = found.size();
                return array_of(std::move(found), count);
            },
            "The numbers of a model in the order in which their slopes are given.")
        .def("__init__",
             [](T* self, const Model<D>& model, const Tableau& tableau, const ProjectionSettings& projection,
                const BreakNumbers& breaks, Numbers2 numbers) {
                 const std::size_t count = numbers.shape(0), size = numbers_of(model).size();
                 require(numbers, {count, size}, "numbers");
                 if (const std::string why = T::obstacle(model, tableau, projection); !why.empty())
                     throw std::invalid_argument(why);
                 new (self)
                     T(model, tableau, projection, breaks_of(breaks), numbers.data(), static_cast<int>(count), size);
             })
        .def("start",
             [](T& self, double t, Numbers1 y, Numbers2 slopes) {
                 require(y, {self.size()}, "y");
                 require(slopes, {static_cast<std::size_t>(self.count()), self.size()}, "slopes");
                 return self.start(t, y.data(), slopes.data());
             })
        .def_static(
            "structure",
            [](const Model<D>& model) {
                std::vector<double> found = structure_of(model);
                const auto count = found.size();
                return array_of(std::move(found), count);
            },
            "What neighbours of a model have in common with it.")
        .def(
            "stand",
            [](T& self, Numbers1 t, Numbers2 y) {
                const std::size_t count = t.shape(0);
                require(y, {count, self.size()}, "y");
                std::vector<double> found;
                std::size_t made = 0;
                for (; made < count && self.stand(t.data()[made], y.data() + made * self.size()); ++made)
                    self.write(found);
                return array_of(std::move(found), made, self.count(), self.size());
            },
            nb::arg("t"), nb::arg("y"), "The slopes where joints and motions alone give the motion, as far as it gets.")
        .def(
            "follow",
            [](T& self, Numbers1 t, Numbers1 h, Numbers2 y, Numbers1 at, Numbers2 inside) -> nb::object {
                const std::size_t steps = h.shape(0), samples = at.shape(0);
                require(t, {steps + 1}, "t");
                require(h, {steps}, "h");
                require(y, {steps, self.size()}, "y");
                require(inside, {samples, self.size()}, "inside");
                std::vector<double> found;
                std::size_t next = 0;
                {
                    nb::gil_scoped_release released;
                    for (std::size_t s = 0; s < steps; ++s) {
                        const double end = t.data()[s + 1];
                        std::size_t last = next;
                        while (last < samples && at.data()[last] < end) ++last;
                        if (!self.follow(t.data()[s], h.data()[s], end, y.data() + s * self.size(), last - next,
                                         at.data() + next, inside.data() + next * self.size(), found))
                            break;
                        for (next = last; next < samples && at.data()[next] == end; ++next) self.write(found);
                    }
                }
                const std::size_t row = self.count() * self.size();
                const std::size_t made = row ? found.size() / row : 0;
                return array_of(std::move(found), made, self.count(), self.size());
            },
            nb::arg("t"), nb::arg("h"), nb::arg("y"), nb::arg("at"), nb::arg("inside"),
            "The slopes at times after the start, as far as it gets.")
        .def_prop_ro("slopes", [](const T& self) {
            std::vector<double> found;
            self.write(found);
            return array_of(std::move(found), self.count(), self.size());
        });
}

void bind_tangents(nb::module_& m) {
    add_tangents<Plane<double>>(m, "PlaneTangents");
    add_tangents<Space<double>>(m, "SpaceTangents");
}

}  // namespace mbproj
