#include "contact/compliant_stops.hpp"

namespace mbproj {

void CompliantStops::begin(const std::vector<StopLaw>& laws) {
    laws_.clear();
    for (int k = 0; k < static_cast<int>(laws.size()); ++k)
        if (!laws[k].is_rigid()) laws_.emplace_back(k, laws[k]);
    if (laws_.empty()) return;
    ActingLaws& applied = equations_.acting_laws();
    if (applied.part.empty()) applied.part.assign(equations_.law_count(), 1.0);
    applied.pace.assign(equations_.law_count(), 1.0);
}

bool CompliantStops::fits(const ContactState& state) const {
    return std::all_of(state.pushing.begin(), state.pushing.end(), [this](const auto& each) {
        return std::any_of(laws_.begin(), laws_.end(), [each](const auto& own) {
            return own.first == each.first && (own.second.gives_by == 0.0 || each.second > 0.0);
        });
    });
}

void CompliantStops::act(const ContactState& state) {
    ActingLaws& applied = equations_.acting_laws();
    for (const auto& [k, stop] : laws_) applied.part[stop.law] = 0.0;
    for (const auto& [k, by] : state.pushing) {
        const StopLaw& stop = law(k);
        applied.part[stop.law] = 1.0;
        applied.pace[stop.law] = stop.gives_by > 0.0 ? 1.0 / std::sqrt(by) : 1.0;
    }
}

std::vector<SlidingRow> CompliantStops::slides(const ContactState& state) const {
    std::vector<SlidingRow> found;
    for (const auto& [k, by] : state.pushing) found.push_back({k, law(k).law});
    return found;
}

void CompliantStops::watch(const ContactState& state, std::vector<WatchedGap>& gaps) const {
    for (const auto& [k, stop] : laws_)
        gaps.push_back({k, pushes(state, k) ? -stop.side : stop.side, stop.slack, false, -1, 0.0});
}

bool CompliantStops::meet(double t, const Vector& y, const std::vector<long>& turns, int met, double own,
                          ContactState& next, std::vector<ContactEvent>& events) {
    const Numbered before = next.pushing;
    for (const auto& [k, by] : before) {
        const StopLaw& stop = law(k);
        if (gap(k, stop, turns) < -thresholds_.touching * stop.size || rate(k, stop) < 0.0) continue;
        end(k, next);
        events.push_back({t, k, Happening::release, 1, 0.0, 0.0});
    }
    for (const auto& [k, stop] : laws_) {
        const double near = thresholds_.touching * stop.size, open = gap(k, stop, turns);
        if (open > near || std::any_of(before.begin(), before.end(), [k = k](auto& each) { return each.first == k; }))
            continue;
        border_->hold({{k, stop.side, model_.stops.bound[k]}});
        if (!border_->factor()) return false;
        const double speed = rate(k, stop), slow = thresholds_.stop_rests * stop.size * own;
        double fall = 0.0;
        if (speed >= -slow && !accelerates(y, fall)) return false;
        const bool stays = speed <= slow ? fall < 0.0 || k == met : speed * speed < -2.0 * fall * stop.slack;
        if (!(open < -near || stays || speed < -slow)) continue;
        begin(k, stop, next);
        events.push_back({t, k, Happening::contact, -1, 0.0, 0.0});
    }
    act(next);
    return true;
}

void CompliantStops::press(const Vector& y, const std::vector<long>& turns, double own, ContactState& next,
                           std::vector<ContactEvent>& events) {
    const auto record = [&](int k, Happening now, Happening before, int direction) {
        const auto same = [=](const ContactEvent& each) { return each.stop == k && each.what == before; };
        const auto taken_back = std::find_if(events.begin(), events.end(), same);
        if (taken_back != events.end()) return void(events.erase(taken_back));
        events.push_back({equations_.time(), k, now, direction, 0.0, 0.0});
    };
    for (const auto& [k, stop] : laws_) {
        if (!is_closed(k, stop, turns) || std::abs(rate(k, stop)) > thresholds_.stop_rests * stop.size * own) continue;
        border_->hold({{k, stop.side, model_.stops.bound[k]}});
        double opening = 0.0;
        if (!border_->factor() || !accelerates(y, opening)) continue;  // the step has the same problem, and tells of it
        if (const bool was = pushes(next, k); was && border_->opens(0, opening))
            end(k, next), record(k, Happening::release, Happening::contact, 1);
        else if (!was && opening < 0.0)
            begin(k, stop, next), record(k, Happening::contact, Happening::release, -1);
    }
}

void CompliantStops::begin(int k, const StopLaw& stop, ContactState& next) const {
    const double by = stop.gives_by > 0.0 ? stop.gives_by * border_->operator_of_rows()(0, 0) : stop.damping;
    next.pushing.emplace_back(k, by);
}

void CompliantStops::end(int k, ContactState& next) {
    const auto of = [k](const auto& each) { return each.first == k; };
    next.pushing.erase(std::find_if(next.pushing.begin(), next.pushing.end(), of));
}

const StopLaw& CompliantStops::law(int number) const {
    return std::find_if(laws_.begin(), laws_.end(), [number](const auto& each) { return each.first == number; })
        ->second;
}

bool CompliantStops::pushes(const ContactState& state, int number) {
    return std::any_of(state.pushing.begin(), state.pushing.end(),
                       [number](const auto& each) { return each.first == number; });
}

bool CompliantStops::accelerates(const Vector& y, double& found) {
    if (!equations_.own_slope_at(y.data(), slope_.data())) return false;
    Vector fall;
    border_->accelerations(1, fall);
    found = fall[0];
    return true;
}

}  // namespace mbproj
