// The Python module `_core`: settings here, models and runs in plane.cpp and space.cpp.
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings/curves_from_numpy.hpp"
#include "bindings/laws_from_numpy.hpp"
#include "bindings/loads_from_numpy.hpp"
#include "stepping/samples.hpp"

namespace mbproj {

void bind_models(nb::module_& m);
void bind_single_states(nb::module_& m);
void bind_runs(nb::module_& m);
void bind_tangents(nb::module_& m);

namespace {

std::string eigen_version() {
    return std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
           std::to_string(EIGEN_MINOR_VERSION);
}

// For `mbproj info --build`: names and values as text.
nb::dict build_info() {
    nb::dict info;
    info["compiler"] = MBPROJ_COMPILER;
    info["flags"] = MBPROJ_FLAGS;
    info["build_type"] = MBPROJ_BUILD_TYPE;
    info["eigen"] = eigen_version().c_str();
    info["instruction_set"] = MBPROJ_INSTRUCTION_SET;
    return info;
}

// Whether this processor and its operating system run what was compiled.
bool runs_here() {
#if defined(MBPROJ_NEEDS_V3)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return true;
#endif
}

Thresholds thresholds(Record& given) {
    return Thresholds([&given](const char* name) {
        const auto number = given.take<double>(name);
        require_positive(number, name);
        return number;
    });
}

Tableau tableau(Record& given) {
    const auto coefficients = [&given](const char* name) { return matrix(given.take<Numbers2>(name), name); };
    Tableau made{};
    made.order = given.take<int>("order");
    made.error_order = given.take<int>("error_order");
    made.a = coefficients("a");
    made.b = given.numbers("b");
    made.c = given.numbers("c");
    made.error = coefficients("error");
    made.dense = coefficients("dense");
    if (given.has("gamma")) {
        made.gamma = given.take<double>("gamma");
        made.splitting = coefficients("splitting");
        check_implicit_tableau(made, 32);
    } else {
        made.extra_a = coefficients("extra_a");
        made.extra_c = given.numbers("extra_c");
        made.kinematic = given.take<bool>("kinematic");
        check_tableau(made, 32);
    }
    return made;
}

void add_settings(nb::module_& m) {
    record_class(m, "Thresholds", &thresholds).def_static("names", [] {
        std::vector<std::string> names;
        Thresholds([&names](const char* name) { return names.emplace_back(name), 1.0; });
        return names;
    });
    nb::class_<UsualRows>(m, "UsualRows")
        .def(
            "__init__",
            [](UsualRows* self, int redundant, std::vector<int> left_out, std::vector<double> pivots, double even) {
                if (!(even > 0.0 &&
                      std::all_of(pivots.begin(), pivots.end(), [](double pivot) { return pivot > 0.0; })))
                    refuse("rows", "have a pivot that is not positive");
                new (self) UsualRows{redundant, std::move(left_out), std::move(pivots), even};
            },
            nb::arg("redundant") = 0, nb::arg("left_out") = std::vector<int>(),
            nb::arg("pivots") = std::vector<double>(), nb::arg("even") = 1.0)
        .def_ro("redundant", &UsualRows::redundant)
        .def_ro("left_out", &UsualRows::left_out)
        .def_ro("pivots", &UsualRows::pivots)
        .def_ro("even", &UsualRows::even);
    record_class(m, "Programs", &programs)
        .def("run", [](const Programs& self, int program, double t, double s, double s_dot) {
            if (program < 0 || program + 1 >= static_cast<int>(self.start.size())) refuse("program", "is out of range");
            require_variables(self, law_variables, "program");
            const Series<double> variables[law_variables] = {{t, 1.0, 0.0}, {s, 0.0, 0.0}, {s_dot, 0.0, 0.0}};
            const Series<double> found = self.run(program, variables);
            return std::make_tuple(found.x, found.d, found.dd);
        });
    record_class(m, "PlaneCurve", &plane_curve);
    record_class(m, "SpaceCurve", &space_curve);
    record_class(m, "Tableau", &tableau);
    nb::enum_<Correction>(m, "Correction")
        .value("none", Correction::none)
        .value("baumgarte", Correction::baumgarte)
        .value("mass", Correction::mass)
        .value("coordinates", Correction::coordinates)
        .value("penalty", Correction::penalty);
    nb::class_<ProjectionSettings>(m, "Projection")
        .def(nb::init<Correction>())
        .def_rw("alpha", &ProjectionSettings::alpha)
        .def_rw("beta", &ProjectionSettings::beta)
        .def_rw("paper_test", &ProjectionSettings::paper_test)
        .def_rw("tolerance", &ProjectionSettings::tolerance)
        .def_rw("every", &ProjectionSettings::every)
        .def_rw("threshold", &ProjectionSettings::threshold)
        .def_rw("position", &ProjectionSettings::position)
        .def_rw("velocity", &ProjectionSettings::velocity)
        .def_rw("max_iterations", &ProjectionSettings::max_iterations)
        .def_rw("fallback", &ProjectionSettings::fallback);
    nb::class_<Steps>(m, "Steps")
        .def_static(
            "fixed",
            [](double start, double duration, double step, long count, long every, const BreakNumbers& breaks) {
                require_positive(duration, "duration");
                require_positive(step, "step");
                if (!std::isfinite(start) || count < 1 || every < 1) refuse("steps", "have a wrong start or count");
                return Steps{start, duration, step, 0.0, count, every, {}, breaks_of(breaks)};
            },
            nb::arg("start"), nb::arg("duration"), nb::arg("step"), nb::arg("count"), nb::arg("every"),
            nb::arg("breaks") = BreakNumbers())
        .def_static(
            "by_error",
            [](double start, double duration, double tolerance,
               const std::tuple<double, double, long, std::size_t>& grid, const BreakNumbers& breaks) {
                require_positive(duration, "duration");
                require_positive(tolerance, "tolerance");
                const auto& [origin, interval, offset, count] = grid;
                const SampleGrid samples{origin, interval, offset, count};
                const Steps steps{start, duration, -1.0, tolerance, 0, 1, samples, breaks_of(breaks)};
                const bool increasing =
                    count == 2 || (interval > 0.0 && steps.sample(1) > start && steps.end() > steps.sample(count - 2));
                if (!std::isfinite(start + origin + interval) || count < 2 || !increasing)
                    refuse("samples", "do not increase from the start");
                return steps;
            },
            nb::arg("start"), nb::arg("duration"), nb::arg("tolerance"), nb::arg("samples"),
            nb::arg("breaks") = BreakNumbers());
    nb::enum_<Status>(m, "Status")
        .value("running", Status::running)
        .value("finished", Status::finished)
        .value("not_finite", Status::not_finite)
        .value("singular", Status::singular)
        .value("open", Status::open)
        .value("vanished", Status::vanished)
        .value("broken", Status::broken)
        .value("branch", Status::branch)
        .value("unresolved", Status::unresolved)
        .value("untold", Status::untold)
        .value("pushed_back", Status::pushed_back)
        .value("unsolved", Status::unsolved)
        .value("halted", Status::halted)
        .value("jammed", Status::jammed)
        .value("off_rope", Status::off_rope)
        .value("overlap", Status::overlap)
        .value("undecided", Status::undecided);
    nb::class_<Outcome>(m, "Outcome")
        .def_ro("status", &Outcome::status)
        .def_ro("time", &Outcome::time)
        .def_prop_ro("rope_span", [](const Outcome& outcome) { return outcome.rope.span; })
        .def_prop_ro("rope_centre", [](const Outcome& outcome) { return outcome.rope.centre; })
        .def_ro("joint", &Outcome::joint)
        .def_ro("row", &Outcome::row)
        .def_ro("open_by", &Outcome::open_by)
        .def_ro("passes", &Outcome::passes)
        .def_ro("projection_failed", &Outcome::projection_failed)
        .def_ro("velocity_change", &Outcome::velocity_change)
        .def_prop_ro("coordinate", [](const Outcome& self) { return self.slip.coordinate; })
        .def_prop_ro("turned", [](const Outcome& self) { return self.slip.turned; })
        .def_prop_ro("off", [](const Outcome& self) { return self.slip.off; })
        .def_ro("step", &Outcome::step)
        .def_ro("body", &Outcome::body)
        .def_ro("force", &Outcome::force)
        .def_ro("near_singular", &Outcome::near_singular);
    nb::class_<Peak>(m, "Peak").def_ro("value", &Peak::value).def_ro("row", &Peak::row).def_ro("time", &Peak::time);
}

}  // namespace
}  // namespace mbproj

NB_MODULE(_core, m) {
    using namespace mbproj;
    if (!runs_here())
        throw nb::import_error("it was compiled for processors with AVX2 and FMA, which this one has not: install "
                               "mbproj on this machine, or with MBPROJ_PORTABLE=1");
    m.def(
        "primitives",
        [] {
            std::vector<std::tuple<std::string, int, int>> found;
            for (const Form& form : forms) found.emplace_back(form.name, form.slots, form.parameters);
            return found;
        },
        "The primitives that it has by their numbers: name, how many points and vectors, how many parameters.");
    m.def("build_info", &build_info, "How this extension was compiled.");
    add_settings(m);
    add_laws(m);
    bind_models(m);
    bind_single_states(m);
    bind_runs(m);
    bind_tangents(m);
}
