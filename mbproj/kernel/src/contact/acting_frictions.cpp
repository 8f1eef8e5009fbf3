#include "contact/acting_frictions.hpp"

namespace mbproj {

void ActingFrictions::begin(std::vector<FrictionLaw> laws, std::vector<double> sides) {
    laws_ = std::move(laws);
    stops_ = static_cast<int>(sides.size());
    walls_.begin(std::move(sides), laws_);
    ActingLaws& applied = equations_.acting_laws();
    if (laws_.empty()) return;
    const std::size_t count = equations_.law_count();
    if (applied.part.empty()) applied.part.assign(count, 1.0);
    applied.acts.assign(count, Acts::alone), applied.pushed.assign(count, 1.0);
    applied.turning.assign(count, 0.0);
}

void ActingFrictions::hold(const ContactState& state, std::vector<ContactRow> rows, std::vector<SlidingRow> slides) {
    release();
    walls_.remove(state, rows);
    std::vector<ContactFoot> feet = feet_of(state, rows);
    const auto act = [&](int k, double part, Acts how) {
        const FrictionLaw& law = laws_[k];
        equations_.acting_laws().part[law.law] = part, equations_.acting_laws().acts[law.law] = how;
        slides.push_back({stops_ + k, law.law});
        const auto own =
            std::find_if(feet.begin(), feet.end(), [&](const ContactFoot& f) { return f.stop == law.stop; });
        if (own != feet.end()) own->rubs.push_back(slides.back());
    };
    for (const auto& [k, way] : state.sliding) {
        const bool slow = has(state.straight, k) || has(state.starting, k);
        act(k, way, slow ? Acts::kept : has(state.sliding, laws_[k].partner) ? Acts::in_plane : Acts::alone);
    }
    for (const auto& [k, rate] : state.turning) equations_.acting_laws().turning[laws_[k].law] = rate;
    equations_.acting_laws().since = state.met_at;
    for (const auto& [k, part] : state.bearing) act(k, part * laws_[k].fixed, Acts::given);
    for (const auto& [k, at] : state.stuck) rows.push_back({stops_ + k, 1.0, at});
    equations_.hold_contacts(std::move(rows), std::move(slides), std::move(feet));
}

std::vector<double> ActingFrictions::bounds() const {
    std::vector<double> found;
    for (const FrictionLaw& law : laws_) found.push_back(law.bound < 0 ? law.fixed : equations_.given(law.bound));
    return found;
}

void ActingFrictions::release() {
    ActingLaws& applied = equations_.acting_laws();
    for (const FrictionLaw& law : laws_)
        applied.part[law.law] = applied.turning[law.law] = 0.0, applied.acts[law.law] = Acts::alone;
    equations_.hold_contacts({});
}

void ActingFrictions::watch(const ContactState& state, std::vector<WatchedGap>& gaps,
                            std::vector<WatchedRow>& rows) const {
    for (int k = 0; k < static_cast<int>(laws_.size()); ++k) watch_rate(state, k, gaps);
    for (const auto& [k, at] : state.stuck) watch_force(state, k, rows);
}

int ActingFrictions::pushes(const ContactState& state, const std::vector<double>& lambda, double fastest) const {
    for (const Numbered* all : {&state.sliding, &state.bearing})
        for (const auto& each : *all) {
            const int k = each.first, partner = laws_[k].partner;
            if (partner >= 0 && partner < k && has(*all, partner)) continue;
            double power = 0.0, force = 0.0;
            for (const int own : {k, partner}) {
                if (own < 0 || !has(*all, own)) continue;
                const double F = lambda[model_.all_rows() + stops_ + own];
                power += F * equations_.at_stop(stops_ + own).rate, force = std::hypot(force, F);
            }
            if (power > thresholds_.pushes_along * force * fastest * laws_[k].size) return k;
        }
    return -1;
}

std::vector<ContactFoot> ActingFrictions::feet_of(const ContactState& state,
                                                  const std::vector<ContactRow>& rows) const {
    std::vector<ContactFoot> feet;
    const auto row_of = [&](int stop) {
        return static_cast<std::size_t>(
            std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return row.coordinate == stop; }) -
            rows.begin());
    };
    for (const auto& [stop, parts] : state.shares) {
        feet.push_back({stop, {}, {}});
        for (const auto& [own, part] : parts) feet.back().parts.emplace_back(row_of(own), part);
    }
    for (const int stop : state.held)
        if (any_at(stop) && !state.parts_of(stop)) feet.push_back({stop, {{row_of(stop), 1.0}}, {}});
    return feet;
}

