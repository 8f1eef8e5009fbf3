// Runs, for Python: their samples, counters, peaks and marks.
#include <chrono>

#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings/formulation_from_python.hpp"
#include "bindings/from_numpy.hpp"
#include "bindings/saved_mark.hpp"
#include "stepping/time_loop.hpp"

namespace mbproj {

nb::dict samples(TimeLoop& run) {
    const SampleBlock block = std::move(run.block);
    run.block = SampleBlock{};
    const std::size_t count = block.t.size(), bodies = run.model().size();
    nb::dict found;
    found["t"] = array_of(block.t, count);
    found["y"] = array_of(block.y, count, run.model().layout.size());
    found["acceleration"] = array_of(block.acceleration, count, bodies, run.model().sizes().freedoms);
    found["multipliers"] = array_of(block.multipliers, count, run.model().row_count());
    found["step_size"] = array_of(block.step_size, count);
    found["angles"] = array_of(block.angles, count, run.model().coordinate_count());
    found["counters"] = array_of(block.counters, count, Counters::count);
    if (!run.stops().inside()) return found;
    const std::size_t stops = run.model().stops.bound.size();
    found["pushes"] = array_of(block.pushes, count, stops);
    found["slides"] = array_of(block.slides, count, stops);
    found["jumps"] = array_of(block.jumps, count, 2 + stops - run.stops().policy().stops());
    return found;
}

// Rigid motions (k, freedoms): the shift, then the turn.
void keep(TimeLoop& run, bool energy, const Numbers2& fields, double tolerance) {
    require(fields, {any_length, static_cast<std::size_t>(run.model().sizes().freedoms)}, "fields");
    run.projector().keep(energy, {fields.data(), fields.data() + fields.size()}, tolerance);
}

// Advances the runs one after another, each by `most` samples at most, for so many seconds in all. Returns the samples of each;
// a run that was not reached has none.
nb::list advance_runs(const std::vector<TimeLoop*>& runs, std::size_t most, double seconds) {
    if (std::count(runs.begin(), runs.end(), nullptr)) refuse("runs", "hold something that is none");
    {
        nb::gil_scoped_release released;
        const auto now = [] { return std::chrono::steady_clock::now(); };
        const auto begin = now();
        for (TimeLoop* run : runs) {
            const double left = seconds - std::chrono::duration<double>(now() - begin).count();
            if (left <= 0.0) break;
            run->advance(most, left);
        }
    }
    nb::list made;
    for (TimeLoop* run : runs) made.append(samples(*run));
    return made;
}

// A run of a model in one dimension.
template <class D> void begin(TimeLoop* self, const Model<D>& model, const Tableau& tableau,
                              const ProjectionSettings& projection, const Steps& steps, Numbers1 y, Integers1 turns) {
    require(y, {static_cast<std::size_t>(model.layout.size())}, "y");
    require(turns, {static_cast<std::size_t>(model.coordinate_count())}, "turns");
    check_settings(tableau, projection, steps);
    for (const Break& each : steps.breaks)
        for (const int action : each.actions) index_below(action, model.actions.size(), "actions");
    new (self) TimeLoop(mechanics_of(model, tableau, projection, steps.fixed() ? 0.0 : steps.tolerance), steps,
                        {y.data(), y.data() + y.size()}, {turns.data(), turns.data() + turns.size()});
}

void bind_runs(nb::module_& m) {
    m.def("advance_runs", &advance_runs, nb::arg("runs"), nb::arg("most"), nb::arg("seconds"));
    nb::class_<TimeLoop>(m, "Run")
        .def("__init__", &begin<Plane<double>>)
        .def("__init__", &begin<Space<double>>)
        .def(
            "advance",
            [](TimeLoop& self, std::size_t most, double seconds, long attempts) {
                {
                    nb::gil_scoped_release released;
                    self.advance(most, seconds, attempts);
                }
                if (Formulation* other = self.equations().other()) other->rethrow();
                return samples(self);
            },
            nb::arg("most"), nb::arg("seconds"), nb::arg("attempts") = std::numeric_limits<long>::max())
        .def("try_step",
             [](TimeLoop& self, double h) -> nb::object {
                 require_positive(h, "h");
                 const Eigen::VectorXd* error = self.try_step(h);
                 if (Formulation* other = self.equations().other()) other->rethrow();
                 if (!error) return nb::none();
                 const Eigen::VectorXd& end = self.now().y_new;
                 return nb::make_tuple(array_of(std::vector<double>(end.begin(), end.end()), end.size()),
                                       array_of(std::vector<double>(error->begin(), error->end()), error->size()));
             })
        .def_prop_ro("pauses", [](const TimeLoop& self) { return self.pauses; })
        .def_prop_ro("waits", [](const TimeLoop& self) { return self.waits; })
        .def("give",
             [](TimeLoop& self, const std::vector<std::pair<int, double>>& states) {
                 if (!self.waits) refuse("states", "are given to a run that does not wait");
                 for (const auto& [state, value] : states) {
                     index_below(state, self.model().layout.states.size, "states");
                     if (!std::isfinite(value)) refuse("states", "hold a number that is not finite");
                 }
                 self.give(states);
             })
        .def("values",
             [](TimeLoop& self, const Programs& programs) {
                 require_variables(programs, law_variables + static_cast<int>(self.model().channels.size()),
                                   "programs");
                 return self.values(programs);
             })
        .def("here", [](TimeLoop& self) { return saved_mark(self.here()); })
        .def("resume",
             [](TimeLoop& self, const nb::dict& mark) {
                 if (!self.resume(mark_from(mark, self.equations(), self.carries_slope())))
                     refuse("events", "do not fit");
             })
        .def("keep_ends", [](TimeLoop& self) { self.schedule().keeps_ends = true; })
        .def_prop_ro("ends", [](TimeLoop& self) { return self.schedule().ends(); })
        .def("keep_path", [](TimeLoop& self) { self.path.emplace(); })
        .def_prop_ro("path",
                     [](TimeLoop& self) {
                         const auto& path = self.path;
                         if (!path) refuse("path", "was not kept");
                         const std::size_t steps = path->t.size(), size = self.now().y.size();
                         return nb::make_tuple(array_of(std::vector<double>(path->t), steps),
                                               array_of(std::vector<double>(path->h), steps),
                                               array_of(std::vector<double>(path->y), steps, size));
                     })
        .def("follow",
             [](TimeLoop& self, std::vector<double> ends) {
                 if (!self.schedule().follow(std::move(ends))) refuse("ends", "do not rise to that of the run");
             })
        .def_prop_rw(
            "keeps_marks", [](const TimeLoop& self) { return self.keeps_marks; },
            [](TimeLoop& self, bool keeps) { self.keeps_marks = keeps; })
        .def("mark",
             [](TimeLoop& self) {
                 const Mark* mark = self.mark();
                 return mark ? saved_mark(*mark) : nb::dict();
             })
        .def("begin_contacts", &begin_contacts, nb::arg("stops"), nb::arg("frictions"), nb::arg("state"),
             nb::arg("spacing"), nb::arg("impact_law"), nb::arg("joints_in_space").none())
        .def("halt_at_contacts", [](TimeLoop& self) { self.stops().halt(); })
        .def_prop_ro("undecided", [](const TimeLoop& self) { return as_tuple(self.stops().policy().undecided()); })
        .def("take_contact_events", &take_contact_events)
        .def_prop_ro("contacts", [](const TimeLoop& self) { return saved(self.stops().policy().state()); })
        .def("follow_formulation",
             [](TimeLoop& self, nb::object formulation) {
                 self.follow_formulation(
                     std::make_unique<FormulationFromPython>(self.equations(), std::move(formulation)));
             })
        .def("keep", &keep, nb::arg("energy"), nb::arg("fields"), nb::arg("tolerance"))
        .def_prop_ro("kept",
                     [](TimeLoop& self) {
                         const Invariants* rows = self.projector().invariants();
                         return rows ? saved_kept(rows->kept) : nb::dict();
                     })
        .def_prop_ro("standing",
                     [](const TimeLoop& self) {
                         const Eigen::VectorXd& y = self.now().y;
                         nb::dict found;
                         found["t"] = self.now().t;
                         found["h"] = self.now().to.h;
                         found["y"] = array_of(std::vector<double>(y.begin(), y.end()), y.size());
                         found["turns"] = self.turns();
                         return found;
                     })
        .def_prop_ro("left_out", [](TimeLoop& self) { return self.equations().left_out(); })
        .def_prop_ro("loop_joints", [](TimeLoop& self) { return self.equations().loop_joint_count(); })
        .def_prop_ro("close_looks", [](TimeLoop& self) { return self.equations().close_looks(); })
        .def_prop_ro("outcome", [](const TimeLoop& self) { return self.now().outcome; })
        .def("take_met", [](TimeLoop& self) { return self.events().take_met(); })
        .def_prop_ro("passed", [](const TimeLoop& self) { return self.events().passed(); })
        .def_prop_ro("halved", [](const TimeLoop& self) { return as_tuples(self.halved()); })
        .def_prop_ro("broken_state",
                     [](TimeLoop& self) {
                         const std::vector<double>& y = self.equations().broken_state();
                         return array_of(std::vector<double>(y), y.size());
                     })
        .def_prop_ro("position_peak", [](const TimeLoop& self) { return self.peaks.position; })
        .def_prop_ro("joint_peak", [](const TimeLoop& self) { return self.peaks.joint; })
        .def_prop_ro("velocity_peak", [](const TimeLoop& self) { return self.peaks.velocity; })
        .def_prop_ro("counters",
                     [](const TimeLoop& self) {
                         return array_of(std::vector<long>([&] {
                                             const auto list = self.now().counters.list();
                                             return std::vector<long>(list.begin(), list.end());
                                         }()),
                                         Counters::count);
                     })
        .def_prop_ro("phase_seconds", [](const TimeLoop& self) {
            const auto& seconds = self.phases().seconds();
            return std::vector<double>(seconds.begin(), seconds.end());
        });
}

}  // namespace mbproj
