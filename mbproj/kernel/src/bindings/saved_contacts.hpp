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
    return found;
}

inline ContactState contacts_from(const nb::dict& given, std::size_t stops) {
    ContactState state;
    for (const int k : nb::cast<std::vector<int>>(given["held"])) state.held.push_back(index_below(k, stops, "held"));
    state.push = nb::cast<double>(given["push"]);
    state.fastest = nb::cast<double>(given["fastest"]);
    state.met_at = nb::cast<double>(given["met_at"]);
    state.met_often = nb::cast<int>(given["met_often"]);
    state.lost = nb::cast<double>(given["lost"]);
    state.work = nb::cast<double>(given["work"]);
    state.events = nb::cast<long>(given["events"]);
    return state;
}

// The loop itself does what happens at stops with these laws: side, restitution, slack and size of each.
template <int D> void begin_contacts(TimeLoop<D>& run,
                                     const std::vector<std::tuple<double, double, double, double>>& laws,
                                     const nb::dict& state, double spacing) {
    const std::size_t stops = run.model().stops.bound.size();
    if (laws.size() != stops) refuse("laws", "do not fit the stops");
    std::vector<StopLaw> own;
    for (const auto& [side, restitution, slack, size] : laws) own.push_back({side, restitution, slack, size});
    require_positive(spacing, "spacing");
    run.stops().begin(std::move(own), contacts_from(state, stops), spacing);
}

// What was recorded of contacts since the last call.
template <int D> auto take_contact_events(TimeLoop<D>& run) {
    constexpr const char* names[] = {"impact", "push of an impact", "rest", "contact", "release"};
    std::vector<std::tuple<double, int, std::string, int, double, double>> found;
    for (const ContactEvent& each : run.stops().policy().take_events())
        found.emplace_back(each.t, each.stop, names[static_cast<int>(each.what)], each.direction, each.impulse,
                           each.energy);
    return found;
}

}  // namespace mbproj
