// Contacts of stops as plain data: their laws, which hold or push, and what is recorded of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "laws/shares.hpp"

namespace mbproj {

// A stop: its side, its restitution, how far its gap may be below zero, and what gaps are measured against. One that gives way is a
// law, else -1, and its force depends on the rate by its damping c, or by r = `gives_by` / m, m the mass that it sees.
struct StopLaw {
    double side, restitution, slack, size;
    int law = -1;
    double damping = 0.0, gives_by = 0.0;

    bool is_rigid() const { return law < 0; }
};

// A dry friction: the law that it is while it slides, the bearing by whose load it goes, or -1, its static and its sliding force, the
// speed at which it has fallen from one to the other, or 0, and what its coordinate is measured against. Where these forces change in a
// run, `bound` is the program of the static one, else -1; the sliding one is the law's. At a stop, by whose push it goes, there are two
// along tangents of its plane, each the partner of the other; -1 for none.
struct FrictionLaw {
    int law, bearing;
    double fixed, sliding, stribeck, size;
    int bound = -1, stop = -1, partner = -1;

    // How hard it resists sliding at a speed, before any load.
    double at(double speed) const {
        const double part = stribeck > 0.0 ? speed / stribeck : 0.0;
        return stribeck > 0.0 ? sliding + (fixed - sliding) * std::exp(-part * part) : sliding;
    }
};

enum class Happening : int { impact, push, rest, contact, release, slip, stick, turn, shared, decides };

// What is recorded: when, which stop, or after all stops which friction, and after those which joint, what, where to; of an impact the
// impulse and the energy that it takes.
struct ContactEvent {
    double t;
    int stop;
    Happening what;
    int direction;
    double impulse, energy;
};

// Why nothing can be decided: a stop is driven into; an impact would create energy; more stops take part in it than its law is of;
// frictions can neither hold nor slide, or slide in two ways; something is met again and again; or what only contacts hold has no
// inertia.
enum class Cause : int { none, driven_into, creates_energy, together, no_balance, never_ends, no_inertia };

// Which stops or frictions cause it, these counted from 0; the energy, and the other laws of impact that would create none.
struct Undecided {
    Cause cause = Cause::none;
    std::vector<int> which;
    double energy = 0.0;
    std::vector<int> laws;

    bool is_for(Cause found, std::vector<int> of = {}) {  // false, for who decides
        cause = found, which = std::move(of);
        return false;
    }
};

using Numbered = std::vector<std::pair<int, double>>;

// The number that a friction or a stop has among some; `none` where it has none.
inline double among(const Numbered& all, int k, double none) {
    for (const auto& [number, found] : all)
        if (number == k) return found;
    return none;
}
inline bool has(const Numbered& all, int k) { return !std::isnan(among(all, k, std::nan(""))); }
inline bool has(const std::vector<int>& all, int k) { return std::find(all.begin(), all.end(), k) != all.end(); }

// What the next step depends on: the stops that hold, how hard they push at most, the fastest motion so far, when something was met
// last and how often then; what impacts have lost and motions have worked in no time; how many events were recorded;
// the frictions that slide, and where to, and those that stick, and at which value. Where one sticks at a stop that holds, along
// one coordinate, both are one row. And the stops that give way and push, with what their damping goes by, c or r. Where rows of
// stops that touch depend on each other some are held, and each of `shares` pushes with parts of what those would bear alone, but
// for those that are `idle`; whether the motion `decides` by it. Frictions that stick because others hold them are `bearing` a part
// of their static force; those in a plane that are `starting` or go `straight` to rest keep their direction. Of what impacts have lost
// `rubbed` is the part of each friction; `shared` are the numbers, as events have them, of those whose forces are at will.
struct ContactState {
    std::vector<int> held;
    double push = 0.0, fastest = 0.0, met_at = -std::numeric_limits<double>::infinity();
    int met_often = 0;
    double lost = 0.0, work = 0.0;
    long events = 0;
    Numbered sliding, stuck, pushing, bearing;
    std::vector<std::pair<int, Numbered>> shares;
    std::vector<int> idle, straight, starting, shared;
    std::vector<double> rubbed;
    bool decides = false;

    // The parts by which a stop pushes that touches, or null.
    const Numbered* parts_of(int stop) const {
        for (const auto& [k, parts] : shares)
            if (k == stop) return &parts;
        return nullptr;
    }
    // Whether a rigid stop pushes.
    bool touches(int stop) const { return (parts_of(stop) || has(held, stop)) && !has(idle, stop); }
    // From now on the stops of these numbers share so; or none does.
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
