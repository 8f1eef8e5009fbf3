// Contacts of rigid stops as Python's plain data, checked, and back.
#pragma once

#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings/from_numpy.hpp"
#include "stepping/time_loop.hpp"

namespace mbproj {

inline nb::dict saved_contacts(const ContactState& state) {
    nb::dict found;
    found["held"] = state.held;
    found["push"] = state.push;
    found["fastest"] = state.fastest;
    found["met_at"] = state.met_at;
    found["met_often"] = state.met_often;
    found["lost"] = state.lost;
    found["work"] = state.work;
    found["events"] = state.events;
    found["sliding"] = state.sliding;
    found["stuck"] = state.stuck;
    return found;
}

// Of so many stops and frictions; of an older version it is without what frictions do.
inline ContactState contacts_from(const nb::dict& given, std::size_t coordinates) {
    ContactState state;
    for (const int k : nb::cast<std::vector<int>>(given["held"]))
        state.held.push_back(index_below(k, coordinates, "held"));
    const auto numbered = [&](const char* name) {
        Numbered found = given.contains(name) ? nb::cast<Numbered>(given[name]) : Numbered();
        for (const auto& [k, x] : found) {
            index_below(k, coordinates, name);
            if (!std::isfinite(x)) refuse(name, "is not finite");
        }
        return found;
    };
    state.sliding = numbered("sliding");
    state.stuck = numbered("stuck");
    state.push = nb::cast<double>(given["push"]);
    state.fastest = nb::cast<double>(given["fastest"]);
    state.met_at = nb::cast<double>(given["met_at"]);
    state.met_often = nb::cast<int>(given["met_often"]);
    state.lost = nb::cast<double>(given["lost"]);
    state.work = nb::cast<double>(given["work"]);
    state.events = nb::cast<long>(given["events"]);
    return state;
}

// The loop itself does what happens at stops and frictions with these laws: side, restitution, slack and size of each stop; law,
// bearing, static, sliding, Stribeck speed and size of each friction.
template <int D> void begin_contacts(TimeLoop<D>& run,
                                     const std::vector<std::tuple<double, double, double, double>>& stops,
                                     const std::vector<std::tuple<int, int, double, double, double, double>>& frictions,
                                     const nb::dict& state, double spacing) {
    const Model<D>& model = run.model();
    if (stops.size() + frictions.size() != model.stops.bound.size()) refuse("laws", "do not fit the stops");
    std::vector<StopLaw> of_stops;
    for (const auto& [side, restitution, slack, size] : stops) of_stops.push_back({side, restitution, slack, size});
    std::vector<FrictionLaw> of_frictions;
    for (const auto& [law, bearing, fixed, sliding, stribeck, size] : frictions)
        of_frictions.push_back({index_below(law, model.loads ? model.loads->laws.size() : 0, "frictions"),
                                optional_index(bearing, model.bearings.size(), "frictions"), fixed, sliding, stribeck,
                                size});
    const ContactState begins = contacts_from(state, model.stops.bound.size());
    for (const Numbered& each : {begins.sliding, begins.stuck})
        for (const auto& [k, x] : each) index_below(k, frictions.size(), "frictions");
    require_positive(spacing, "spacing");
    run.stops().begin(std::move(of_stops), std::move(of_frictions), begins, spacing);
}

// What was recorded of contacts since the last call.
template <int D> auto take_contact_events(TimeLoop<D>& run) {
    constexpr const char* names[] = {
        "impact", "push of an impact", "rest", "contact", "release", "slip", "stick", "turn", "shared"};
    std::vector<std::tuple<double, int, std::string, int, double, double>> found;
    for (const ContactEvent& each : run.stops().policy().take_events())
        found.emplace_back(each.t, each.stop, names[static_cast<int>(each.what)], each.direction, each.impulse,
                           each.energy);
    return found;
}

}  // namespace mbproj
