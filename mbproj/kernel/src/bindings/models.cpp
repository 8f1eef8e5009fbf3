// Models of a mechanism, for Python.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings/curves_from_numpy.hpp"
#include "bindings/layout_from_python.hpp"
#include "bindings/loads_from_numpy.hpp"

namespace mbproj {

template <class D> Model<D> model_of(Record& given) {
    Model<D> built;
    built.thresholds = given.object<Thresholds>("thresholds");
    built.bodies = bodies<D>(given, built.thresholds);
    built.gravity = matrix_at<D::axes>(given.array<Numbers1>("gravity", {D::axes}).data());
    built.constraints = given.object<PrimitiveSet<D>>("constraints");
    built.coordinates = given.object<PrimitiveSet<D>>("coordinates");
    built.joints = joints(given, built.constraints, built.size());
    built.row_scale = given.numbers("row_scale", built.constraints.rows);
    for (const Instance<D>& p : built.coordinates.instances) built.counts_turns.push_back(is_angle(p.kind));
    for (const Attachment<D>& a : built.coordinates.attachments)
        if (a.body > built.size()) refuse("coordinates", "have a body that the model does not");
    for (const double scale : built.row_scale) require_positive(scale, "row_scale");
    built.length = given.take<double>("length");
    require_positive(built.length, "length");
    built.loads = given.take<std::shared_ptr<Loads<D>>>("loads", nullptr);
    built.programs = given.object<Programs>("programs");
    built.first_rate = index_below(given.take<int>("first_rate"), built.programs.start.size(), "first_rate");
    built.bearings = bearings(given, built);
    check_loads(built);
    built.driven = driven_rows(given, built);
    add_stops(given, built);
    add_couplings(given, built);
    add_followers(given, built);
    set_layout(given, built);
    add_channels(given, built);
    add_switches(given, built);
    add_flywheels(given, built);
    add_actions(given, built);
    return built;
}

template <class D> void add_model(nb::module_& m, const std::string& name) {
    record_class(m, (name + "Primitives").c_str(), &primitive_set<D>).def_ro("rows", &PrimitiveSet<D>::rows);
    record_class(m, (name + "Bushings").c_str(), &bushings<D>);
    record_class(m, (name + "Loads").c_str(), &loads<D>);
    record_class(m, (name + "Model").c_str(), &model_of<D>)
        .def_prop_ro("bodies", &Model<D>::size)
        .def_prop_rw(
            "rows", [](const Model<D>& self) { return self.rows; },
            [](Model<D>& self, const UsualRows& rows) {
                rows_from(self, std::make_optional(rows.left_out));
                self.rows = rows;
            });
}

void bind_models(nb::module_& m) {
    add_model<Plane<double>>(m, "Plane");
    add_model<Space<double>>(m, "Space");
}

}  // namespace mbproj
