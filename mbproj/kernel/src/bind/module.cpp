// The Python module `_core`, with the settings of runs.
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bind/from_numpy.hpp"
#include "bind/record.hpp"
#include "step/outcome.hpp"
#include "step/samples.hpp"

namespace mbproj {

void bind_functions(nb::module_& m);
void bind_laws(nb::module_& m);
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
    return Thresholds([&given](const char* name) { return given.positive(name); });
}

// A method of s stages. An implicit one is stiffly accurate: its first stage is explicit, and each depends on none after it.
Tableau tableau(Record& values) {
    Record given = values.part("tableau");
    const bool kinematic = values.flag("kinematic");
    constexpr auto any = Record::any;
    constexpr std::size_t most_stages = 32;
    Tableau t{};
    t.b = given.numbers("b");
    const std::size_t s = t.b.size();
    if (s < 1) given.refuse("b", "has a wrong shape");
    t.a = given.matrix("a", s, s);
    t.c = given.numbers("c", s);
    t.order = given.index("order", 100, 1);
    if (!given.has("gamma")) {
        t.kinematic = kinematic;
        t.extra_c = given.numbers("extra_c");
        const std::size_t extra = t.extra_c.size(), stages = s + 1 + extra;
        if (stages > most_stages) given.refuse("b", "has too many stages");
        t.extra_a = given.matrix("extra_a", extra, extra ? stages : any);
        t.error = given.matrix("error", any, any);
        const bool embedded = t.error.rows() > 0;
        if (embedded) t.error = given.matrix("error", std::min<std::size_t>(t.error.rows(), 2), s + 1);
        t.error_order = given.index("error_order", 100, embedded ? 1 : 0);
        t.dense = given.matrix("dense", embedded ? stages : any, any);
        if (embedded && t.dense.cols() < 1) given.refuse("dense", "has a wrong shape");
        return t;
    }
    t.gamma = given.positive("gamma");
    if (s < 2 || s > most_stages) given.refuse("b", "has a wrong shape");
    t.error_order = given.index("error_order", 100, 1);
    const std::vector<double> error = given.numbers("error", s);
    t.error = Eigen::Map<const RowMajor>(error.data(), 1, t.stages());
    t.dense = given.matrix("dense", s, any);
    if (t.dense.cols() < 1) given.refuse("dense", "has a wrong shape");
    t.splitting = given.matrix("splitting", s, s);
    if (!t.a.row(0).isZero(0.0)) given.refuse("a", "does not begin with the start of the step");
    for (Eigen::Index i = 0; i < t.stages(); ++i) {
        if (t.splitting(i, i) != (i ? t.gamma : 0.0)) given.refuse("splitting", "does not have gamma on its diagonal");
        if (t.a(t.stages() - 1, i) != t.b[i]) given.refuse("b", "is not the last stage");
        for (Eigen::Index j = i + 1; j < t.stages(); ++j)
            if (t.splitting(i, j) != 0.0) given.refuse("splitting", "is not lower triangular");
    }
    return t;
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
    bind_functions(m);
    bind_laws(m);
    bind_models(m);
    bind_single_states(m);
    bind_runs(m);
    bind_tangents(m);
}
