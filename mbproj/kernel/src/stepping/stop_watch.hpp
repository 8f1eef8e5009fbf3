// Looks for stops that a step has met: gaps that are closed within it, or that open again, and contacts that would pull. The
// run halts before such a step; who drives it finds the time, and what happens then (mbproj.integrate.stops).
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "kinematics/pose.hpp"
#include "kinematics/primitives.hpp"

namespace mbproj {

// What halts a run: sign (s - bound) below -slack, s one of the stops' coordinates.
struct WatchedGap {
    int stop;
    double sign, slack;
};

// What halts a run: sign λ below -slack, λ the multiplier of a row of the constraints.
struct WatchedRow {
    int row;
    double sign, slack;
};

template <int D> class StopWatch {
public:
    explicit StopWatch(const Model<D>& model) : stops_(model.stops) {}

    void watch(std::vector<WatchedGap> gaps, std::vector<WatchedRow> rows) {
        gaps_ = std::move(gaps);
        rows_ = std::move(rows);
    }
    bool any() const { return !gaps_.empty() || !rows_.empty(); }

    // Where a run begins, with whole turns of the joints' coordinates.
    void begin(const Pose<D>& pose, const Motion<D>& motion, const std::vector<long>& turns) {
        look(pose, motion, turns, before_);
    }

    // At the end of a step of size h, with the multipliers there: whether it has met something. If not, the next step begins
    // here.
    bool met(double h, const Pose<D>& pose, const Motion<D>& motion, const std::vector<long>& turns,
             const std::vector<double>& lambda) {
        look(pose, motion, turns, now_);
        for (std::size_t k = 0; k < gaps_.size(); ++k)
            if (least(before_[k], now_[k], h) < -gaps_[k].slack) return true;
        for (const WatchedRow& each : rows_)
            if (each.sign * lambda[each.row] < -each.slack) return true;
        before_.swap(now_);
        return false;
    }

private:
    struct Look {
        double value, rate;
    };

    void look(const Pose<D>& pose, const Motion<D>& motion, const std::vector<long>& turns,
              std::vector<Look>& found) const {
        found.clear();
        for (const WatchedGap& each : gaps_) {
            const int coordinate = stops_.joint_coordinate[each.stop];
            const double whole = coordinate < 0 ? 0.0 : 2.0 * M_PI * static_cast<double>(turns[coordinate]);
            const Look at = along(stops_.coordinates.instances[each.stop], pose, motion);
            found.push_back({each.sign * (at.value + whole - stops_.bound[each.stop]), each.sign * at.rate});
        }
    }

    Look along(const Instance& p, const Pose<D>& pose, const Motion<D>& motion) const {
        Point<D> x[most_slots], x_dot[most_slots], g[most_slots];
        for (Point<D>& each : x) each.setZero();
        for (int s = 0; s < p.slot_count; ++s) {
            const Attachment<D>& a = stops_.coordinates.attachments[p.slots[s]];
            x[s].noalias() = pose[a.body].rotation * a.local;
            x_dot[s] = turned_by(motion[a.body].omega, x[s]);
            if (!a.is_point) continue;
            x[s] += pose[a.body].position;
            x_dot[s] += motion[a.body].velocity;
        }
        gradient<D>(p, x, g);
        Look found{value<D>(p, x), 0.0};
        for (int s = 0; s < p.slot_count; ++s) found.rate += g[s].dot(x_dot[s]);
        return found;
    }

    // The least value within a step, on the cubic through both ends with their rates; less than any where a gap that closes
    // as fast as at the start, and opens as fast as at the end, is passed on the way: a body goes through a thin one.
    static double least(const Look& from, const Look& to, double h) {
        const double ends = std::min(from.value, to.value), a = h * from.rate, b = h * to.rate;
        const double change = to.value - from.value;
        const double c3 = a + b - 2.0 * change, c2 = 3.0 * change - 2.0 * a - b;  // value + a θ + c2 θ² + c3 θ³
        if (from.value > 0.0 && from.value + a < 0.0 && to.value - b < 0.0)
            return -std::numeric_limits<double>::infinity();
        const double root = c2 * c2 - 3.0 * c3 * a;
        if (!(a < 0.0 && root > 0.0)) return ends;
        const double theta = -a / (c2 + std::sqrt(root));
        if (!(theta > 0.0 && theta < 1.0)) return ends;
        return std::min(ends, from.value + theta * (a + theta * (c2 + theta * c3)));
    }

    const Stops<D>& stops_;
    std::vector<WatchedGap> gaps_;
    std::vector<WatchedRow> rows_;
    std::vector<Look> before_, now_;
};

}  // namespace mbproj
