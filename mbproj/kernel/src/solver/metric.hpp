// The metrics of the projections.
#pragma once

namespace mbproj {

// The metric that measures a change of the coordinates: the masses (Eqs. 42-45, 67-74), or the coordinates
// q = (r, Λ) themselves (Eqs. 37-41), where |ΔΛ| = ½ |δθ|. The plane uses the same factor, so that both
// agree. `penalised`: the masses with a penalty; `stiff`: the masses with the stiff forces of an implicit
// step.
enum class Metric { mass, coordinates, penalised, stiff };

}  // namespace mbproj
