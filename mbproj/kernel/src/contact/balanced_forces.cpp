// The conditions of contact are satisfied one after another until all hold (non-smooth contact dynamics, Jean and Moreau 1992).
#include "contact/friction_balance.hpp"
#include "contact/rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mbproj {

namespace {
constexpr int most_rounds = 20000, most_turns = 50;
// Where the change in a round is almost as large as that many rounds before, the iteration is given up: dependent rows
// have conditions that no forces satisfy.
constexpr int looks_back = 256;
constexpr double stalls = 0.9;
constexpr double overflows = 1e200;

}  // namespace

// The forces along all rows by a push of 1 at each stop, with the friction that slides there.
Eigen::MatrixXd FrictionBalance::pulls() const {
    Eigen::MatrixXd found = Eigen::MatrixXd::Identity(b.size(), stops);
    for (Index k = 0; k < count(); ++k)
        if (const int at = stop[of(k)]; at >= 0 && !rests(k)) found(stops + k, at) = -direction[k] * sliding[k];
    return found;
}

// The projected Gauss-Seidel method: each force is projected to its bounds; frictions at rest have bounds only if `bounded`.
bool FrictionBalance::relaxed(const Loads& loads, const Thresholds& thresholds, bool bounded, Vector& y) const {
    const Vector sizes = B.diagonal();
    const Eigen::MatrixXd pull = pulls(), pushed = B * pull;
    y = Vector::Zero(b.size());
    Vector a = b, before, load, after, step(count());
    double scale = largest(b), moved_before = std::numeric_limits<double>::infinity();
    for (Index i = 0; i < stops; ++i)
        if (moves(i) && !(pushed(i, i) > 0.0)) return false;
    for (Index k = 0; k < count(); ++k) {
        if (!in_plane(k)) continue;
        const Index i = stops + k, j = stops + partner[of(k)];
        step[k] = 2.0 / (B(i, i) + B(j, j) + std::hypot(B(i, i) - B(j, j), 2.0 * B(i, j)));
    }
    const auto take = [&](Index i, double force) {
        a += (force - y[i]) * B.col(i);
        y[i] = force;
    };
    for (int round = 0; round < most_rounds; ++round) {
        before = y;
        loads(y, load);
        if (!y.allFinite() || !load.allFinite() || !(largest(y) < overflows)) return false;
        for (Index i = 0; i < stops; ++i) {
            if (!moves(i)) continue;
            const double change = std::max(y[i] - a[i] / pushed(i, i), 0.0) - y[i];
            a += change * pushed.col(i);
            y += change * pull.col(i);
        }
        for (Index k = 0; k < count(); ++k) {
            const Index i = stops + k;
            const double bound = fixed[k] * load[k];
            if (!rests(k)) {
                if (stop[of(k)] < 0) take(i, -direction[k] * sliding[k] * load[k]);
            } else if (!moves(i)) {
                take(i, 0.0);
            } else if (!in_plane(k)) {
                const double wanted = y[i] - a[i] / sizes[i];
                take(i, !bounded || is_within(k, wanted, bound) ? wanted : std::copysign(bound, wanted));
            } else if (partner[of(k)] > k) {
                const Index j = stops + partner[of(k)];
                const double own = y[i] - step[k] * a[i], other = y[j] - step[k] * a[j];
                const double part = bounded ? std::min(1.0, bound / std::max(std::hypot(own, other), tiny)) : 1.0;
                take(i, part * own);
                take(j, part * other);
            }
        }
        loads(y, after);
        const double moved = largest((y - before).cwiseProduct(sizes));
        scale = std::max(scale, largest(y.cwiseProduct(sizes)));
        const bool settled = ((load - after).array().abs() <= thresholds.no_digits * load.array().abs()).all();
        const bool still_now = moved <= thresholds.no_digits * scale;
        if (still_now && settled) return true;
        if (round == 0 || round % looks_back) continue;
        if (!still_now && moved > stalls * moved_before) return false;
        moved_before = moved;
    }
    return false;
}

FrictionBalance::Flags FrictionBalance::beyond(const Loads& loads, const Vector& y) const {
    Flags found(of(count()));
    Vector load;
    loads(y, load);
    const Vector force = y.tail(count());
    for (Index k = 0; k < count(); ++k) {
        const double bound = fixed[k] * load[k];
        const bool more =
            at_wall(k) ? !is_within(k, force[k], bound) && std::abs(force[k]) > bound : with_partner(force, k) > bound;
        found[of(k)] = rests(k) && more;
    }
    return found;
}

// The forces y where frictions that would exceed their static force slide against it. It serves where friction is so
// strong that changing one force after the other does not converge.
bool FrictionBalance::slipping(const Loads& loads, const Thresholds& thresholds, const Vector& held, Vector& y) const {
    const Flags slip = beyond(loads, held);
    y = held;
    for (int turn = 0; turn < most_turns; ++turn) {
        FrictionBalance next = *this;
        const Vector force = y.tail(count());
        for (Index k = 0; k < count(); ++k) {
            if (!slip[of(k)]) continue;
            const double size = with_partner(force, k);
            next.direction[k] -= size > 0.0 ? force[k] / size : 0.0;
            next.sliding[k] = fixed[k];
        }
        Vector found;
        if (!next.relaxed(loads, thresholds, true, found)) return false;
        const Vector way = next.direction - direction, moved = (b + B * found).tail(count()).cwiseProduct(way);
        for (Index k = 0; k < count(); ++k) {
            const int other = partner[of(k)];
            const double own = moved[k] + (other < 0 ? 0.0 : moved[other]);
            if (slip[of(k)] && own < -thresholds.no_push * largest(b)) return false;
        }
        const double change = largest(found - y);
        y = found;
        if (change <= thresholds.slips * largest(found)) return true;
    }
    return false;
}

bool FrictionBalance::forces(const Loads& loads, const Thresholds& thresholds, Vector& y) const {
    Vector held;
    if (!relaxed(loads, thresholds, false, held)) return relaxed(loads, thresholds, true, y);
    const Flags more = beyond(loads, held);
    y = held;
    if (std::find(more.begin(), more.end(), true) == more.end()) return true;
    return relaxed(loads, thresholds, true, y) || slipping(loads, thresholds, held, y);
}

}  // namespace mbproj
