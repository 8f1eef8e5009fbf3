// The table that a library of packs exports to the module.
#include "ensembles/ensemble.hpp"
#include "ensembles/pack.hpp"

namespace mbproj {

extern "C" {
[[gnu::visibility("default")]] extern const PackLibrary mbproj_packs;
const PackLibrary mbproj_packs{pack_width,
                               sizeof(Case<Plane<double>>),
                               sizeof(Case<Space<double>>),
                               {&ensemble_of<Plane<double>>, &ensemble_of<Space<double>>}};
}

}  // namespace mbproj
