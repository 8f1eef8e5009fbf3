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

    // Goes on for so many seconds; whether it has come to its end.
    virtual bool advance(double seconds) = 0;
    // The run of each case, with the bits of one by itself: to its end, or to the step in which something rare happens. Nothing of
    // one that is to run by itself: packs do not compute its like, or its numbers ask for another order of elimination than the
    // first case's.
    virtual std::vector<std::optional<CaseRun<D>>> take() = 0;

protected:
    Ensemble() = default;
};

// Of these cases; null where packs do not compute the first.
template <class D> std::unique_ptr<Ensemble<D>> ensemble_of(std::vector<Case<D>> cases, const Tableau& tableau,
                                                            const ProjectionSettings& projection);

// What a library of packs shows. There is one for each kind of vector, so that no code for other processors gets into the module.
struct PackLibrary {
    int width = 0;  // how many cases a pack holds
    // Bytes; those of the module are the same where both are compiled from the same sources.
    std::size_t plane_case = sizeof(Case<Plane<double>>), space_case = sizeof(Case<Space<double>>);
    template <class D> using EnsembleOf = decltype(&ensemble_of<D>);
    std::tuple<EnsembleOf<Plane<double>>, EnsembleOf<Space<double>>> ensembles{};
};

// The library with the widest packs that this processor runs. The first call loads it. Null where there is none.
const PackLibrary* packs();

}  // namespace mbproj
