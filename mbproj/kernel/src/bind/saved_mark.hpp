// A mark of a run as plain data for Python, and back: what comes from a file is checked.
#pragma once

#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bind/from_numpy.hpp"
#include "step/run.hpp"

namespace mbproj {

// Calls visit("name", member) for the plain members of a mark, of its contacts, or of its branches.
template <class Saved, class Visit> void each_member(Saved& saved, Visit&& visit) {
    if constexpr (std::is_same_v<std::remove_const_t<Saved>, ContactState>) {
        visit("held", saved.held), visit("idle", saved.idle), visit("straight", saved.straight);
        visit("starting", saved.starting), visit("turned", saved.turned), visit("shared", saved.shared);
        visit("sliding", saved.sliding), visit("stuck", saved.stuck), visit("pushing", saved.pushing);
        visit("bearing", saved.bearing), visit("turning", saved.turning), visit("shares", saved.shares);
        visit("rubbed", saved.rubbed), visit("decides", saved.decides), visit("push", saved.push);
        visit("fastest", saved.fastest), visit("met_at", saved.met_at), visit("met_often", saved.met_often);
        visit("lost", saved.lost), visit("work", saved.work), visit("events", saved.events);
    } else if constexpr (std::is_same_v<std::remove_const_t<Saved>, Branches>) {
        visit("held", saved.held), visit("last", saved.last), visit("first", saved.first);
        visit("at_once", saved.at_once), visit("in_a_row", saved.in_a_row);
        visit("times", saved.times), visit("told", saved.told);
    } else {
        visit("t", saved.now.t), visit("h", saved.h), visit("turns", saved.now.counted.turns);
        visit("grid", saved.grid.steps), visit("part", saved.grid.part.at), visit("shortened", saved.shortened);
        visit("shaped", saved.shaped), visit("anew", saved.anew), visit("other", saved.other);
        visit("previous_error", saved.error.previous), visit("rejected", saved.error.rejected);
    }
}

template <class T> nb::dict saved(const T& state) {
    nb::dict found;
    each_member(state, [&found](const char* name, const auto& value) { found[name] = value; });
    return found;
}

// What a file has of these. All numbers are there; a file of an older version may be without some lists.
template <class T> T saved_from(const nb::dict& given) {
    T state{};
    each_member(state, [&given](const char* name, auto& value) {
        using Value = std::decay_t<decltype(value)>;
        if (given.contains(name) || (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>))
            value = nb::cast<Value>(given[name]);
    });
    return state;
}

// Of so many stops and frictions.
inline ContactState contacts_from(const nb::dict& given, std::size_t coordinates) {
    auto state = saved_from<ContactState>(given);
    each_member(state, [&](const char* name, const auto& value) {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, std::vector<int>>) {
            if (&value == &state.shared) return;  // numbered with the joints
            for (const int k : value) index_below(k, coordinates, name);
        } else if constexpr (std::is_same_v<Value, Numbered>) {
            for (const auto& [k, x] : value)
                if (index_below(k, coordinates, name); !std::isfinite(x)) refuse(name, "is not finite");
        }
    });
    for (const auto& [k, parts] : state.shares) {
        index_below(k, coordinates, "shares");
        for (const auto& [own, part] : parts)
            if (!has(state.held, own) || !std::isfinite(part)) refuse("shares", "are not of stops that are held");
    }
    state.rubbed.resize(coordinates, 0.0);
    return state;
}

// Body, force, the first time and how often.
using HalvedSteps = std::vector<std::tuple<int, int, double, long>>;

inline HalvedSteps as_tuples(const std::vector<Halved>& halved) {
    HalvedSteps found;
    for (const Halved& each : halved) found.emplace_back(each.cause.body, each.cause.force, each.first, each.times);
    return found;
}

inline std::vector<Halved> halved_from(const HalvedSteps& given, const Equations& equations) {
    const std::size_t bodies = equations.mechanism().size(), forces = equations.force_count();
    std::vector<Halved> found;
    for (const auto& [body, force, first, times] : given)
        found.push_back({{index_below(body, bodies, "halved"), optional_index(force, forces, "halved")}, first, times});
    return found;
}

inline nb::dict saved_kept(const Kept& kept) {
    nb::dict found;
    found["energy"] = kept.energy;
    found["momenta"] = kept.momenta;
    found["often"] = std::vector<long>{kept.held, kept.rested, kept.refused};
    found["sizes"] = std::vector<double>{kept.given, kept.moved, kept.furthest, kept.largest};
    return found;
}

inline Kept kept_from(const nb::dict& given) {
    const auto often = nb::cast<std::vector<long>>(given["often"]);
    const auto sizes = nb::cast<std::vector<double>>(given["sizes"]);
    if (often.size() != 3 || sizes.size() != 4) refuse("kept", "has a wrong shape");
    return {nb::cast<double>(given["energy"]),
            nb::cast<std::vector<double>>(given["momenta"]),
            often[0],
            often[1],
            often[2],
            sizes[0],
            sizes[1],
            sizes[2],
            sizes[3]};
}

