// What holds and what slides from one state on, of stops that touch and of dry frictions at joints: as much sticks as can. Rows of
// stops and of frictions at rest are independent; a stop and a friction at rest along one coordinate are one row, that of the
// friction. The reference is mbproj.dynamics.friction.balance.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "model/thresholds.hpp"

namespace mbproj {

// Stops and then frictions: B of their rows, and accelerations b without their forces y. Of each friction its static and its
// sliding force, both to be multiplied by a load, and the direction in which it slides, 0 at rest.
struct FrictionBalance {
    using Vector = Eigen::VectorXd;

    Eigen::Index stops;
    Eigen::MatrixXd B;
    Vector b, fixed, sliding, direction;
    Vector still;                // of each friction, an acceleration that is round-off
    std::vector<bool> able;      // of each row, whether something can move along it
    std::vector<bool> up, down;  // of each friction, whether a stop can push that way along its row

    bool rests(Eigen::Index k) const { return direction[k] == 0.0; }

    // y, with loads(y, found) of the frictions; what slips gets a direction, and what is `stuck` is told. False where there is
    // no such y, or nothing moves along what rests.
    template <class Loads>
    bool decide(const Loads& loads, const Thresholds& thresholds, Vector& y, std::vector<bool>& stuck) {
        const auto count = fixed.size();
        Vector load;
        stuck.assign(static_cast<std::size_t>(count), false);
        while (true) {
            if (!forces(loads, thresholds, y)) return false;
            loads(y, load);
            const Vector a = b + B * y;
            const double none = thresholds.no_push * b.cwiseAbs().maxCoeff();
            Vector slips = Vector::Zero(count);
            for (Eigen::Index k = 0; k < count; ++k) {
                const double force = y[stops + k], own = a[stops + k];
                const double bound = (1.0 - thresholds.slips) * fixed[k] * load[k];
                const bool moves = able[static_cast<std::size_t>(stops + k)];
                const bool holds = rests(k) && moves && least(k, bound) < force && force < most(k, bound);
                stuck[static_cast<std::size_t>(k)] = holds;
                if (!rests(k) || holds) continue;
                const double way = (moves && std::abs(own) <= none && force != 0.0) ? -force : own;
                if (!moves && std::abs(own) <= std::max(none, still[k])) return false;
                slips[k] = way > 0.0 ? 1.0 : way < 0.0 ? -1.0 : 0.0;
                if (slips[k] == 0.0) return false;
            }
            if (slips.isZero(0.0)) return true;
            direction += slips;
        }
    }

private:
    static constexpr int most_rounds = 20000;
    using Limits = std::numeric_limits<double>;

    // What friction up to a bound and stops can do along a friction's row.
    double least(Eigen::Index k, double bound) const {
        return down[static_cast<std::size_t>(k)] ? -Limits::infinity() : -bound;
    }
    double most(Eigen::Index k, double bound) const {
        return up[static_cast<std::size_t>(k)] ? Limits::infinity() : bound;
    }

    // y where frictions at rest hold if they can all, and else up to their static force.
    template <class Loads> bool forces(const Loads& loads, const Thresholds& thresholds, Vector& y) const {
        Vector load;
        if (!relaxed(loads, thresholds, false, y)) return relaxed(loads, thresholds, true, y);
        loads(y, load);
        bool beyond = false;
        for (Eigen::Index k = 0; k < fixed.size(); ++k) {
            const double force = y[stops + k], bound = fixed[k] * load[k];
            beyond = beyond || (rests(k) && (force < least(k, bound) || force > most(k, bound)));
        }
        return !beyond || relaxed(loads, thresholds, true, y);
    }

    // By the method of Gauss and Seidel, projected onto what each force may be; frictions at rest hold any unless `bounded`.
    template <class Loads>
    bool relaxed(const Loads& loads, const Thresholds& thresholds, bool bounded, Vector& y) const {
        const Vector sizes = B.diagonal();
        y = Vector::Zero(b.size());
        Vector a = b, before, load, after;
        double scale = b.size() ? b.cwiseAbs().maxCoeff() : 0.0;
        const auto take = [&](Eigen::Index i, double force) {
            a += (force - y[i]) * B.col(i);
            y[i] = force;
        };
        for (int round = 0; round < most_rounds; ++round) {
            before = y;
            loads(y, load);
            if (!y.allFinite() || !load.allFinite()) return false;
            for (Eigen::Index i = 0; i < b.size(); ++i) {
                const double wanted = able[static_cast<std::size_t>(i)] ? y[i] - a[i] / sizes[i] : 0.0;
                const Eigen::Index k = i - stops;
                if (k < 0)
                    take(i, std::max(wanted, 0.0));
                else if (!rests(k))
                    take(i, -direction[k] * sliding[k] * load[k]);
                else
                    take(i, bounded ? std::clamp(wanted, least(k, fixed[k] * load[k]), most(k, fixed[k] * load[k]))
                                    : wanted);
            }
            loads(y, after);
            const double moved = ((y - before).array() * sizes.array()).abs().maxCoeff();
            scale = std::max(scale, (y.array() * sizes.array()).abs().maxCoeff());
            const bool settled = ((load - after).array().abs() <= thresholds.balanced_to * load.array().abs()).all();
            if (moved <= thresholds.balanced_to * scale && settled) return true;
        }
        return false;
    }
};

}  // namespace mbproj
