// Looks for the end of contacts and frictions within a step: gaps that close, or that open again, contacts that would
// pull, sliding that comes to rest, friction that holds no longer. Such a step is made again, to there
// (stepping/stop_events.hpp); the contact policy decides what happens then.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "contacts/gap_cubic.hpp"
#include "dynamics/equations.hpp"

namespace mbproj {

// A condition that ends a step: sign (s - bound) below -slack, s one of the stops' coordinates. Or, `of_rate`, sign s',
// plus another rate with its sign, plus `idle`, below -slack. A rate within the slack over a step of at least
// `rests_over`, s, is at rest, which ends a step, too. `begins`: a friction at rest begins to slide.
struct WatchedGap {
    int stop;
    double sign, slack;
    bool of_rate;
    int other;
    double other_sign, rests_over = std::numeric_limits<double>::infinity(), idle = 0.0;
    bool begins = false;

    // The value or the rate below which the condition is met.
    double least() const { return of_rate ? -slack - idle : -slack; }
};

// A condition that ends a step: bound + part · load + sign λ below -slack, λ the multiplier of a row. The load is that
// of a bearing, or 0 for -1, or the multiplier `by`. With another row, -|λ| of both replaces sign λ. The value of a
// program, if any, multiplies bound and part.
struct WatchedRow {
    int row;
    double sign, slack, bound, part;
    int bearing, other, program = -1, by = -1;
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

class StopWatch {
public:
    explicit StopWatch(Equations& equations)
        : equations_(equations), model_(equations.mechanism()), stops_(model_.stops), inside_(model_.layout.size()) {}

    // Sets what is watched. Forces are evaluated at least every `spacing` seconds, and in the middle of each step.
    void watch(std::vector<WatchedGap> gaps, std::vector<WatchedRow> rows, double spacing) {
        gaps_ = std::move(gaps);
        rows_ = std::move(rows);
        spacing_ = spacing;
    }
    bool any() const { return !gaps_.empty() || !rows_.empty(); }

    // The longest step, at most h, from y with this slope, in which sliding in a plane changes by no more than a part
    // of its speed. At rest its direction changes at once, which no step may pass unseen.
    double longest(const Eigen::VectorXd& y, const Eigen::VectorXd& slope, double h) {
        constexpr double ahead = 1e-3;
        double found = h;
        for (const WatchedGap& each : gaps_) {
            if (each.other < 0 || !(each.idle < 0.0)) continue;  // where it is slow enough it keeps its direction
            double rate[2][2];
            for (int after : {0, 1}) {
                inside_ = y + after * ahead * h * slope;
                equations_.look(inside_.data());
                rate[after][0] = equations_.seen_at_stop(each.stop).rate;
                rate[after][1] = equations_.seen_at_stop(each.other).rate;
            }
            const double change = std::hypot(rate[1][0] - rate[0][0], rate[1][1] - rate[0][1]);
            const double most = model_.thresholds.slides_in * std::hypot(rate[0][0], rate[0][1]);
            if (most < change / ahead) found = std::min(found, most / change * ahead * h);
        }
        return found;
    }

    // Looks at the start of a run, with whole turns of the joints' coordinates.
    void begin(const std::vector<long>& turns) { set_gaps(turns, false, before_); }

    // Whether a step has met something, with the multipliers at its end. `parts`: the parts of the step at which
    // something may be met before its end.
    bool met(const CubicStep& step, const std::vector<long>& turns, const std::vector<double>& lambda) {
        parts_.clear();
        set_gaps(turns, false, now_);
        const bool found = below(before_, now_, step.h, 0.0, 1.0) || gives_way(lambda);
        if (found && is_below(now_)) return true;
        return closes_inside(step, turns, before_, now_, 0.0, 1.0, model_.thresholds.most_halves) || found;
    }
    // The coordinate that has been at rest over the last step, of size h; -1 for none.
    int rests(double h) const {
        for (std::size_t k = 0; k < gaps_.size(); ++k)
            if (gaps_[k].of_rate && h >= gaps_[k].rests_over &&
                std::max(std::abs(before_[k].rate), std::abs(now_[k].rate)) <= gaps_[k].slack)
                return gaps_[k].stop;
        return -1;
    }
    // The next step begins at the end of the last.
    void pass() { before_.swap(now_); }
    const std::vector<double>& parts() const { return parts_; }

