// Finds the first crossing in a step, where an argument leaves the interval of its branch. Arguments that leave
// together cross as one.
#pragma once

#include <optional>
#include <vector>

#include "model/switches.hpp"
#include "model/thresholds.hpp"

namespace mbproj {

// At the part `theta` of a step the argument `leader`, and with it others, leave their intervals: upwards (1) or downwards
// (-1) in `leaving`, 0 for those that stay. `at_once`: so near to the start of the step that no step ends there. `rate`: of
// the leader's excess, per step.
struct Crossing {
    double theta = 0.0;
    bool at_once = false;
    std::size_t leader = 0;
    std::vector<int> leaving;
    double rate = 0.0;
};

class CrossingSearch {
public:
    using Numbers = std::vector<double>;

    explicit CrossingSearch(const Thresholds& thresholds) : thresholds_(thresholds) {}

    // The first crossing along path(θ, arguments). Arguments that leave within a part `together` of the step leave as
    // one; one that leaves before the part `shortest` leaves at once.
    template <class Path> std::optional<Crossing> first(const Path& path, const std::vector<Interval>& bounds,
                                                        double together, double shortest) {
        const auto excess = [&](double theta, Numbers& found) {
            path(theta, found);
            for (std::size_t k = 0; k < bounds.size(); ++k) found[k] = bounds[k].excess(found[k]);
        };
        before_.resize(bounds.size());
        now_.resize(bounds.size());
        double at = 0.0;
        excess(at, before_);
        for (const double theta : {0.25, 0.5, 0.75, 1.0}) {
            excess(theta, now_);
            if (choose([](double before, double now) { return now > 0.0 && !(before > 0.0); }))
                return described(path, bounds, root(excess, at, theta), together, shortest);
            if (choose([](double before, double now) { return now > 0.0 && before > 0.0 && now > before; })) {
                const double inside = last_inside(excess, at, theta);
                const double found =
                    inside < 0.0 ? at : root(excess, inside, std::min(theta, at + 2.0 * (inside - at)));
                return described(path, bounds, found, together, shortest);
            }
            at = theta;
            before_.swap(now_);
        }
        return std::nullopt;
    }

private:
    static constexpr int halvings = 40, most_looks = 100;

    template <class Test> bool choose(const Test& test) {
        which_.clear();
        for (std::size_t k = 0; k < now_.size(); ++k)
            if (test(before_[k], now_[k])) which_.push_back(k);
        return !which_.empty();
    }

    template <class Excess> double largest(const Excess& excess, double theta) {
        look_.resize(now_.size());
        excess(theta, look_);
        double found = look_[which_.front()];
        for (const std::size_t k : which_) found = std::max(found, look_[k]);
        return found;
    }

    // Looks back from θ, halving the distance to `at`, until the chosen are inside; negative where they never are.
    template <class Excess> double last_inside(const Excess& excess, double at, double theta) {
        for (int halving = 1; halving < halvings; ++halving)
            if (const double look = at + (theta - at) * std::pow(0.5, halving); largest(excess, look) < 0.0)
                return look;
        return -1.0;
    }

    // The zero of the largest excess, negative at `low` and positive at `high`, by the Illinois rule: the upper end of
    // the last interval.
    template <class Excess> double root(const Excess& excess, double low, double high) {
        double below = largest(excess, low), above = largest(excess, high);
        int side = 0;
        for (int look = 0; look < most_looks && high - low > thresholds_.bracketed; ++look) {
            double theta = high - above * (high - low) / (above - below);
            if (!(low < theta && theta < high)) theta = 0.5 * (low + high);
            const double value = largest(excess, theta);
            if (value > 0.0) {
                high = theta;
                above = value;
                if (side > 0) below *= 0.5;
                side = 1;
            } else {
                low = theta;
                below = value;
                if (side < 0) above *= 0.5;
                side = -1;
            }
        }
        return high;
    }

    template <class Path> Crossing described(const Path& path, const std::vector<Interval>& bounds, double root,
                                             double together, double shortest) {
        const double first = std::max(root - thresholds_.beside, 0.0), last = std::min(root + thresholds_.beside, 1.0);
        before_.resize(bounds.size());
        path(first, before_);
        path(last, now_);
        path(root, look_);
        Crossing found;
        found.theta = root;
        found.at_once = root <= shortest;
        found.leader = which_.front();
        for (const std::size_t k : which_)
            if (bounds[k].excess(look_[k]) > bounds[found.leader].excess(look_[found.leader])) found.leader = k;
        for (std::size_t k = 0; k < bounds.size(); ++k) {
            const int direction = bounds[k].direction(look_[k]);
            const double rate = direction * (now_[k] - before_[k]) / (last - first);
            const bool leaves = rate > 0.0 && bounds[k].excess(look_[k]) >= -rate * together;
            found.leaving.push_back(leaves || k == found.leader ? direction : 0);
            if (k == found.leader) found.rate = std::max(rate, 0.0);
        }
        return found;
    }

    const Thresholds& thresholds_;
    std::vector<std::size_t> which_;
    Numbers before_, now_, look_;
};

}  // namespace mbproj
