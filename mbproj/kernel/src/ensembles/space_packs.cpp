// Ensembles in space: the only place where the kernel computes with packs there.
#include "ensembles/packed_runs.hpp"

namespace mbproj {

template std::unique_ptr<Ensemble<Space<double>>> ensemble_of(std::vector<Case<Space<double>>>, const Tableau&,
                                                              const ProjectionSettings&);

}  // namespace mbproj
