// A state between two steps, with its contacts, as plain data for Python, and back: what comes from a file is checked.
#pragma once

#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings/from_numpy.hpp"
#include "stepping/flush_to_zero.hpp"
#include "stepping/time_loop.hpp"

namespace mbproj {

// Calls visit("name", member) for all that a mark has of contacts, of events, or of rows that are kept.
template <class Contacts, class Visit> auto each_saved(Contacts& state, Visit&& visit) -> decltype(void(state.stuck)) {
    visit("held", state.held), visit("idle", state.idle);
    visit("straight", state.straight), visit("starting", state.starting);
    visit("sliding", state.sliding), visit("stuck", state.stuck);
    visit("pushing", state.pushing), visit("bearing", state.bearing);
    visit("turning", state.turning), visit("turned", state.turned);
    visit("shares", state.shares), visit("shared", state.shared);
    visit("rubbed", state.rubbed), visit("decides", state.decides);
    visit("push", state.push), visit("fastest", state.fastest);
    visit("met_at", state.met_at), visit("met_often", state.met_often);
    visit("lost", state.lost), visit("work", state.work), visit("events", state.events);
}
template <class Events, class Visit> auto each_saved(Events& events, Visit&& visit) -> decltype(void(events.at_once)) {
    visit("held", events.held), visit("last", events.last), visit("first", events.first);
    visit("at_once", events.at_once), visit("in_a_row", events.in_a_row);
    visit("times", events.times), visit("told", events.told);
}

template <class T> nb::dict saved(const T& state) {
    nb::dict numbers;
    each_saved(state, [&numbers](const char* name, const auto& value) { numbers[name] = value; });
    return numbers;
}

// What a file has of these. All numbers are there; a file of an older version may be without some lists.
template <class T> T saved_from(const nb::dict& given) {
    T state{};
    each_saved(state, [&given](const char* name, auto& value) {
        using Value = std::decay_t<decltype(value)>;
        if (given.contains(name) || (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>))
            value = nb::cast<Value>(given[name]);
    });
    return state;
}

// Of so many stops and frictions.
inline ContactState contacts_from(const nb::dict& given, std::size_t coordinates) {
    auto state = saved_from<ContactState>(given);
    const std::pair<const char*, std::vector<int>&> lists[] = {{"held", state.held},
                                                               {"idle", state.idle},
                                                               {"straight", state.straight},
                                                               {"starting", state.starting},
                                                               {"turned", state.turned}};
    for (const auto& [name, list] : lists)
        for (const int k : list) index_below(k, coordinates, name);
    const std::pair<const char*, Numbered&> numbered[] = {{"sliding", state.sliding},
                                                          {"stuck", state.stuck},
                                                          {"pushing", state.pushing},
                                                          {"bearing", state.bearing},
                                                          {"turning", state.turning}};
    for (const auto& [name, list] : numbered)
        for (const auto& [k, x] : list) {
            index_below(k, coordinates, name);
            if (!std::isfinite(x)) refuse(name, "is not finite");
        }
    for (const auto& [k, parts] : state.shares) {
        index_below(k, coordinates, "shares");
        for (const auto& [own, part] : parts)
            if (!has(state.held, own) || !std::isfinite(part)) refuse("shares", "are not of stops that are held");
    }
    state.rubbed.resize(coordinates, 0.0);
    return state;
}

// Of each stop its side, restitution, slack and size, and if it gives way its law, damping c, and r times the mass that it sees.
using StopLaws = std::vector<std::tuple<double, double, double, double, int, double, double>>;

// Of each friction its law, bearing, static and sliding force, Stribeck speed and size, stop and partner, and the program of its
// static force, or -1.
using FrictionLaws = std::vector<std::tuple<int, int, double, double, double, double, int, int, int>>;

// What Python says of the joints that bear some forces. The loop runs without the interpreter's lock and without small numbers.
inline LoadedJoints loaded_joints(nb::object joints) {
    return [joints = std::move(joints)](double t, const Eigen::VectorXd& y, const Eigen::MatrixXd& forces) {
        const nb::gil_scoped_acquire locked;
        const KeepDenormals kept;
        const RowMajor rows = forces;
        return nb::cast<std::vector<int>>(
            joints(t, array_of(std::vector<double>(y.begin(), y.end()), y.size()),
                   array_of(std::vector<double>(rows.data(), rows.data() + rows.size()), rows.rows(), rows.cols())));
    };
}

// The loop itself does what happens at stops and frictions with these laws.
inline void begin_contacts(TimeLoop& run, const StopLaws& stops, const FrictionLaws& frictions, const nb::dict& state,
                           double spacing, int impact_law, nb::object joints) {
    const Mechanism& model = run.model();
    if (stops.size() + frictions.size() != model.stops.bound.size()) refuse("laws", "do not fit the stops");
    std::vector<StopLaw> of_stops;
    const std::size_t laws = run.equations().law_count(), bearings = run.equations().bearing_count();
    const std::size_t programs = run.equations().programs().size();
    for (const auto& [side, restitution, slack, size, law, damping, gives_by] : stops)
        of_stops.push_back({side, restitution, slack, size, optional_index(law, laws, "stops"), damping, gives_by});
    std::vector<FrictionLaw> of_frictions;
    for (const auto& [law, bearing, fixed, sliding, stribeck, size, stop, partner, bound] : frictions)
        of_frictions.push_back({index_below(law, laws, "frictions"), optional_index(bearing, bearings, "frictions"),
                                fixed, sliding, stribeck, size, optional_index(bound, programs, "frictions"),
                                optional_index(stop, stops.size(), "frictions"),
                                optional_index(partner, frictions.size(), "frictions")});
    const ContactState begins = contacts_from(state, model.stops.bound.size());
    require_positive(spacing, "spacing");
    const auto impacts = static_cast<ImpactLaw>(index_below(impact_law, 3, "impact_law"));
    LoadedJoints joints_in_space;
    if (!joints.is_none()) joints_in_space = loaded_joints(std::move(joints));
    if (!run.stops().begin(std::move(of_stops), std::move(of_frictions), impacts, begins, spacing,
                           std::move(joints_in_space)))
        refuse("state", "does not fit the laws");
}

// Why nothing can be decided: the cause, whose it is, the energy, and other laws of impact.
inline auto as_tuple(const Undecided& undecided) {
    constexpr const char* names[] = {"",           "driven into", "creates energy", "no balance",
                                     "never ends", "no inertia",  "pushes"};
    return std::make_tuple(std::string(names[static_cast<int>(undecided.cause)]), undecided.which, undecided.energy,
                           undecided.laws);
}

// What was recorded of contacts since the last call.
inline auto take_contact_events(TimeLoop& run) {
    constexpr const char* names[] = {
        "impact", "push of an impact", "rest", "contact", "release", "slip", "stick", "turn",
        "shared", "share decides"};
    std::vector<std::tuple<double, int, std::string, int, double, double>> found;
    for (const ContactEvent& each : run.stops().policy().take_events())
        found.emplace_back(each.t, each.stop, names[static_cast<int>(each.what)], each.direction, each.impulse,
                           each.energy);
    return found;
}

inline std::vector<double> as_list(const Peak& peak) { return {peak.value, static_cast<double>(peak.row), peak.time}; }

inline Peak peak_from(const std::vector<double>& given, int rows) {
    if (given.size() != 3 || !(given[1] >= 0.0 && given[1] < std::max(rows, 1))) refuse("peaks", "do not fit");
    return {given[0], static_cast<long>(given[1]), given[2]};
}

// Body, force, the first time and how often.
using HalvedSteps = std::vector<std::tuple<int, int, double, long>>;

inline HalvedSteps as_tuples(const std::vector<Halved>& halved) {
    HalvedSteps found;
    for (const Halved& each : halved) found.emplace_back(each.cause.body, each.cause.force, each.first, each.times);
    return found;
}

inline std::vector<Halved> halved_from(const HalvedSteps& given, const Equations& equations) {
    const std::size_t forces = equations.force_count();
    std::vector<Halved> found;
    for (const auto& [body, force, first, times] : given)
        found.push_back(
            {{index_below(body, equations.mechanism().size(), "halved"), optional_index(force, forces, "halved")},
             first,
             times});
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
    Kept kept;
    kept.energy = nb::cast<double>(given["energy"]);
    kept.momenta = nb::cast<std::vector<double>>(given["momenta"]);
    const auto often = nb::cast<std::vector<long>>(given["often"]);
    const auto sizes = nb::cast<std::vector<double>>(given["sizes"]);
    if (often.size() != 3 || sizes.size() != 4) refuse("kept", "has a wrong shape");
    kept.held = often[0], kept.rested = often[1], kept.refused = often[2];
    kept.given = sizes[0], kept.moved = sizes[1], kept.furthest = sizes[2], kept.largest = sizes[3];
    return kept;
}

inline nb::dict saved_mark(const Mark& mark) {
    std::vector<double> angles;
    for (const auto& angle : mark.counted.angles)
        angles.insert(angles.end(), {angle.cosine, angle.sine, angle.speed, angle.prescribed});
    const auto counters = mark.counters.list();
    const std::size_t numbers = static_cast<std::size_t>(mark.y.size()), sines = angles.size();
    nb::dict found;
    found["t"] = mark.t;
    found["h"] = mark.h;
    found["grid"] = mark.grid;
    found["part"] = mark.part;
    found["halved"] = as_tuples(mark.halved);
    found["shortened"] = mark.shortened;
    found["shaped"] = mark.shaped;
    found["y"] = array_of(std::vector<double>(mark.y.begin(), mark.y.end()), numbers);
    if (mark.slope.size())
        found["slope"] = array_of(std::vector<double>(mark.slope.begin(), mark.slope.end()), numbers);
    found["angles"] = array_of(std::move(angles), sines);
    found["turns"] = mark.counted.turns;
    found["previous_error"] = mark.control.previous;
    found["rejected"] = mark.control.rejected;
    found["events"] = saved(mark.events);
    if (!mark.other.empty()) found["other"] = mark.other;
    if (mark.kept) found["kept"] = saved_kept(*mark.kept);
    if (mark.contacts) found["contacts"] = saved(*mark.contacts);
    found["counters"] = std::vector<long>(counters.begin(), counters.end());
    found["peaks"] = std::vector<std::vector<double>>{as_list(mark.peaks.position), as_list(mark.peaks.joint),
                                                      as_list(mark.peaks.velocity)};
    return found;
}

inline Eigen::VectorXd finite_numbers(const nb::dict& given, const char* name, std::size_t total) {
    const auto found = nb::cast<Numbers1>(given[name]);
    require(found, {total}, name);
    return Eigen::Map<const Eigen::VectorXd>(found.data(), static_cast<Eigen::Index>(total));
}

inline Mark mark_from(const nb::dict& given, const Equations& equations, bool with_slope) {
    const Mechanism& model = equations.mechanism();
    const auto finite = [&given](const char* name) {
        const auto value = nb::cast<double>(given[name]);
        if (!std::isfinite(value)) refuse(name, "is not finite");
        return value;
    };
    Mark mark;
    mark.t = finite("t");
    mark.h = finite("h");
    mark.grid = nb::cast<long>(given["grid"]);
    mark.part = nb::cast<long>(given["part"]);
    if (mark.part < 1) refuse("part", "is none");
    mark.halved = halved_from(nb::cast<HalvedSteps>(given["halved"]), equations);
    mark.shortened = nb::cast<int>(given["shortened"]);
    const auto says = [&given](const char* name) { return given.contains(name) && nb::cast<bool>(given[name]); };
    mark.shaped = says("shaped"), mark.anew = says("anew");
    const auto total = static_cast<std::size_t>(model.layout.size());
    mark.y = finite_numbers(given, "y", total);
    if (with_slope && !mark.anew) mark.slope = finite_numbers(given, "slope", total);
    const std::size_t coordinates = model.coordinate_count();
    const auto angles = nb::cast<Numbers1>(given["angles"]);
    require(angles, {4 * coordinates}, "angles");
    mark.counted.angles.resize(coordinates);
    for (std::size_t i = 0; i < coordinates; ++i) {
        auto& angle = mark.counted.angles[i];
        const double* from = angles.data() + 4 * i;
        angle.cosine = from[0], angle.sine = from[1], angle.speed = from[2], angle.prescribed = from[3];
    }
    mark.counted.turns = nb::cast<std::vector<long>>(given["turns"]);
    if (mark.counted.turns.size() != coordinates) refuse("turns", "has a wrong shape");
    mark.control = {finite("previous_error"), nb::cast<bool>(given["rejected"])};
    if (given.contains("contacts"))
        mark.contacts = contacts_from(nb::cast<nb::dict>(given["contacts"]), model.stops.bound.size());
    if (given.contains("other")) mark.other = nb::cast<std::vector<double>>(given["other"]);
    if (given.contains("kept")) mark.kept = kept_from(nb::cast<nb::dict>(given["kept"]));
    mark.events = saved_from<SavedEvents>(nb::cast<nb::dict>(given["events"]));
    const auto counters = nb::cast<std::vector<long>>(given["counters"]);
    if (counters.size() != Counters::count) refuse("counters", "has a wrong shape");
    mark.counters = Counters::from(counters);
    const auto peaks = nb::cast<std::vector<std::vector<double>>>(given["peaks"]);
    if (peaks.size() != 3) refuse("peaks", "do not fit");
    const int rows = model.row_count();
    mark.peaks = {peak_from(peaks[0], rows), peak_from(peaks[1], rows), peak_from(peaks[2], rows)};
    return mark;
}

}  // namespace mbproj
