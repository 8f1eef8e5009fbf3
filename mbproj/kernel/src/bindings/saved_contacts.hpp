// Contacts of stops as Python's plain data, checked, and back.
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
    found["pushing"] = state.pushing;
    found["bearing"] = state.bearing;
    found["shares"] = state.shares;
    found["idle"] = state.idle;
    found["straight"] = state.straight;
    found["starting"] = state.starting;
    found["decides"] = state.decides;
    found["shared"] = state.shared;
    found["rubbed"] = state.rubbed;
    return found;
}

// Of so many stops and frictions; of an older version it is without what frictions do, or what shares.
inline ContactState contacts_from(const nb::dict& given, std::size_t coordinates) {
    ContactState state;
    const auto listed = [&](const char* name) {
        auto found = given.contains(name) ? nb::cast<std::vector<int>>(given[name]) : std::vector<int>();
        for (const int k : found) index_below(k, coordinates, name);
        return found;
    };
    state.held = listed("held"), state.idle = listed("idle");
    state.straight = listed("straight"), state.starting = listed("starting");
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
    state.pushing = numbered("pushing");
    state.bearing = numbered("bearing");
    if (given.contains("shares")) state.shares = nb::cast<decltype(state.shares)>(given["shares"]);
    for (const auto& [k, parts] : state.shares) {
        index_below(k, coordinates, "shares");
        for (const auto& [own, part] : parts)
            if (!has(state.held, own) || !std::isfinite(part)) refuse("shares", "are not of stops that are held");
    }
    if (given.contains("shared")) state.shared = nb::cast<std::vector<int>>(given["shared"]);
    if (given.contains("rubbed")) state.rubbed = nb::cast<std::vector<double>>(given["rubbed"]);
    state.rubbed.resize(coordinates, 0.0);
    state.decides = given.contains("decides") && nb::cast<bool>(given["decides"]);
    state.push = nb::cast<double>(given["push"]);
    state.fastest = nb::cast<double>(given["fastest"]);
    state.met_at = nb::cast<double>(given["met_at"]);
    state.met_often = nb::cast<int>(given["met_often"]);
    state.lost = nb::cast<double>(given["lost"]);
    state.work = nb::cast<double>(given["work"]);
    state.events = nb::cast<long>(given["events"]);
    return state;
}

// Of each stop its side, restitution, slack and size, and if it gives way its law, damping c, and r times the mass that it sees.
using StopLaws = std::vector<std::tuple<double, double, double, double, int, double, double>>;

// Of each friction its law, bearing, static and sliding force, Stribeck speed and size, stop and partner, and the program of its
// static force, or -1.
using FrictionLaws = std::vector<std::tuple<int, int, double, double, double, double, int, int, int>>;

// The loop itself does what happens at stops and frictions with these laws.
template <class D> void begin_contacts(TimeLoop<D>& run, const StopLaws& stops, const FrictionLaws& frictions,
                                       const nb::dict& state, double spacing, int impact_law) {
    const Model<D>& model = run.model();
    if (stops.size() + frictions.size() != model.stops.bound.size()) refuse("laws", "do not fit the stops");
    std::vector<StopLaw> of_stops;
    const std::size_t laws = model.loads ? model.loads->laws.size() : 0;
    for (const auto& [side, restitution, slack, size, law, damping, gives_by] : stops)
        of_stops.push_back({side, restitution, slack, size, optional_index(law, laws, "stops"), damping, gives_by});
    std::vector<FrictionLaw> of_frictions;
    for (const auto& [law, bearing, fixed, sliding, stribeck, size, stop, partner, bound] : frictions)
        of_frictions.push_back(
            {index_below(law, laws, "frictions"), optional_index(bearing, model.bearings.size(), "frictions"), fixed,
             sliding, stribeck, size, optional_index(bound, model.programs.size(), "frictions"),
             optional_index(stop, stops.size(), "frictions"), optional_index(partner, frictions.size(), "frictions")});
    const ContactState begins = contacts_from(state, model.stops.bound.size());
    require_positive(spacing, "spacing");
    const auto impacts = static_cast<ImpactLaw>(index_below(impact_law, 3, "impact_law"));
    if (!run.stops().begin(std::move(of_stops), std::move(of_frictions), impacts, begins, spacing))
        refuse("state", "does not fit the laws");
}

// What was recorded of contacts since the last call.
template <class D> auto take_contact_events(TimeLoop<D>& run) {
    constexpr const char* names[] = {
        "impact", "push of an impact", "rest", "contact", "release", "slip", "stick", "turn",
        "shared", "share decides"};
    std::vector<std::tuple<double, int, std::string, int, double, double>> found;
    for (const ContactEvent& each : run.stops().policy().take_events())
        found.emplace_back(each.t, each.stop, names[static_cast<int>(each.what)], each.direction, each.impulse,
                           each.energy);
    return found;
}

}  // namespace mbproj
