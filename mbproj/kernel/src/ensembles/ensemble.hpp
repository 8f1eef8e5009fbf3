// Cases of one mechanism that differ in numbers, run side by side in packs, as many at once as a vector holds.
#pragma once

#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "stepping/mark.hpp"

namespace mbproj {

template <class D> class Ensemble {
public:
    virtual ~Ensemble() = default;
    Ensemble(const Ensemble&) = delete;
    Ensemble& operator=(const Ensemble&) = delete;

    // Goes on for so many seconds. Whether all cases have ended.
    virtual bool advance(double seconds) = 0;
    // The run of each case, with the bits of a run by itself: to its end, or to the step in which something rare
    // happens. Nothing for a case that has to run by itself: packs do not compute its kind, or its numbers need another
    // order of elimination than those of the first case.
    virtual std::vector<std::optional<CaseRun<D>>> take() = 0;

protected:
    Ensemble() = default;
};

// The ensemble of these cases; null where packs do not compute the first.
template <class D> std::unique_ptr<Ensemble<D>> ensemble_of(std::vector<Case<D>> cases, const Tableau& tableau,
                                                            const ProjectionSettings& projection);

// The table that a library of packs exports. Each kind of vector has a library: the module has no code for others.
struct PackLibrary {
    int width = 0;  // how many cases a pack holds
    // Sizes in bytes; the module has the same where both are compiled from the same sources.
    std::size_t plane_case = sizeof(Case<Plane<double>>), space_case = sizeof(Case<Space<double>>);
    template <class D> using EnsembleOf = decltype(&ensemble_of<D>);
    std::tuple<EnsembleOf<Plane<double>>, EnsembleOf<Space<double>>> ensembles{};
};

// The library with the widest packs that this processor runs. The first call loads it. Null where there is none.
const PackLibrary* packs();

}  // namespace mbproj
