// The kernel in the plane: 3 freedoms a body.
#include "bindings/models_and_equations.hpp"

namespace mbproj {

void bind_plane(nb::module_& m) { bind_dimension<Plane<double>>(m, "Plane"); }

}  // namespace mbproj
