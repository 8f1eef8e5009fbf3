// The metric W of the KKT system [W Gᵀ; G 0] (kkt_solver.hpp): it measures a change δ = (δr, δθ) of a pose, ½ δᵀ W δ.
#pragma once

namespace mbproj {

enum class Metric {
    mass,         // the masses and moments of inertia (Eqs. 42-45, 67-74), and those of the motion itself
    coordinates,  // |Δq|² of q = (r, Λ) (Eqs. 37-41). A rotation has the weight ¼, as |ΔΛ| = ½ |δθ|, also in the plane
    penalised,    // `mass`, with the violation penalised instead of set to 0
    stiff         // `mass`, with the stiff forces of an implicit step
};

}  // namespace mbproj