    // The watched values at a state: gaps, then forces, without rates. `slacks`: how far each may be below zero.
    void margins(const std::vector<long>& turns, const std::vector<double>& lambda, std::vector<GapRate>& found) const {
        set_gaps(turns, false, found);
        only_rates(found);
        for (const WatchedRow& each : rows_)
            found.push_back({force(each, lambda), std::numeric_limits<double>::quiet_NaN()});
    }
    // The watched values at the start of the last step, where forces are not known.
    std::vector<GapRate> first_margins() const {
        std::vector<GapRate> found = before_;
        only_rates(found);
        found.resize(gaps_.size() + rows_.size(), {0.0, std::numeric_limits<double>::quiet_NaN()});
        return found;
    }
    std::vector<double> slacks() const {
        std::vector<double> found;
        for (const WatchedGap& each : gaps_) found.push_back(each.slack);
        for (const WatchedRow& each : rows_) found.push_back(each.slack);
        return found;
    }
    const std::vector<WatchedGap>& gaps() const { return gaps_; }
    const std::vector<WatchedRow>& rows() const { return rows_; }

    // Whether a force is beyond its bound within a step of size h; solve(part, λ) computes the multipliers inside it.
    template <class Solve> bool gives_way_inside(double h, const Solve& solve) {
        if (rows_.empty()) return false;
        const int looks = std::max(1, static_cast<int>(std::min(std::ceil(h / spacing_), 1e6)) - 1);
        std::vector<double> lambda(model_.all_multipliers());
        for (int look = 1; look <= looks; ++look) {
            const double x = look / (looks + 1.0);
            if (solve(x, lambda) && gives_way(lambda))
                return parts_.insert(std::upper_bound(parts_.begin(), parts_.end(), x), x), true;
        }
        return false;
    }

private:
    // The margin of a watched rate is the rate itself, whose derivative is not known.
    void only_rates(std::vector<GapRate>& found) const {
        for (std::size_t k = 0; k < gaps_.size(); ++k)
            if (gaps_[k].of_rate) found[k] = {found[k].rate + gaps_[k].idle, std::numeric_limits<double>::quiet_NaN()};
    }
    bool is_below(const std::vector<GapRate>& at) const {
        for (std::size_t k = 0; k < gaps_.size(); ++k)
            if ((gaps_[k].of_rate ? at[k].rate : at[k].value) < gaps_[k].least()) return true;
        return false;
    }
    bool gives_way(const std::vector<double>& lambda) const {
        return std::any_of(rows_.begin(), rows_.end(),
                           [&](const WatchedRow& each) { return force(each, lambda) < -each.slack; });
    }
    double force(const WatchedRow& each, const std::vector<double>& lambda) const {
        const double load = each.by >= 0        ? lambda[each.by]
                            : each.bearing >= 0 ? equations_.load(each.bearing, lambda.data())
                                                : 0.0;
        const double own =
            each.other < 0 ? each.sign * lambda[each.row] : -std::hypot(lambda[each.row], lambda[each.other]);
        return (each.program < 0 ? 1.0 : equations_.given(each.program)) * (each.bound + each.part * load) + own;
    }

