// Runs that are computed side by side, for Python.
#include "bindings/runs.hpp"
#include "ensembles/ensemble.hpp"

namespace mbproj {

// Runs side by side, as far as packs make them: the samples of each, which is at its end then or goes on from where packs have
// left it; None of the others, which begin as they would have. The first says which method the others must have. Every so many
// seconds `look` is called, which may raise.
template <class D>
nb::list run_together(const std::vector<TimeLoop<D>*>& runs, double seconds, const nb::callable& look) {
    if (std::count(runs.begin(), runs.end(), nullptr)) refuse("runs", "hold something that is none");
    std::vector<std::size_t> which;
    std::vector<Case<D>> cases;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const bool is_like =
            runs[i]->tableau() == runs.front()->tableau() && runs[i]->projection() == runs.front()->projection();
        if (auto own = runs[i]->as_case(); own && is_like) which.push_back(i), cases.push_back(std::move(*own));
    }
    std::vector<nb::object> found(runs.size(), nb::none());
    if (const PackLibrary* library = packs(); library != nullptr && !cases.empty()) {
        const auto ensemble_of_these = std::get<PackLibrary::EnsembleOf<D>>(library->ensembles);
        if (auto ensemble = ensemble_of_these(std::move(cases), runs.front()->tableau(), runs.front()->projection())) {
            const auto goes_on = [&] {
                nb::gil_scoped_release released;
                return !ensemble->advance(seconds);
            };
            while (goes_on()) look();
            auto made = ensemble->take();
            for (std::size_t i = 0; i < made.size(); ++i)
                if (made[i]) {
                    TimeLoop<D>& run = *runs[which[i]];
                    run.block = std::move(made[i]->samples);
                    run.take(*made[i]);
                    found[which[i]] = samples(run);
                }
        }
    }
    nb::list list;
    for (nb::object& each : found) list.append(std::move(each));
    return list;
}

void bind_together(nb::module_& m) {
    m.def(
        "pack_width", [] { return packs() == nullptr ? 0 : packs()->width; },
        "How many cases a pack holds on this processor; 0 without packs.");
    m.def("together", &run_together<Plane<double>>, nb::arg("runs"), nb::arg("seconds"), nb::arg("look"));
    m.def("together", &run_together<Space<double>>, nb::arg("runs"), nb::arg("seconds"), nb::arg("look"));
}

}  // namespace mbproj
