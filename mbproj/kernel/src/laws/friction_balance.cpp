// Decides which frictions hold and which slide, from the forces of those that slide so far.
#include "laws/friction_balance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace mbproj {

namespace {
constexpr double tiny = std::numeric_limits<double>::min();

std::size_t of(Eigen::Index k) { return static_cast<std::size_t>(k); }
double largest(const Eigen::VectorXd& x) { return x.size() ? x.cwiseAbs().maxCoeff() : 0.0; }

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

// The cone of each contact; at rest a little narrower, so that contacts hold for a while; at joints also by `margin`.
std::vector<Cone> FrictionBalance::cones(const Thresholds& thresholds, double margin, const Flags& rest,
                                         const Vector& load) const {
    std::vector<Cone> found;
    for (int at = 0; at < static_cast<int>(stops); ++at) {
        if (!moves(at)) continue;
        Cone cone{at, {}, 0.0, {}};
        std::vector<int> holds;
        for (Index k = 0; k < count(); ++k) {
            if (stop[of(k)] != at) continue;
            if (!rests(k))
                cone.tangents.push_back(static_cast<int>(stops + k)), cone.slides.push_back(-direction[k] * sliding[k]);
            else if (rest[of(k)])
                holds.push_back(static_cast<int>(stops + k));
            cone.most = std::max(cone.most, (1.0 - thresholds.slips) * fixed[k]);
        }
        if (cone.slides.empty()) cone.tangents = holds;
        found.push_back(cone);
    }
    for (Index k = 0; k < count(); ++k)
        if (stop[of(k)] < 0 && rest[of(k)])
            found.push_back({-1, {static_cast<int>(stops + k)}, (1.0 - margin) * fixed[k] * load[k], {}});
    return found;
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

// The share within the cones that is nearest to `least`; the cones of joints are narrower by `margin`.
bool FrictionBalance::all_hold(const Loads& loads, const Thresholds& thresholds, double margin, const Vector& least,
                               Vector& y) const {
    Flags rest;
    for (Index k = 0; k < count(); ++k) rest.push_back(rests(k) && moves(stops + k));
    const bool by_loads =
        std::any_of(stop.begin(), stop.end(), [](int at) { return at < 0; });  // of frictions at joints
    y = Vector::Zero(b.size());
    Vector load, before;
    for (int pass = 0; pass < thresholds.most_passes; ++pass) {
        before = load;
        loads(y, load);
        if (pass > 0 && largest(load - before) <= thresholds.slips * largest(load)) return true;
        Vector given = least, found;
        for (Index k = 0; k < count(); ++k)
            if (!rests(k) && stop[of(k)] < 0) given[stops + k] = -direction[k] * sliding[k] * load[k];
        const std::vector<Cone> own = cones(thresholds, margin, rest, load);
        if (!contact_problem(B, b + B * given, own, 0.0, thresholds, found)) return false;
        y = found + given;
        if (!by_loads) return true;
    }
    return false;
}

// The forces y of dependent rows where not all can hold: those of springs with a tiny compliance. The pushes of the pass before
// multiply the friction (Haslinger 1983). False where joints have friction too, or where passes do not converge.
bool FrictionBalance::yields(const Loads& loads, const Thresholds& thresholds, Vector& y) const {
    if (std::any_of(stop.begin(), stop.end(), [](int at) { return at < 0; })) return false;
    const std::vector<Cone> of_pushes = cones(thresholds, 0.0, Flags(of(count())), Vector());
    Vector load, found;
    y = Vector::Zero(b.size());
    for (int pass = 0; pass < thresholds.most_passes; ++pass) {
        loads(y, load);
        const Vector most = (1.0 - 10.0 * thresholds.springs_give) * fixed.cwiseProduct(load);
        std::vector<Cone> all = of_pushes;
        for (Index k = 0; k < count(); ++k) {
            const int other = partner[of(k)], own = static_cast<int>(stops + k);
            if (!rests(k) || !moves(own)) continue;
            if (!in_plane(k))
                all.push_back({-1, {own}, most[k], {}});
            else if (other > k)
                all.push_back({-1, {own, static_cast<int>(stops) + other}, most[k], {}});
        }
        const double give = thresholds.springs_give * B.diagonal().maxCoeff();
        if (!contact_problem(B, b, all, give, thresholds, found)) return false;
        const double change = largest(found - y);
        y = found;
        if (change > thresholds.springs_give * largest(y)) continue;
        loads(y, load);
        for (Index k = 0; k < count(); ++k)  // slipping friction is that of the current push
            if (rests(k) && moves(stops + k)) y[stops + k] *= fixed[k] * load[k] / (most[k] > 0.0 ? most[k] : 1.0);
        return true;
    }
    return false;
}

// The directions in which frictions at rest begin to slide: none where all hold; against their forces where rows yield,
// since these rows hardly move. A friction is `stuck` where it holds and its row is independent of those before.
Eigen::VectorXd FrictionBalance::slips(const Thresholds& thresholds, const Vector& y, const Vector& load, bool holds,
                                       bool yields, Flags& stuck) const {
    const Vector force = y.tail(count()), own = (b + B * y).tail(count());
    Flags inside(of(count()));
    Vector used(count());
    for (Index k = 0; k < count(); ++k) {
        const double bound = fixed[k] * load[k], part = (1.0 - thresholds.slips) * bound;
        const bool within = at_wall(k) ? is_within(k, force[k], part) : with_partner(force, k) < part && bound > 0.0;
        inside[of(k)] = rests(k) && moves(stops + k) && ((holds && bound > 0.0) || within);
        used[k] = at_wall(k) ? 0.0 : bound > 0.0 ? with_partner(force, k) / bound : 1.0;
    }
    Span span(B, thresholds.no_push);
    for (Index i = 0; i < stops; ++i)
        if (y[i] > 0.0) span.takes(i);
    std::vector<Index> order(of(count()));
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](Index i, Index j) { return used[i] < used[j]; });
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
        if (!rests(k) || inside[of(k)]) continue;
        const Index other = in_plane(k) ? partner[of(k)] : k;
        const double none = thresholds.no_push * largest(b);
        const bool accelerates = with_partner(own, k) > none, begins = accelerates && with_partner(own, k) > still[k];
        if (!moves(stops + k)) {  // the other tangent gives no information
            const double size = std::abs(own[k]);
            found[k] = size > none && size > still[k] ? std::copysign(1.0, own[k]) : 0.0;
        } else if ((begins && !yields) || !(span.holds(stops + k) && span.holds(stops + other))) {
            const Vector& way = (accelerates && !yields) || force[k] == 0.0 ? own : force;
            const double size = other == k ? std::abs(way[k]) : std::hypot(way[k], way[other]);
            found[k] = (&way == &own ? way[k] : -way[k]) / std::max(size, tiny);
        }
    }
    return found;
}

bool FrictionBalance::decide(const Loads& loads, const Thresholds& thresholds, Balanced& found) {
    Vector load;
    while (true) {
        const bool dependent = depend(thresholds);
        const bool holds = dependent && all_hold(loads, thresholds, found.y);
        const bool gives = dependent && !holds && yields(loads, thresholds, found.y);
        if (!holds && !gives && !forces(loads, thresholds, found.y)) return false;
        loads(found.y, load);
        const Vector more = slips(thresholds, found.y, load, holds, gives, found.stuck);
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
