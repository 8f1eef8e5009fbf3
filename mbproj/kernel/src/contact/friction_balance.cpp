// Decides which frictions hold and which slide, from the forces of those that slide so far.
#include "contact/friction_balance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "contact/coulomb_problem.hpp"
#include "contact/rows.hpp"

namespace mbproj {

namespace {
constexpr double huge = std::numeric_limits<double>::max();

}  // namespace

bool FrictionBalance::in_plane(Index k) const {
    const int other = partner[of(k)];
    return other >= 0 && moves(stops + k) && moves(stops + other);
}

double FrictionBalance::with_partner(const Vector& values, Index k) const {
    const int other = partner[of(k)];
    return other < 0 ? std::abs(values[k]) : std::hypot(values[k], values[other]);
}

// Whether friction up to a bound, with walls, can exert this force along a friction's row.
bool FrictionBalance::is_within(Index k, double force, double bound) const {
    return (down[of(k)] || force > -bound) && (up[of(k)] || force < bound);
}

bool FrictionBalance::depend(const Thresholds& thresholds) const {
    std::vector<Index> held;
    for (Index i = 0; i < stops; ++i)
        if (moves(i)) held.push_back(i);
    if (held.empty()) return false;
    for (Index k = 0; k < count(); ++k)
        if (rests(k) && moves(stops + k)) held.push_back(stops + k);
    return independent(B, held, thresholds.no_push).size() < held.size();
}

bool FrictionBalance::depends_at_walls(const Thresholds& thresholds) const {
    bool any = false;
    for (Index k = 0; k < count(); ++k) any = any || at_wall(k);
    return any && depend(thresholds);
}

// The cone of each contact, with these parts of its static force at stops and at joints.
std::vector<Cone> FrictionBalance::cones(double at_stops, double at_joints, const Vector& load) const {
    std::vector<Cone> found;
    const auto holds = [&](Index k) { return rests(k) && moves(stops + k); };
    for (int at = 0; at < static_cast<int>(stops); ++at) {
        if (!moves(at)) continue;
        Cone cone{at, {}, 0.0, {}};
        std::vector<int> held;
        for (Index k = 0; k < count(); ++k) {
            if (stop[of(k)] != at) continue;
            if (!rests(k))
                cone.tangents.push_back(static_cast<int>(stops + k)), cone.slides.push_back(-direction[k] * sliding[k]);
            else if (holds(k))
                held.push_back(static_cast<int>(stops + k));
            cone.most = std::max(cone.most, at_stops * fixed[k]);
        }
        if (cone.slides.empty()) cone.tangents = held;
        found.push_back(cone);
    }
    for (Index k = 0; k < count(); ++k) {
        const int other = partner[of(k)], own = static_cast<int>(stops + k);
        if (stop[of(k)] >= 0 || !holds(k) || (in_plane(k) && other < k)) continue;
        std::vector<int> tangents{own};
        if (in_plane(k)) tangents.push_back(static_cast<int>(stops) + other);
        found.push_back({-1, tangents, at_joints * fixed[k] * load[k], {}});
    }
    return found;
}

// Solves a problem whose friction at joints is proportional to their loads: in passes, each with the loads of the one before.
// solve(load, given, y): `given` are the forces of frictions that slide at joints.
template <class Solve> bool FrictionBalance::with_loads(const Loads& loads, const Thresholds& thresholds,
                                                        const Solve& solve, Vector& y) const {
    const bool by_loads = std::any_of(stop.begin(), stop.end(), [](int at) { return at < 0; });
    y = Vector::Zero(b.size());
    Vector load, before;
    for (int pass = 0; pass < thresholds.most_passes; ++pass) {
        before = load;
        loads(y, load);
        if (pass > 0 && largest(load - before) <= thresholds.slips * largest(load)) return true;
        Vector given = Vector::Zero(b.size());
        for (Index k = 0; k < count(); ++k)
            if (!rests(k) && stop[of(k)] < 0) given[stops + k] = -direction[k] * sliding[k] * load[k];
        if (!solve(load, given, y)) return false;
        if (!by_loads) return true;
    }
    return false;
}

// The forces y with which all frictions at rest hold. Where nothing slides, any share of the load causes the same
// motion. The least one is taken if it has a margin inside the cones, else one with a margin: at their edge it would
// not last.
bool FrictionBalance::all_hold(const Loads& loads, const Thresholds& thresholds, Vector& y) const {
    if (!all_hold(loads, thresholds, thresholds.slips, Vector::Zero(b.size()), y)) return false;
    if (!direction.isZero(0.0) || has_margin(y, 0.1)) return true;
    const double least = 2.0 * thresholds.slips, mean = y.head(stops).mean();
    Vector inner = Vector::Zero(b.size()), within;
    for (Index i = 0; i < stops; ++i)
        if (y[i] > least * mean) inner[i] = mean;
    Thresholds quick = thresholds;
    quick.damped_to = 10.0 * thresholds.rounding;  // a smaller margin does as well as one that is hard to find
    const auto leaves = [&](double margin) {
        return all_hold(loads, margin > least ? quick : thresholds, margin, margin * inner, within);
    };
    if (leaves(0.5)) return y = within, true;
    if (!leaves(least)) return false;
    y = within;
    for (double margin = 0.1; margin > least; margin *= 0.1)
        if (leaves(margin)) return y = within, true;
    return true;
}

// Whether friction at each stop stays inside its cone by this part of the mean push.
bool FrictionBalance::has_margin(const Vector& y, double margin) const {
    const double mean = y.head(stops).mean();
    for (Index k = 0; k < count(); ++k) {
        if (!rests(k) || !moves(stops + k)) continue;
        const double push = stop[of(k)] < 0 ? 0.0 : y[stop[of(k)]];
        if (stop[of(k)] < 0 || !(with_partner(y.tail(count()), k) <= fixed[k] * (push - margin * mean))) return false;
    }
    return true;
}

// The share within the cones that is nearest to `least`. Cones are a little narrower, so that contacts hold for a while; those of
// joints by `margin`.
bool FrictionBalance::all_hold(const Loads& loads, const Thresholds& thresholds, double margin, const Vector& least,
                               Vector& y) const {
    const auto solve = [&](const Vector& load, const Vector& given, Vector& y) {
        const Vector known = least + given;
        Vector found;
        if (!contact_problem(B, b + B * known, cones(1.0 - thresholds.slips, 1.0 - margin, load), thresholds, found))
            return false;
        return y = found + known, true;
    };
    return with_loads(loads, thresholds, solve, y);
}

// The forces y by Coulomb's law with a part of the static forces, and the accelerations `slip` of frictions at rest.
bool FrictionBalance::coulomb(const Loads& loads, const Thresholds& thresholds, double part, Vector& y,
                              Vector& slip) const {
    const auto solve = [&](const Vector& load, const Vector& given, Vector& y) {
        Vector found, rate;
        if (!coulomb_problem(B, b + B * given, cones(part, part, load), thresholds, found, rate)) return false;
        return y = found + given, slip = rate.tail(count()), true;
    };
    return with_loads(loads, thresholds, solve, y);
}

bool FrictionBalance::slip(const Loads& loads, const Thresholds& thresholds, Vector& found) const {
    Vector y;
    if (!coulomb(loads, thresholds, 1.0, y, found)) return false;
    const double none = none_slips(thresholds, y);
    for (Index k = 0; k < count(); ++k)
        if (!rests(k) || std::abs(found[k]) <= none) found[k] = 0.0;
    return true;
}

// The forces y where not all frictions at rest can hold, and the accelerations with which these frictions slip. Where none does,
// the load has just reached what they carry: the slip is that with a little less friction.
bool FrictionBalance::yields(const Loads& loads, const Thresholds& thresholds, Vector& y, Vector& slip) const {
    for (const double less : {0.0, 10.0 * thresholds.slips, gave_way ? thresholds.just_slips : 0.0}) {
        if (!coulomb(loads, thresholds, 1.0 - less, y, slip)) return false;
        const double none = none_slips(thresholds, y);
        for (Index k = 0; k < count(); ++k)
            if (rests(k) && with_partner(slip, k) > none) return true;
    }
    return true;
}

// The round-off of accelerations by these forces.
double FrictionBalance::none_slips(const Thresholds& thresholds, const Vector& y) const {
    return 0.1 * thresholds.no_push * std::max(largest(b), largest(B.diagonal().cwiseProduct(y)));
}

// The directions in which frictions at rest begin to slide: none where all hold; along `slip` where rows yield. A friction is
// `stuck` where it holds and its row is independent of those before.
Eigen::VectorXd FrictionBalance::slips(const Thresholds& thresholds, const Vector& y, const Vector& load, bool holds,
                                       const Vector* slip, Flags& stuck) const {
    const Vector force = y.tail(count()), own = (b + B * y).tail(count());
    Flags inside(of(count()));
    Vector left(count());
    for (Index k = 0; k < count(); ++k) {
        const double bound = fixed[k] * load[k], part = (1.0 - thresholds.slips) * bound;
        const bool within = at_wall(k) ? is_within(k, force[k], part) : with_partner(force, k) < part && bound > 0.0;
        const bool sticks = slip ? with_partner(*slip, k) <= none_slips(thresholds, y) : holds;
        inside[of(k)] = rests(k) && moves(stops + k) && ((sticks && bound > 0.0) || (!slip && within));
        left[k] = at_wall(k) ? huge : bound - with_partner(force, k);
    }
    Span span(B, thresholds.no_push);
    for (Index i = 0; i < stops; ++i)
        if (y[i] > 0.0) span.takes(i);
    std::vector<Index> order(of(count()));
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](Index i, Index j) { return left[i] > left[j]; });
    stuck.assign(of(count()), false);
    Flags seen(of(count()));
    for (const Index k :
         order) {  // of two tangents the one more independent of the rows before comes first, beyond round-off
        const Index other = in_plane(k) ? partner[of(k)] : k;
        const Index first = span.part_beyond(stops + other) > span.part_beyond(stops + k) ? other : k;
        for (const Index each : {first, first == k ? other : k}) {
            if (!seen[of(each)]) stuck[of(each)] = inside[of(each)] && span.takes(stops + each);
            seen[of(each)] = true;
        }
    }
    Vector found = Vector::Zero(count());
    for (Index k = 0; k < count() && !holds; ++k) {
        if (!rests(k)) continue;
        const Index other = in_plane(k) ? partner[of(k)] : k;
        const auto along = [&](const Vector& way) {
            return way[k] / std::max(other == k ? std::abs(way[k]) : std::hypot(way[k], way[other]), tiny);
        };
        const double none = thresholds.no_push * largest(b), large = std::max(none, still[k]);
        const bool is_held = span.holds(stops + k) && span.holds(stops + other);  // by rows that do not slip
        if (!moves(stops + k)) {  // the other tangent gives no information
            if (!inside[of(k)] && std::abs(own[k]) > large) found[k] = std::copysign(1.0, own[k]);
        } else if (slip) {
            const double size = with_partner(*slip, k);
            if (size > none_slips(thresholds, y) && (size > still[k] || !is_held)) found[k] = along(*slip);
        } else if (!inside[of(k)] && (with_partner(own, k) > large || !is_held)) {
            found[k] = with_partner(own, k) > none || force[k] == 0.0 ? along(own) : -along(force);
        }
    }
    return found;
}