    // Whether something falls below its bound on the cubics through two looks, at the parts x and x_to of a step, h apart.
    bool below(const std::vector<GapRate>& from, const std::vector<GapRate>& to, double h, double x, double x_to) {
        bool found = false;
        for (std::size_t k = 0; k < gaps_.size(); ++k) {
            const GapCubic cubic(from[k], to[k], h);
            const double least = gaps_[k].least(), theta = gaps_[k].of_rate ? cubic.slowest_at() : cubic.lowest();
            const double ends =
                gaps_[k].of_rate ? std::min(from[k].rate, to[k].rate) : std::min(cubic.value, cubic.end);
            const double inside = gaps_[k].of_rate ? cubic.slowest() : cubic.at(theta);
            found = found || ends < least;
            if (theta > 0.0 && inside < least) found = true, parts_.push_back(x + theta * (x_to - x));
            if (gaps_[k].of_rate || !cubic.may_pass()) continue;
            found = true;
            for (const int eighths : through) parts_.push_back(x + eighths / 8.0 * (x_to - x));
        }
        if (x > 0.0 && found) parts_.push_back(x);
        if (x_to < 1.0 && found) parts_.push_back(x_to);
        return found;
    }

    // Whether a gap closes and opens again between two looks at the parts x and x_to of a step, which its cubic may not
    // show. Where the middle is not on the cubic, looks at each half, at most `halves` times.
    bool closes_inside(const CubicStep& step, const std::vector<long>& turns, const std::vector<GapRate>& from,
                       const std::vector<GapRate>& to, double x, double x_to, int halves) {
        const double middle = 0.5 * (x + x_to), h = (middle - x) * step.h;
        std::vector<GapRate> found;
        step.at(middle, inside_);
        equations_.look(inside_.data());
        set_gaps(turns, true, found);
        bool unlike = false;
        for (std::size_t k = 0; k < gaps_.size(); ++k) {
            if (gaps_[k].of_rate) continue;
            const double expected = 0.5 * (from[k].value + to[k].value) + 0.25 * h * (from[k].rate - to[k].rate);
            if (stops_.joint_coordinate[gaps_[k].stop] >= 0 && equations_.is_angle_at_stop(gaps_[k].stop))
                found[k].value = near(found[k].value, expected);
            const auto [least, largest] = std::minmax({from[k].value, found[k].value, to[k].value});
            const double off = std::abs(found[k].value - expected);
            unlike = unlike || off > std::max({gaps_[k].slack, 0.5 * least, model_.thresholds.middle_unlike * largest});
        }
        if (below(from, found, h, x, middle) || below(found, to, h, middle, x_to)) return true;
        return unlike && halves > 0 &&
               (closes_inside(step, turns, from, found, x, middle, halves - 1) ||
                closes_inside(step, turns, found, to, middle, x_to, halves - 1));
    }

    // At the state in place, or at the one seen beside it.
    void set_gaps(const std::vector<long>& turns, bool beside, std::vector<GapRate>& found) const {
        const auto along = [&](int number) {
            return beside ? equations_.seen_at_stop(number) : equations_.at_stop(number);
        };
        found.clear();
        for (const WatchedGap& each : gaps_) {
            const int coordinate = stops_.joint_coordinate[each.stop];
            const double whole = coordinate < 0 ? 0.0 : 2.0 * M_PI * static_cast<double>(turns[coordinate]);
            const ValueAndRate at = along(each.stop);
            GapRate seen{each.sign * (at.value + whole - stops_.bound[each.stop]), each.sign * at.rate};
            if (each.other >= 0) {
                const ValueAndRate across = along(each.other);
                seen.value += each.other_sign * across.value;
                seen.rate += each.other_sign * across.rate;
            }
            found.push_back(seen);
        }
    }

    Equations& equations_;
    const Mechanism& model_;
    const Stops& stops_;
    std::vector<WatchedGap> gaps_;
    std::vector<WatchedRow> rows_;
    double spacing_ = 1.0;
    std::vector<GapRate> before_, now_;
    std::vector<double> parts_;
    Eigen::VectorXd inside_;
};

}  // namespace mbproj