void ActingFrictions::watch_rate(const ContactState& state, int k, std::vector<WatchedGap>& gaps) const {
    const FrictionLaw& law = laws_[k];
    const double fastest = std::max(state.fastest, Limits::min());
    const double slow = std::max(thresholds_.stop_rests * fastest, Limits::min()) * law.size;
    const double way = among(state.sliding, k, 0.0);
    if (!has(state.sliding, k)) {
        if (has(state.stuck, k) || (law.stop >= 0 && !state.touches(law.stop))) return;
        const double moves = thresholds_.turned_speed * fastest * law.size;
        for (const double sign : {1.0, -1.0})  // other rows hold it
            gaps.push_back({stops_ + k, sign, slow, true, -1, 0.0, Limits::infinity(), moves, true});
        return;
    }
    WatchedGap gap{stops_ + k, way, slow, true, -1, 0.0};
    if (!has(state.sliding, law.partner)) {
        if (model_.is_held()) gap.rests_over = thresholds_.rest_steps / fastest;
        return gaps.push_back(gap);
    }
    if (law.partner < k) return;
    const double across = among(state.sliding, law.partner, 0.0);
    const auto watch_along = [&](double own, double other, double idle) {
        gap.sign = own, gap.other = stops_ + law.partner, gap.other_sign = other, gap.idle = idle;
        gaps.push_back(gap);
    };
    const double keeps = thresholds_.straight_speed * fastest * law.size;
    if (const bool stops = has(state.straight, k); stops || has(state.starting, k)) {
        if (stops) watch_along(way, across, 0.0);
        for (const auto& [c, s] : {std::pair{-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}, {1.0, 0.0}})  // faster, any way
            watch_along(c * way - s * across, s * way + c * across, 3.0 * keeps);
        return;
    }
    for (const double turn : {aside, -aside}) {
        const double c = std::cos(turn), s = std::sin(turn);
        watch_along(c * way - s * across, s * way + c * across, 0.0);
    }
    watch_along(way, across, -keeps);
}

void ActingFrictions::watch_force(const ContactState& state, int k, std::vector<WatchedRow>& rows) const {
    const FrictionLaw& law = laws_[k];
    const bool pair = has(state.stuck, law.partner), loaded = law.bearing >= 0 || law.stop >= 0;
    if (pair && law.partner < k) return;
    const double by_partner = among(state.bearing, law.partner, 0.0);
    const double fixed = (law.bound < 0 ? law.fixed : 1.0) * std::sqrt(1.0 - by_partner * by_partner);
    const double slack = loaded || law.bound >= 0 ? Limits::min() : thresholds_.contact_pulls * fixed;
    const int row_of_all = model_.all_rows() + stops_ + k, by = law.stop < 0 ? -1 : model_.all_rows() + law.stop;
    WatchedRow row{row_of_all, 1.0, slack, loaded ? 0.0 : fixed, loaded ? fixed : 0.0, law.bearing, -1, law.bound, by};
    if (pair) {
        row.other = model_.all_rows() + stops_ + law.partner;
        return rows.push_back(row);
    }
    for (const double sign : {1.0, -1.0})
        if (row.sign = sign; !walls_.any(state, k, -sign)) rows.push_back(row);
}

}  // namespace mbproj
