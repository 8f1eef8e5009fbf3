#include "contact/stop_watch.hpp"

namespace mbproj {

void StopWatch::watch(std::vector<WatchedGap> gaps, std::vector<WatchedRow> rows, double spacing) {
    gaps_ = std::move(gaps);
    rows_ = std::move(rows);
    spacing_ = spacing;
}

double StopWatch::longest(const Eigen::VectorXd& y, const Eigen::VectorXd& slope, double h) {
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

bool StopWatch::met(const CubicStep& step, const std::vector<long>& turns, const std::vector<double>& lambda) {
    parts_.clear();
    set_gaps(turns, false, now_);
    const bool found = below(before_, now_, step.h, 0.0, 1.0) || gives_way(lambda);
    if (found && is_below(now_)) return true;
    return closes_inside(step, turns, before_, now_, 0.0, 1.0, model_.thresholds.most_halves) || found;
}

int StopWatch::rests(double h) const {
    for (std::size_t k = 0; k < gaps_.size(); ++k)
        if (gaps_[k].of_rate && h >= gaps_[k].rests_over &&
            std::max(std::abs(before_[k].rate), std::abs(now_[k].rate)) <= gaps_[k].slack)
            return gaps_[k].stop;
    return -1;
}

void StopWatch::margins(const std::vector<long>& turns, const std::vector<double>& lambda,
                        std::vector<ValueAndRate>& found) const {
    set_gaps(turns, false, found);
    only_rates(found);
    for (const WatchedRow& each : rows_)
        found.push_back({force(each, lambda), std::numeric_limits<double>::quiet_NaN()});
}

std::vector<ValueAndRate> StopWatch::first_margins() const {
    std::vector<ValueAndRate> found = before_;
    only_rates(found);
    found.resize(gaps_.size() + rows_.size(), {0.0, std::numeric_limits<double>::quiet_NaN()});
    return found;
}

std::vector<double> StopWatch::slacks() const {
    std::vector<double> found;
    for (const WatchedGap& each : gaps_) found.push_back(each.slack);
    for (const WatchedRow& each : rows_) found.push_back(each.slack);
    return found;
}

void StopWatch::only_rates(std::vector<ValueAndRate>& found) const {
    for (std::size_t k = 0; k < gaps_.size(); ++k)
        if (gaps_[k].of_rate) found[k] = {found[k].rate + gaps_[k].idle, std::numeric_limits<double>::quiet_NaN()};
}

bool StopWatch::is_below(const std::vector<ValueAndRate>& at) const {
    for (std::size_t k = 0; k < gaps_.size(); ++k)
        if ((gaps_[k].of_rate ? at[k].rate : at[k].value) < gaps_[k].least()) return true;
    return false;
}

bool StopWatch::gives_way(const std::vector<double>& lambda) const {
    return std::any_of(rows_.begin(), rows_.end(),
                       [&](const WatchedRow& each) { return force(each, lambda) < -each.slack; });
}

std::vector<double> StopWatch::forces(const std::vector<double>& lambda) const {
    std::vector<double> found;
    for (const WatchedRow& each : rows_) found.push_back(force(each, lambda));
    return found;
}

double StopWatch::worst(const std::vector<double>& margins) const {
    double found = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < margins.size(); ++k) found = std::min(found, margins[k] + rows_[k].slack);
    return found;
}

bool StopWatch::gives_way_at(double x, const std::vector<double>& margins) {
    for (std::size_t k = 0; k < margins.size(); ++k)
        if (margins[k] < -rows_[k].slack)
            return parts_.insert(std::upper_bound(parts_.begin(), parts_.end(), x), x), true;
    return false;
}

bool StopWatch::may_give_way(const std::vector<double>& from, const std::vector<double>& inside,
                             const std::vector<double>& to) const {
    if (inside.empty() || to.empty()) return false;
    for (std::size_t k = 0; k < rows_.size(); ++k) {
        const double off = std::abs(inside[k] - (1.0 - golden) * from[k] - golden * to[k]);
        if (off > std::max(rows_[k].slack, 0.5 * std::min({from[k], inside[k], to[k]}))) return true;
    }
    return false;
}

double StopWatch::force(const WatchedRow& each, const std::vector<double>& lambda) const {
    const double load = each.by >= 0        ? lambda[each.by]
                        : each.bearing >= 0 ? equations_.load(each.bearing, lambda.data())
                                            : 0.0;
    const double own =
        each.other < 0 ? each.sign * lambda[each.row] : -std::hypot(lambda[each.row], lambda[each.other]);
    return (each.program < 0 ? 1.0 : equations_.given(each.program)) * (each.bound + each.part * load) + own;
}

bool StopWatch::below(const std::vector<ValueAndRate>& from, const std::vector<ValueAndRate>& to, double h, double x,
                      double x_to) {
    bool found = false;
    for (std::size_t k = 0; k < gaps_.size(); ++k) {
        const GapCubic cubic(from[k], to[k], h);
        const double least = gaps_[k].least(), theta = gaps_[k].of_rate ? cubic.slowest_at() : cubic.lowest();
        const double ends = gaps_[k].of_rate ? std::min(from[k].rate, to[k].rate) : std::min(cubic.value, cubic.end);
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

bool StopWatch::closes_inside(const CubicStep& step, const std::vector<long>& turns,
                              const std::vector<ValueAndRate>& from, const std::vector<ValueAndRate>& to, double x,
                              double x_to, int halves) {
    const double middle = 0.5 * (x + x_to), h = (middle - x) * step.h;
    std::vector<ValueAndRate> found;
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

void StopWatch::set_gaps(const std::vector<long>& turns, bool beside, std::vector<ValueAndRate>& found) const {
    const auto along = [&](int number) {
        return beside ? equations_.seen_at_stop(number) : equations_.at_stop(number);
    };
    found.clear();
    for (const WatchedGap& each : gaps_) {
        const int coordinate = stops_.joint_coordinate[each.stop];
        const double whole = coordinate < 0 ? 0.0 : 2.0 * M_PI * static_cast<double>(turns[coordinate]);
        const ValueAndRate at = along(each.stop);
        ValueAndRate seen{each.sign * (at.value + whole - stops_.bound[each.stop]), each.sign * at.rate};
        if (each.other >= 0) {
            const ValueAndRate across = along(each.other);
            seen.value += each.other_sign * across.value;
            seen.rate += each.other_sign * across.rate;
        }
        found.push_back(seen);
    }
}

}  // namespace mbproj
