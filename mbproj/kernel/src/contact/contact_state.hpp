// Contacts as plain data: laws of stops and frictions, the state of contacts, and recorded events.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "contact/shares.hpp"

namespace mbproj {

// A stop: its side, its restitution, how far its gap may be below zero, and the size of its coordinate. A compliant
// stop has a law, else -1. Its rate counts by the damping c, or by r = `gives_by` / m with the mass m that it meets.
struct StopLaw {
    double side, restitution, slack, size;
    int law = -1;
    double damping = 0.0, gives_by = 0.0;

    bool is_rigid() const { return law < 0; }
};

// A dry friction: its law while it slides; the bearing whose load multiplies it, or -1; its static and sliding force;
// the Stribeck speed, or 0; the size of its coordinate. If these forces change in a run, `bound` is the program of the
// static force, else -1; the law gives the sliding force. At a stop, whose push multiplies it, friction has two
// tangents, each the partner of the other; -1 for none.
struct FrictionLaw {
    int law, bearing;
    double fixed, sliding, stribeck, size;
    int bound = -1, stop = -1, partner = -1;

    // The sliding force at a speed, not multiplied by a load.
    double at(double speed) const {
        const double part = stribeck > 0.0 ? speed / stribeck : 0.0;
        return stribeck > 0.0 ? sliding + (fixed - sliding) * std::exp(-part * part) : sliding;
    }
};

enum class Happening : int { impact, push, rest, contact, release, slip, stick, turn, shared, decides };

// A recorded event: its time; the number of the stop, or after all stops of the friction, and after those of the joint;
// what happens; the direction; for an impact the impulse, and the energy that it takes.
struct ContactEvent {
    double t;
    int stop;
    Happening what;
    int direction;
    double impulse, energy;
};

// Why nothing can be decided: the motion drives into a stop; an impact would create energy; frictions can neither hold nor
// slide, or slide in two ways; meetings do not end; bodies that only contacts hold have no inertia; or friction pushes
// along the motion.
enum class Cause : int { none, driven_into, creates_energy, no_balance, never_ends, no_inertia, pushes };

// The stops or frictions that cause it, numbers from 0; the energy, and other laws of impact that would create none.
struct Undecided {
    Cause cause = Cause::none;
    std::vector<int> which;
    double energy = 0.0;
    std::vector<int> laws;

    bool is_for(Cause found, std::vector<int> of = {}) {  // false, as the caller returns
        cause = found, which = std::move(of);
        return false;
    }
};

using Numbered = std::vector<std::pair<int, double>>;

// The value of a friction or a stop in a list; `none` where it is not in the list.
inline double among(const Numbered& all, int k, double none) {
    for (const auto& [number, found] : all)
        if (number == k) return found;
    return none;
}
inline bool has(const Numbered& all, int k) { return !std::isnan(among(all, k, std::nan(""))); }
inline bool has(const std::vector<int>& all, int k) { return std::find(all.begin(), all.end(), k) != all.end(); }

// The state of contacts, on which the next step depends. Stops that hold, their largest push, the fastest motion so
// far, the time of the last meeting, and how often there was one then. Energy lost in impacts, work of motions there,
// and the number of events. Frictions that slide, with their direction, and those that stick, with the value of their
// coordinate. One that sticks at a stop along the same coordinate shares one row with it. Compliant stops that push,
// with their c or r. Where rows of stops depend on each other, some are held: each stop of `shares` pushes with parts
// of their multipliers, unless it is `idle`; the motion may depend on that, `decides`. `bearing`: frictions at rest
// without a row, with their part of the static force. `starting`, or going `straight` to rest: frictions in a plane
// that keep their direction. `turned`: frictions
// whose slip has turned as it began. `rubbed`: the part of each friction in `lost`. `shared`: contacts, numbered as in events,
// whose forces the motion does not determine.
struct ContactState {
    std::vector<int> held;
    double push = 0.0, fastest = 0.0, met_at = -std::numeric_limits<double>::infinity();
    int met_often = 0;
    double lost = 0.0, work = 0.0;
    long events = 0;
    Numbered sliding, stuck, pushing, bearing, turning;
    std::vector<std::pair<int, Numbered>> shares;
    std::vector<int> idle, straight, starting, shared, turned;
    std::vector<double> rubbed;
    bool decides = false;

    // The parts with which a stop that shares a load pushes, or null.
    const Numbered* parts_of(int stop) const {
        for (const auto& [k, parts] : shares)
            if (k == stop) return &parts;
        return nullptr;
    }
    // Whether a rigid stop pushes.
    bool touches(int stop) const { return (parts_of(stop) || has(held, stop)) && !has(idle, stop); }
    // Sets how stops of these numbers share a load from now on; with null none does.
    void take_shares(const Shares* found, const std::vector<int>& stops) {
        shares.clear(), idle.clear(), decides = found && found->decides;
        for (std::size_t k = 0; found && k < stops.size(); ++k) {
            if (found->apart[k]) continue;
            if (found->idle[k]) idle.push_back(stops[k]);
            shares.emplace_back(stops[k], Numbered());
            for (std::size_t r = 0; r < found->rows.size(); ++r)
                shares.back().second.emplace_back(
                    stops[static_cast<std::size_t>(found->rows[r])],
                    found->parts(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(r)));
        }
    }
};

}  // namespace mbproj
