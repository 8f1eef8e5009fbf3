// Looks for what ends the contacts and frictions of a leg within a step: gaps that are closed, or that open again, contacts
// that would pull, sliding that comes to rest, friction that holds no longer. The run halts before such a step; who drives it
// finds the time, and what happens then (mbproj.integrate.stops).
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "dynamics/equations_of_motion.hpp"
#include "kinematics/bearings.hpp"
#include "kinematics/coordinate.hpp"

namespace mbproj {

// What halts a run: sign (s - bound) below -slack, s one of the stops' coordinates; or sign s', to which another one may be
// added with its sign.
struct WatchedGap {
    int stop;
    double sign, slack;
    bool of_rate;
    int other;
    double other_sign;
};

// What halts a run: bound + part · load + sign λ below -slack, λ the multiplier of a row of the constraints, with the load of a
// bearing, or none (-1); with another row, -|λ| of both in place of sign λ.
struct WatchedRow {
    int row;
    double sign, slack, bound, part;
    int bearing, other;
};

// A step as the cubic through both ends with their slopes.
struct CubicStep {
    double h;
    const Eigen::VectorXd &y, &slope, &y_new, &slope_new;

    // The state at the part x of the step.
    void at(double x, Eigen::VectorXd& inside) const {
        const double a = x * x * (3.0 - 2.0 * x);
        inside = (1.0 - a) * y + a * y_new + h * x * (1.0 - x) * ((1.0 - x) * slope - x * slope_new);
    }
};

template <int D> class StopWatch {
public:
    explicit StopWatch(const Model<D>& model)
        : model_(model), stops_(model.stops), inside_(model.layout.size()), pose_(model), motion_(model) {}

    // Forces are looked at every `spacing` seconds at least, and in the middle of each step.
    void watch(std::vector<WatchedGap> gaps, std::vector<WatchedRow> rows, double spacing) {
        gaps_ = std::move(gaps);
        rows_ = std::move(rows);
        spacing_ = spacing;
    }
    bool any() const { return !gaps_.empty() || !rows_.empty(); }

    // Where a run begins, with whole turns of the joints' coordinates.
    void begin(const Pose<D>& pose, const Motion<D>& motion, const std::vector<long>& turns) {
        look(pose, motion, turns, before_);
    }

    // At the end of a step, with the multipliers there: whether it has met something. If not, the next step begins here.
    bool met(const CubicStep& step, const Pose<D>& pose, const Motion<D>& motion, const std::vector<long>& turns,
             const std::vector<double>& lambda) {
        look(pose, motion, turns, now_);
        if (below(before_, now_, step.h) || gives_way(pose, lambda)) return true;
        if (closes_inside(step, turns, before_, now_, 0.0, 1.0, model_.thresholds.most_halves)) return true;
        before_.swap(now_);
        return false;
    }

    // Whether a force is beyond its bound within a step from t.
    bool gives_way_inside(EquationsOfMotion<D>& equations, double t, const CubicStep& step) {
        if (rows_.empty()) return false;
        const int looks = std::max(1, static_cast<int>(std::min(std::ceil(step.h / spacing_), 1e6)) - 1);
        Eigen::VectorXd rate(inside_.size());
        std::vector<double> lambda(model_.all_rows());
        for (int look = 1; look <= looks; ++look) {
            const double x = look / (looks + 1.0);
            step.at(x, inside_);
            if (equations.derivative(t + x * step.h, inside_.data(), rate.data(), lambda.data()) &&
                gives_way(equations.pose(), lambda))
                return true;
        }
        return false;
    }

private:
    bool gives_way(const Pose<D>& pose, const std::vector<double>& lambda) const {
        return std::any_of(rows_.begin(), rows_.end(), [&](const WatchedRow& each) {
            const double load = each.bearing < 0 ? 0.0 : mbproj::load(model_, pose, each.bearing, lambda.data());
            const double force =
                each.other < 0 ? each.sign * lambda[each.row] : -std::hypot(lambda[each.row], lambda[each.other]);
            return each.bound + each.part * load + force < -each.slack;
        });
    }

    struct Look {
        double value, rate;
    };

    // Whether something falls below its bound on the cubics through two looks that lie h apart.
    bool below(const std::vector<Look>& from, const std::vector<Look>& to, double h) const {
        for (std::size_t k = 0; k < gaps_.size(); ++k) {
            const double found = gaps_[k].of_rate ? slowest(from[k], to[k], h) : least(from[k], to[k], h);
            if (found < -gaps_[k].slack) return true;
        }
        return false;
    }

    // Whether a gap closes and opens again between two looks at the parts x and x_to of a step: its cubic may see nothing of
    // that. Where the middle is not on the cubic each half is looked at, so often at most.
    bool closes_inside(const CubicStep& step, const std::vector<long>& turns, const std::vector<Look>& from,
                       const std::vector<Look>& to, double x, double x_to, int halves) {
        const double middle = 0.5 * (x + x_to), h = (middle - x) * step.h;
        std::vector<Look> found;
        step.at(middle, inside_);
        pose_.update(inside_.data());
        motion_.update(inside_.data(), pose_);
        look(pose_, motion_, turns, found);
        bool unlike = false;
        for (std::size_t k = 0; k < gaps_.size(); ++k) {
            if (gaps_[k].of_rate) continue;
            const double expected = 0.5 * (from[k].value + to[k].value) + 0.25 * h * (from[k].rate - to[k].rate);
            if (stops_.joint_coordinate[gaps_[k].stop] >= 0 && is_angle(gaps_[k].stop))
                found[k].value = near(found[k].value, expected);
            const auto [least, largest] = std::minmax({from[k].value, found[k].value, to[k].value});
            const double off = std::abs(found[k].value - expected);
            unlike = unlike || off > std::max(0.5 * least, model_.thresholds.middle_unlike * largest);
        }
        if (below(from, found, h) || below(found, to, h)) return true;
        return unlike && halves > 0 &&
               (closes_inside(step, turns, from, found, x, middle, halves - 1) ||
                closes_inside(step, turns, found, to, middle, x_to, halves - 1));
    }

    bool is_angle(int stop) const { return stops_.coordinates.instances[stop].kind == Kind::angle; }

    void look(const Pose<D>& pose, const Motion<D>& motion, const std::vector<long>& turns,
              std::vector<Look>& found) const {
        found.clear();
        for (const WatchedGap& each : gaps_) {
            const int coordinate = stops_.joint_coordinate[each.stop];
            const double whole = coordinate < 0 ? 0.0 : 2.0 * M_PI * static_cast<double>(turns[coordinate]);
            const Look at = along(each.stop, pose, motion);
            Look seen{each.sign * (at.value + whole - stops_.bound[each.stop]), each.sign * at.rate};
            if (each.other >= 0) {
                const Look across = along(each.other, pose, motion);
                seen.value += each.other_sign * across.value;
                seen.rate += each.other_sign * across.rate;
            }
            found.push_back(seen);
        }
    }

    Look along(int number, const Pose<D>& pose, const Motion<D>& motion) const {
        const Coordinate<D> coordinate(stops_.coordinates, number, pose);
        return {coordinate.value(), coordinate.rate(motion)};
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

    // The least rate within a step, on the same cubic.
    static double slowest(const Look& from, const Look& to, double h) {
        const double ends = std::min(from.rate, to.rate), a = h * from.rate, b = h * to.rate;
        const double change = to.value - from.value;
        const double c3 = a + b - 2.0 * change, c2 = 3.0 * change - 2.0 * a - b;
        const double theta = -c2 / (3.0 * c3);
        if (!(c3 > 0.0 && theta > 0.0 && theta < 1.0)) return ends;
        return std::min(ends, (a + theta * (2.0 * c2 + 3.0 * theta * c3)) / h);
    }

    const Model<D>& model_;
    const Stops<D>& stops_;
    std::vector<WatchedGap> gaps_;
    std::vector<WatchedRow> rows_;
    double spacing_ = 1.0;
    std::vector<Look> before_, now_;
    Eigen::VectorXd inside_;
    Pose<D> pose_;
    Motion<D> motion_;
};

}  // namespace mbproj
