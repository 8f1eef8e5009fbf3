// Runs, for Python: their samples, counters, peaks and marks.
#include <chrono>

#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bind/formulation_from_python.hpp"
#include "bind/from_numpy.hpp"
#include "bind/saved_mark.hpp"
#include "step/flush_to_zero.hpp"
#include "step/run.hpp"

namespace mbproj {

// Of each stop its side, restitution, slack and size, and if it gives way its law, damping c, and r times the mass that it sees.
using StopLaws = std::vector<std::tuple<double, double, double, double, int, double, double>>;

// Of each friction its law, bearing, static and sliding force, Stribeck speed and size, stop and partner, and the program of its
// static force, or -1.
using FrictionLaws = std::vector<std::tuple<int, int, double, double, double, double, int, int, int>>;

// What Python says of the joints that bear some forces. The loop runs without the interpreter's lock and without small numbers.
LoadedJoints loaded_joints(nb::object joints) {
    return [joints = std::move(joints)](double t, const Eigen::VectorXd& y, const Eigen::MatrixXd& forces) {
        const nb::gil_scoped_acquire locked;
        const KeepDenormals kept;
        const RowMajor rows = forces;
        return nb::cast<std::vector<int>>(
            joints(t, array_of(std::vector<double>(y.begin(), y.end()), y.size()),
                   array_of(std::vector<double>(rows.data(), rows.data() + rows.size()), rows.rows(), rows.cols())));
    };
}

// The loop itself does what happens at stops and frictions with these laws.
void contacts_begin(Run& run, const StopLaws& stops, const FrictionLaws& frictions, const nb::dict& state,
                    double spacing, int impact_law, nb::object joints) {
    const Mechanism& model = run.model;
    if (stops.size() + frictions.size() != model.stops.bound.size()) refuse("laws", "do not fit the stops");
    std::vector<StopLaw> of_stops;
    const std::size_t laws = run.equations.law_count(), bearings = run.equations.bearing_count();
    const std::size_t programs = run.equations.programs().size();
    for (const auto& [side, restitution, slack, size, law, damping, gives_by] : stops)
        of_stops.push_back({side, restitution, slack, size, optional_index(law, laws, "stops"), damping, gives_by});
    std::vector<FrictionLaw> of_frictions;
    for (const auto& [law, bearing, fixed, sliding, stribeck, size, stop, partner, bound] : frictions)
        of_frictions.push_back({index_below(law, laws, "frictions"), optional_index(bearing, bearings, "frictions"),
                                fixed, sliding, stribeck, size, optional_index(bound, programs, "frictions"),
                                optional_index(stop, stops.size(), "frictions"),
                                optional_index(partner, frictions.size(), "frictions")});
    const ContactState begins = contacts_from(state, model.stops.bound.size());
    require_positive(spacing, "spacing");
    const auto impacts = static_cast<ImpactLaw>(index_below(impact_law, 3, "impact_law"));
    LoadedJoints joints_in_space;
    if (!joints.is_none()) joints_in_space = loaded_joints(std::move(joints));
    if (!begin_contacts(run, std::move(of_stops), std::move(of_frictions), impacts, begins, spacing,
                        std::move(joints_in_space)))
        refuse("state", "does not fit the laws");
}

// Why nothing can be decided: the cause, whose it is, the energy, and other laws of impact.
auto as_tuple(const Undecided& undecided) {
    constexpr const char* names[] = {"",           "driven into", "creates energy", "no balance",
                                     "never ends", "no inertia",  "pushes"};
    return std::make_tuple(std::string(names[static_cast<int>(undecided.cause)]), undecided.which, undecided.energy,
                           undecided.laws);
}

// What was recorded of contacts since the last call.
auto take_contact_events(Run& run) {
    constexpr const char* names[] = {
        "impact", "push of an impact", "rest", "contact", "release", "slip", "stick", "turn",
        "shared", "share decides"};
    std::vector<std::tuple<double, int, std::string, int, double, double>> found;
    for (const ContactEvent& each : run.contacts.take_events())
        found.emplace_back(each.t, each.stop, names[static_cast<int>(each.what)], each.direction, each.impulse,
                           each.energy);
    return found;
}

nb::dict samples(Run& run) {
    const SampleBlock block = std::move(run.block);
    run.block = SampleBlock{};
    const std::size_t count = block.t.size(), bodies = run.model.size();
    nb::dict found;
    found["t"] = array_of(block.t, count);
    found["y"] = array_of(block.y, count, run.model.layout.size());
    found["acceleration"] = array_of(block.acceleration, count, bodies, run.model.sizes().freedoms);
    found["multipliers"] = array_of(block.multipliers, count, run.model.row_count());
    found["step_size"] = array_of(block.step_size, count);
    found["angles"] = array_of(block.angles, count, run.model.coordinate_count());
    found["counters"] = array_of(block.counters, count, Counters::count);
    if (!run.has_contacts()) return found;
    const std::size_t stops = run.model.stops.bound.size();
    found["pushes"] = array_of(block.pushes, count, stops);
    found["slides"] = array_of(block.slides, count, stops);
    found["jumps"] = array_of(block.jumps, count, 2 + stops - run.contacts.stops());
    return found;
}

// Rigid motions (k, freedoms): the shift, then the turn.
void keep(Run& run, bool energy, const Numbers2& fields, double tolerance) {
    require(fields, {any_length, static_cast<std::size_t>(run.model.sizes().freedoms)}, "fields");
    run.projector.keep(energy, {fields.data(), fields.data() + fields.size()}, tolerance);
}

// Advances the runs one after another, each by `most` samples at most, for so many seconds in all. Returns the samples of each;
// a run that was not reached has none.
nb::list advance_runs(const std::vector<Run*>& runs, std::size_t most, double seconds) {
    if (std::count(runs.begin(), runs.end(), nullptr)) refuse("runs", "hold something that is none");
    {
        nb::gil_scoped_release released;
        const auto now = [] { return std::chrono::steady_clock::now(); };
        const auto begin = now();
        for (Run* run : runs) {
            const double left = seconds - std::chrono::duration<double>(now() - begin).count();
            if (left <= 0.0) break;
            advance(*run, most, left);
        }
    }
    nb::list made;
    for (Run* run : runs) made.append(samples(*run));
    return made;
}

// A run of a model in one dimension.
template <class D> void begin(Run* self, const Model<D>& model, const Tableau& tableau,
                              const ProjectionSettings& projection, const Steps& steps, Numbers1 y, Integers1 turns) {
    require(y, {static_cast<std::size_t>(model.layout.size())}, "y");
    require(turns, {static_cast<std::size_t>(model.coordinate_count())}, "turns");
    check_settings(tableau, projection, steps);
    for (const Break& each : steps.breaks)
        for (const int action : each.actions) index_below(action, model.actions.size(), "actions");
    new (self) Run(mechanics_of(model, tableau, projection, steps.fixed() ? 0.0 : steps.tolerance), steps,
                   {y.data(), y.data() + y.size()}, {turns.data(), turns.data() + turns.size()});
}

void bind_runs(nb::module_& m) {
    m.def("advance_runs", &advance_runs, nb::arg("runs"), nb::arg("most"), nb::arg("seconds"));
    nb::class_<Run>(m, "Run")
        .def("__init__", &begin<Plane<double>>)
        .def("__init__", &begin<Space<double>>)
        .def(
            "advance",
            [](Run& self, std::size_t most, double seconds, long attempts) {
                {
                    nb::gil_scoped_release released;
                    advance(self, most, seconds, attempts);
                }
                if (Formulation* other = self.other.get()) other->rethrow();
                return samples(self);
            },
            nb::arg("most"), nb::arg("seconds"), nb::arg("attempts") = std::numeric_limits<long>::max())
        .def("try_step",
             [](Run& self, double h) -> nb::object {
                 require_positive(h, "h");
                 const Eigen::VectorXd* error = try_step(self, h);
                 if (Formulation* other = self.other.get()) other->rethrow();
                 if (!error) return nb::none();
                 const Eigen::VectorXd& end = self.next.y;
                 return nb::make_tuple(array_of(std::vector<double>(end.begin(), end.end()), end.size()),
                                       array_of(std::vector<double>(error->begin(), error->end()), error->size()));
             })
        .def_prop_ro("pauses", [](const Run& self) { return self.pauses; })
        .def_prop_ro("waits", [](const Run& self) { return self.waits; })
        .def("give",
             [](Run& self, const std::vector<std::pair<int, double>>& states) {
                 if (!self.waits) refuse("states", "are given to a run that does not wait");
                 for (const auto& [state, value] : states) {
                     index_below(state, self.model.layout.states.size, "states");
                     if (!std::isfinite(value)) refuse("states", "hold a number that is not finite");
                 }
                 self.instants.give(states);
             })
        .def("values",
             [](Run& self, const Programs& programs) {
                 require_variables(programs, law_variables + static_cast<int>(self.model.channels.size()), "programs");
                 return self.instants.values(programs, self.now.t, self.now.y.data());
             })
        .def("here", [](Run& self) { return saved_mark(self, here(self)); })
        .def("resume",
             [](Run& self, const nb::dict& mark) {
                 if (!resume(self, mark_from(mark, self))) refuse("events", "do not fit");
             })
        .def("keep_ends", [](Run& self) { self.schedule.keeps_ends = true; })
        .def_prop_ro("ends", [](Run& self) { return self.schedule.ends(); })
        .def("keep_path", [](Run& self) { self.path.emplace(); })
        .def_prop_ro("path",
                     [](Run& self) {
                         const auto& path = self.path;
                         if (!path) refuse("path", "was not kept");
                         const std::size_t steps = path->t.size(), size = self.now.y.size();
                         return nb::make_tuple(array_of(std::vector<double>(path->t), steps),
                                               array_of(std::vector<double>(path->h), steps),
                                               array_of(std::vector<double>(path->y), steps, size));
                     })
        .def("follow",
             [](Run& self, std::vector<double> ends) {
                 if (!self.schedule.follow(std::move(ends))) refuse("ends", "do not rise to that of the run");
             })
        .def_prop_rw(
            "keeps_marks", [](const Run& self) { return self.keeps_marks; },
            [](Run& self, bool keeps) { self.keeps_marks = keeps; })
        .def("mark",
             [](Run& self) {
                 const RunState* mark = mark_of(self);
                 return mark ? saved_mark(self, *mark) : nb::dict();
             })
        .def("begin_contacts", &contacts_begin, nb::arg("stops"), nb::arg("frictions"), nb::arg("state"),
             nb::arg("spacing"), nb::arg("impact_law"), nb::arg("joints_in_space").none())
        .def("halt_at_contacts", [](Run& self) { self.halts = true; })
        .def_prop_ro("undecided", [](const Run& self) { return as_tuple(self.contacts.undecided()); })
        .def("take_contact_events", &take_contact_events)
        .def_prop_ro("contacts", [](const Run& self) { return saved(self.state.contacts); })
        .def("follow_formulation",
             [](Run& self, nb::object formulation) {
                 follow_formulation(self,
                                    std::make_unique<FormulationFromPython>(self.equations, std::move(formulation)));
             })
        .def("keep", &keep, nb::arg("energy"), nb::arg("fields"), nb::arg("tolerance"))
        .def_prop_ro("kept",
                     [](Run& self) {
                         const Invariants* rows = self.projector.invariants();
                         return rows ? saved_kept(rows->kept) : nb::dict();
                     })
        .def_prop_ro("standing",
                     [](const Run& self) {
                         const Eigen::VectorXd& y = self.now.y;
                         nb::dict found;
                         found["t"] = self.now.t;
                         found["h"] = self.to.h;
                         found["y"] = array_of(std::vector<double>(y.begin(), y.end()), y.size());
                         found["turns"] = self.now.counted.turns;
                         return found;
                     })
        .def_prop_ro("left_out", [](Run& self) { return self.equations.left_out(); })
        .def_prop_ro("loop_joints", [](Run& self) { return self.equations.loop_joint_count(); })
        .def_prop_ro("close_looks", [](Run& self) { return self.equations.close_looks(); })
        .def_prop_ro("outcome", [](const Run& self) { return self.outcome; })
        .def("take_met", [](Run& self) { return self.switches.take_met(); })
        .def_prop_ro("passed", [](const Run& self) { return self.switches.passed(); })
        .def_prop_ro("halved", [](const Run& self) { return as_tuples(self.state.halved); })
        .def_prop_ro("broken_state",
                     [](Run& self) {
                         const std::vector<double>& y = self.equations.broken_state();
                         return array_of(std::vector<double>(y), y.size());
                     })
        .def_prop_ro("position_peak", [](const Run& self) { return self.now.peaks.position; })
        .def_prop_ro("joint_peak", [](const Run& self) { return self.now.peaks.joint; })
        .def_prop_ro("velocity_peak", [](const Run& self) { return self.now.peaks.velocity; })
        .def_prop_ro("counters",
                     [](const Run& self) {
                         return array_of(std::vector<long>([&] {
                                             const auto list = self.state.counters.list(self.now.steps);
                                             return std::vector<long>(list.begin(), list.end());
                                         }()),
                                         Counters::count);
                     })
        .def_prop_ro("phase_seconds", [](const Run& self) {
            const auto& seconds = self.phases.seconds();
            return std::vector<double>(seconds.begin(), seconds.end());
        });
}

}  // namespace mbproj