inline std::vector<double> numbers_of(const Eigen::VectorXd& y) { return {y.begin(), y.end()}; }

inline nb::dict saved_mark(const Run& run, const RunState& mark) {
    nb::dict found = saved(mark);
    std::vector<double> angles;
    for (const auto& angle : mark.now.counted.angles)
        angles.insert(angles.end(), {angle.cosine, angle.sine, angle.speed, angle.prescribed});
    const std::size_t size = static_cast<std::size_t>(mark.now.y.size()), sines = angles.size();
    found["y"] = array_of(numbers_of(mark.now.y), size);
    if (run.stepper.carries_slope()) found["slope"] = array_of(numbers_of(mark.now.slope), size);
    found["angles"] = array_of(std::move(angles), sines);
    found["halved"] = as_tuples(mark.halved);
    found["events"] = saved(mark.branches);
    if (run.projector.invariants()) found["kept"] = saved_kept(mark.now.kept);
    if (run.has_contacts()) found["contacts"] = saved(mark.contacts);
    const auto counters = mark.counters.list(mark.now.steps);
    found["counters"] = std::vector<long>(counters.begin(), counters.end());
    std::vector<std::vector<double>> peaks;
    for (const Peak& each : {mark.now.peaks.position, mark.now.peaks.joint, mark.now.peaks.velocity})
        peaks.push_back({each.value, static_cast<double>(each.row), each.time});
    found["peaks"] = peaks;
    return found;
}

inline Eigen::VectorXd finite_numbers(const nb::dict& given, const char* name, std::size_t total) {
    const auto found = nb::cast<Numbers1>(given[name]);
    require(found, {total}, name);
    return Eigen::Map<const Eigen::VectorXd>(found.data(), static_cast<Eigen::Index>(total));
}

inline Peak peak_from(const std::vector<double>& given, int rows) {
    if (given.size() != 3 || !(given[1] >= 0.0 && given[1] < std::max(rows, 1))) refuse("peaks", "do not fit");
    return {given[0], static_cast<long>(given[1]), given[2]};
}

// A mark for a run that was not begun.
inline RunState mark_from(const nb::dict& given, const Run& run) {
    const Mechanism& model = run.model;
    auto mark = saved_from<RunState>(given);
    State& now = mark.now;
    for (const auto& [name, value] : {std::pair("t", now.t), std::pair("h", mark.h)})
        if (!std::isfinite(value)) refuse(name, "is not finite");
    if (!std::isfinite(mark.error.previous)) refuse("previous_error", "is not finite");
    if (mark.grid.part.at < 1) refuse("part", "is none");
    const auto total = static_cast<std::size_t>(model.layout.size());
    const auto coordinates = static_cast<std::size_t>(model.coordinate_count());
    now.y = finite_numbers(given, "y", total);
    const bool carries = run.stepper.carries_slope() && !mark.anew;
    now.slope = carries ? finite_numbers(given, "slope", total) : Eigen::VectorXd(Eigen::VectorXd::Zero(now.y.size()));
    now.lambda.resize(model.all_multipliers());
    const Eigen::VectorXd angles = finite_numbers(given, "angles", 4 * coordinates);
    for (std::size_t i = 0; i < coordinates; ++i) {
        TurnCounter::Angle angle;
        const double* from = angles.data() + 4 * i;
        angle.cosine = from[0], angle.sine = from[1], angle.speed = from[2], angle.prescribed = from[3];
        now.counted.angles.push_back(angle);
    }
    if (now.counted.turns.size() != coordinates) refuse("turns", "has a wrong shape");
    mark.halved = halved_from(nb::cast<HalvedSteps>(given["halved"]), run.equations);
    mark.branches = saved_from<Branches>(nb::cast<nb::dict>(given["events"]));
    if (given.contains("contacts") != run.has_contacts()) refuse("contacts", "do not fit");
    if (run.has_contacts())
        mark.contacts = contacts_from(nb::cast<nb::dict>(given["contacts"]), model.stops.bound.size());
    if (given.contains("kept") != (run.projector.invariants() != nullptr)) refuse("kept", "does not fit");
    if (given.contains("kept")) now.kept = kept_from(nb::cast<nb::dict>(given["kept"]));
    const auto counters = nb::cast<std::vector<long>>(given["counters"]);
    if (counters.size() != Counters::count) refuse("counters", "has a wrong shape");
    now.steps = counters[0], mark.counters = Counters::from(counters);
    const auto peaks = nb::cast<std::vector<std::vector<double>>>(given["peaks"]);
    if (peaks.size() != 3) refuse("peaks", "do not fit");
    const int rows = model.row_count();
    now.peaks = {peak_from(peaks[0], rows), peak_from(peaks[1], rows), peak_from(peaks[2], rows)};
    return mark;
}

}  // namespace mbproj
