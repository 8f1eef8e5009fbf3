// The metrics of the projections.
#pragma once

namespace mbproj {

// What a change of the coordinates is weighed with: the masses (Eqs. 42-45, 67-74) or the coordinates q = (r, Λ)
// themselves (Eqs. 37-41), where |ΔΛ| = ½ |δθ|; in the plane the same, so that both agree.
// `stiff` is that of a stage of an implicit step: the masses, and what the forces of the compliant rows add to them.
// `penalised` is the mass-orthogonal projection's (Eqs. 48-55): the masses, with α on the violation.
enum class Metric { mass, coordinates, penalised, stiff };

}  // namespace mbproj
