// Ensembles in the plane: the only place where the kernel computes with packs there.
#include "ensembles/packed_runs.hpp"

namespace mbproj {

template std::unique_ptr<Ensemble<Plane<double>>> ensemble_of(std::vector<Case<Plane<double>>>, const Tableau&,
                                                              const ProjectionSettings&);

}  // namespace mbproj