bool FrictionBalance::decide(const Loads& loads, const Thresholds& thresholds, Balanced& found) {
    Vector load;
    for (bool again = gave_way;; again = false) {
        const bool dependent = depend(thresholds);
        const bool holds = dependent && !again && all_hold(loads, thresholds, found.y);
        Vector slip;
        const bool gives = dependent && !holds && yields(loads, thresholds, found.y, slip);
        if (!holds && !gives && !forces(loads, thresholds, found.y)) return false;
        loads(found.y, load);
        const Vector more = slips(thresholds, found.y, load, holds, gives ? &slip : nullptr, found.stuck);
        if (!more.isZero(0.0)) {
            direction += more;
            continue;
        }
        found.direction = direction, found.part = Vector::Zero(count());
        for (Index k = 0; k < count(); ++k) {
            const double bound = fixed[k] * load[k];
            if (rests(k) && !found.stuck[of(k)] && moves(stops + k) && bound > 0.0)
                found.part[k] = std::clamp(found.y[stops + k] / bound, -1.0, 1.0);
        }
        const Eigen::MatrixXd pull = pulls();
        found.shared = stops > 0 && shares_of(B.topLeftCorner(stops, stops), pull.transpose() * B * pull,
                                              found.y.head(stops), thresholds, found.shares);
        return true;
    }
}

}  // namespace mbproj
