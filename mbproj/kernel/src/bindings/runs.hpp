// Runs of one dimension, for Python: their samples, counters, peaks and marks; and how they change.
#pragma once

#include <chrono>

#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings/formulation_from_python.hpp"
#include "bindings/from_numpy.hpp"
#include "bindings/saved_mark.hpp"
#include "stepping/time_loop.hpp"
#include "tangents/run_tangents.hpp"

namespace mbproj {

template <class D> nb::dict samples(TimeLoop<D>& run) {
    const SampleBlock block = std::move(run.block);
    run.block = SampleBlock{};
    const std::size_t count = block.t.size(), bodies = run.model().size();
    nb::dict found;
    found["t"] = array_of(block.t, count);
    found["y"] = array_of(block.y, count, run.model().layout.size());
    found["acceleration"] = array_of(block.acceleration, count, bodies, Size<D>::freedoms);
    found["multipliers"] = array_of(block.multipliers, count, run.model().constraints.rows);
    found["step_size"] = array_of(block.step_size, count);
    found["angles"] = array_of(block.angles, count, run.model().coordinates.instances.size());
    found["counters"] = array_of(block.counters, count, Counters::count);
    if (!run.stops().inside()) return found;
    const std::size_t stops = run.model().stops.bound.size();
    found["pushes"] = array_of(block.pushes, count, stops);
    found["slides"] = array_of(block.slides, count, stops);
    found["jumps"] = array_of(block.jumps, count, 2 + stops - run.stops().policy().stops());
    return found;
}

// Rigid motions (k, axes + turns): the shift, then the turn.
template <class D> void keep(TimeLoop<D>& run, bool energy, const Numbers2& fields, double tolerance) {
    constexpr std::size_t freedoms = Size<D>::freedoms;
    require(fields, {any_length, freedoms}, "fields");
    std::vector<RigidField<D>> found(fields.shape(0));
    for (std::size_t k = 0; k < found.size(); ++k) {
        const double* from = fields.data() + freedoms * k;
        for (int i = 0; i < D::axes; ++i) found[k].shift[i] = from[i];
        for (int i = 0; i < Size<D>::turns; ++i) found[k].turn[i] = from[D::axes + i];
    }
    run.projector().keep(energy, std::move(found), tolerance);
}

// Advances the runs one after another, each by `most` samples at most, for so many seconds in all. Returns the samples of each;
// a run that was not reached has none.
template <class D> nb::list advance_runs(const std::vector<TimeLoop<D>*>& runs, std::size_t most, double seconds) {
    if (std::count(runs.begin(), runs.end(), nullptr)) refuse("runs", "hold something that is none");
    {
        nb::gil_scoped_release released;
        const auto now = [] { return std::chrono::steady_clock::now(); };
        const auto begin = now();
        for (TimeLoop<D>* run : runs) {
            const double left = seconds - std::chrono::duration<double>(now() - begin).count();
            if (left <= 0.0) break;
            run->advance(most, left);
        }
    }
    nb::list made;
    for (TimeLoop<D>* run : runs) made.append(samples(*run));
    return made;
}

template <class D> void add_run(nb::module_& m, const char* name) {
    m.def("advance_runs", &advance_runs<D>, nb::arg("runs"), nb::arg("most"), nb::arg("seconds"));
    nb::class_<TimeLoop<D>>(m, name)
        .def("__init__",
             [](TimeLoop<D>* self, const Model<D>& model, const Tableau& tableau, const ProjectionSettings& projection,
                const Steps& steps, Numbers1 y, Integers1 turns) {
                 require(y, {static_cast<std::size_t>(model.layout.size())}, "y");
                 require(turns, {model.coordinates.instances.size()}, "turns");
                 check_settings(tableau, projection, steps);
                 for (const Break& each : steps.breaks)
                     for (const int action : each.actions) index_below(action, model.actions.size(), "actions");
                 new (self) TimeLoop<D>(model, tableau, projection, steps, {y.data(), y.data() + y.size()},
                                        {turns.data(), turns.data() + turns.size()});
             })
        .def(
            "advance",
            [](TimeLoop<D>& self, std::size_t most, double seconds, long attempts) {
                {
                    nb::gil_scoped_release released;
                    self.advance(most, seconds, attempts);
                }
                if (Formulation* other = self.equations().other()) other->rethrow();
                return samples(self);
            },
            nb::arg("most"), nb::arg("seconds"), nb::arg("attempts") = std::numeric_limits<long>::max())
        .def("try_step",
             [](TimeLoop<D>& self, double h) -> nb::object {
                 require_positive(h, "h");
                 const Eigen::VectorXd* error = self.try_step(h);
                 if (Formulation* other = self.equations().other()) other->rethrow();
                 if (!error) return nb::none();
                 const Eigen::VectorXd& end = self.now().y_new;
                 return nb::make_tuple(array_of(std::vector<double>(end.begin(), end.end()), end.size()),
                                       array_of(std::vector<double>(error->begin(), error->end()), error->size()));
             })
        .def_prop_ro("pauses", [](const TimeLoop<D>& self) { return self.pauses; })
        .def_prop_ro("waits", [](const TimeLoop<D>& self) { return self.waits; })
        .def("give",
             [](TimeLoop<D>& self, const std::vector<std::pair<int, double>>& states) {
                 if (!self.waits) refuse("states", "are given to a run that does not wait");
                 for (const auto& [state, value] : states) {
                     index_below(state, self.model().layout.states.size, "states");
                     if (!std::isfinite(value)) refuse("states", "hold a number that is not finite");
                 }
                 self.give(states);
             })
        .def("values",
             [](TimeLoop<D>& self, const Programs& programs) {
                 require_variables(programs, law_variables + static_cast<int>(self.model().channels.size()),
                                   "programs");
                 return self.values(programs);
             })
        .def("here", [](TimeLoop<D>& self) { return saved_mark<D>(self.here()); })
        .def("resume",
             [](TimeLoop<D>& self, const nb::dict& mark) {
                 if (!self.resume(mark_from<D>(mark, self.model(), self.carries_slope())))
                     refuse("events", "do not fit");
             })
        .def("keep_ends", [](TimeLoop<D>& self) { self.schedule().keeps_ends = true; })
        .def_prop_ro("ends", [](TimeLoop<D>& self) { return self.schedule().ends(); })
        .def("keep_path", [](TimeLoop<D>& self) { self.path.emplace(); })
        .def_prop_ro("path",
                     [](TimeLoop<D>& self) {
                         const auto& path = self.path;
                         if (!path) refuse("path", "was not kept");
                         const std::size_t steps = path->t.size(), size = self.now().y.size();
                         return nb::make_tuple(array_of(std::vector<double>(path->t), steps),
                                               array_of(std::vector<double>(path->h), steps),
                                               array_of(std::vector<double>(path->y), steps, size));
                     })
        .def("follow",
             [](TimeLoop<D>& self, std::vector<double> ends) {
                 if (!self.schedule().follow(std::move(ends))) refuse("ends", "do not rise to that of the run");
             })
        .def_prop_rw(
            "keeps_marks", [](const TimeLoop<D>& self) { return self.keeps_marks; },
            [](TimeLoop<D>& self, bool keeps) { self.keeps_marks = keeps; })
        .def("mark",
             [](TimeLoop<D>& self) {
                 const Mark<D>* mark = self.mark();
                 return mark ? saved_mark<D>(*mark) : nb::dict();
             })
        .def("begin_contacts", &begin_contacts<D>, nb::arg("stops"), nb::arg("frictions"), nb::arg("state"),
             nb::arg("spacing"), nb::arg("impact_law"), nb::arg("joints_in_space").none())
        .def("halt_at_contacts", [](TimeLoop<D>& self) { self.stops().halt(); })
        .def_prop_ro("undecided", [](const TimeLoop<D>& self) { return as_tuple(self.stops().policy().undecided()); })
        .def("take_contact_events", &take_contact_events<D>)
        .def_prop_ro("contacts", [](const TimeLoop<D>& self) { return saved(self.stops().policy().state()); })
        .def("follow_formulation",
             [](TimeLoop<D>& self, nb::object formulation) {
                 self.follow_formulation(
                     std::make_unique<FormulationFromPython<D>>(self.model(), std::move(formulation)));
             })
        .def("keep", &keep<D>, nb::arg("energy"), nb::arg("fields"), nb::arg("tolerance"))
        .def_prop_ro("kept",
                     [](TimeLoop<D>& self) {
                         const Invariants<D>* rows = self.projector().invariants();
                         return rows ? saved_kept(rows->kept) : nb::dict();
                     })
        .def_prop_ro("standing",
                     [](const TimeLoop<D>& self) {
                         const Eigen::VectorXd& y = self.now().y;
                         nb::dict found;
                         found["t"] = self.now().t;
                         found["h"] = self.now().to.h;
                         found["y"] = array_of(std::vector<double>(y.begin(), y.end()), y.size());
                         found["turns"] = self.turns();
                         return found;
                     })
        .def_prop_ro("left_out", [](TimeLoop<D>& self) { return self.equations().solver().left_out(); })
        .def_prop_ro("loop_joints",
                     [](TimeLoop<D>& self) { return self.equations().solver().order().loop_joints.size(); })
        .def_prop_ro("close_looks", [](TimeLoop<D>& self) { return self.equations().solver().close_looks(); })
        .def_prop_ro("outcome", [](const TimeLoop<D>& self) { return self.now().outcome; })
        .def("take_met", [](TimeLoop<D>& self) { return self.events().take_met(); })
        .def_prop_ro("passed", [](const TimeLoop<D>& self) { return self.events().passed(); })
        .def_prop_ro("halved", [](const TimeLoop<D>& self) { return as_tuples(self.halved()); })
        .def_prop_ro("broken_state",
                     [](TimeLoop<D>& self) {
                         const std::vector<double>& y = self.equations().broken_state();
                         return array_of(std::vector<double>(y), y.size());
                     })
        .def_prop_ro("position_peak", [](const TimeLoop<D>& self) { return self.peaks.position; })
        .def_prop_ro("joint_peak", [](const TimeLoop<D>& self) { return self.peaks.joint; })
        .def_prop_ro("velocity_peak", [](const TimeLoop<D>& self) { return self.peaks.velocity; })
        .def_prop_ro("counters",
                     [](const TimeLoop<D>& self) {
                         return array_of(std::vector<long>([&] {
                                             const auto list = self.now().counters.list();
                                             return std::vector<long>(list.begin(), list.end());
                                         }()),
                                         Counters::count);
                     })
        .def_prop_ro("phase_seconds", [](const TimeLoop<D>& self) {
            const auto& seconds = self.phases().seconds();
            return std::vector<double>(seconds.begin(), seconds.end());
        });
}

// How the states of a run change with numbers of its model and with its start.
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

}  // namespace mbproj
