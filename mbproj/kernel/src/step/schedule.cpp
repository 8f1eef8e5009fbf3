#include "step/schedule.hpp"

namespace mbproj {

void note_halved(std::vector<Halved>& halved, const Unsolved& cause, double t) {
    for (Halved& each : halved)
        if (each.cause.force == cause.force && (cause.force >= 0 || each.cause.body == cause.body)) {
            ++each.times;
            return;
        }
    halved.push_back({cause, t, 1});
}

Schedule::Schedule(const Steps& steps, Grid& grid) : steps_(steps), grid_(grid) {
    pass_break(steps.start);
    if (!steps.fixed()) next_sample_ = 1;
}

void Schedule::resume(double t) {
    if (!steps_.fixed()) next_sample_ = first_after(t);
    passed_ = 0;
    pass_break(t);
    acted_ = passed_;
}

bool Schedule::asks(double t) const {
    for (std::size_t k = acted_; k < steps_.breaks.size() && steps_.breaks[k].time <= t + beside(t); ++k)
        if (steps_.breaks[k].asks) return true;
    return false;
}

bool Schedule::follow(std::vector<double> ends) {
    if (steps_.fixed() || ends.empty() || !(ends.front() > steps_.start) || ends.back() != steps_.end() ||
        std::adjacent_find(ends.begin(), ends.end(), std::greater_equal<>()) != ends.end())
        return false;
    followed_ = std::move(ends);
    return true;
}

bool Schedule::halve(double t, double h, int most) {
    if (!grid_.part.below(most) || !resolves(t, 0.5 * h)) return false;
    grid_.part.halve();
    return true;
}

Target Schedule::to(double t, double time) const {
    const std::size_t next = std::max(next_sample_, first_from(time));
    return {time, time - t, false, is_due(next, time), false, false};
}

void Schedule::reach(const Target& target) {
    if (keeps_ends) ends_.push_back(target.t);
    grid_.steps += target.on_grid;
    next_sample_ += target.due;
    inside_ = 0;
    grid_.part.go_on();
}

TimeWindow Schedule::window() const {
    TimeWindow window;
    if (passed_ > 0) window.first = steps_.breaks[passed_ - 1].right;
    if (passed_ < steps_.breaks.size()) window.last = steps_.breaks[passed_].left;
    return window;
}

Target Schedule::on_grid(double t) const {
    const long k = grid_.steps + 1;
    const bool last = k == steps_.count;
    const double time = last ? steps_.end() : steps_.start + static_cast<double>(k) * steps_.step;
    if (next_break() < time - beside(time)) return {next_break(), next_break() - t, false, false, true, last};
    return {time, time - t, true, k % steps_.every == 0 || last, next_break() <= time + beside(time), last};
}

Target Schedule::part_of(const Target& whole, double t) const {
    if (grid_.part.is_last()) return whole;
    const double grid = steps_.start + static_cast<double>(grid_.steps) * steps_.step;
    const double from = passed_ > 0 ? std::max(grid, steps_.breaks[passed_ - 1].time) : grid;
    const double time = from + grid_.part.end() * (whole.t - from);
    return {time, time - t, false, false, false, whole.shaped};
}

Target Schedule::within(double t, double h) const {
    const double left_over = left(t), size = fitted(h, left_over);
    const double stop = std::min(next_break(), steps_.end());
    const double time = size == left_over ? stop : t + size;
    const std::size_t next = std::max(next_sample_, first_from(time));
    return {time,
            size,
            false,
            is_due(next, time),
            time == stop && next_break() <= time,
            is_before_end() && 2.0 * h > left_over};
}

Target Schedule::along(double t) const {
    const double time = std::min(*std::upper_bound(followed_.begin(), followed_.end() - 1, t), next_break());
    const std::size_t next = std::max(next_sample_, first_from(time));
    return {time, time - t, false, is_due(next, time), next_break() <= time, false};
}

std::size_t Schedule::first_from(double t) const {
    std::size_t found = next_sample_;
    while (found < steps_.samples.count && steps_.sample(found) < t) ++found;
    return found;
}

std::size_t Schedule::first_after(double t) const {
    std::size_t low = 0, high = steps_.samples.count;
    while (low < high) {
        const std::size_t middle = low + (high - low) / 2;
        if (steps_.sample(middle) > t)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

}  // namespace mbproj
