// The kernel in space: 6 freedoms a body.
#include "bindings/models_and_equations.hpp"

namespace mbproj {

void bind_space(nb::module_& m) { bind_dimension<Space<double>>(m, "Space"); }

}  // namespace mbproj
