#include "contact/contact_policy.hpp"

#include "contact/stop_gap.hpp"

namespace mbproj {

ContactPolicy::ContactPolicy(Equations& equations, ContactState& state)
    : equations_(equations), model_(equations.mechanism()), thresholds_(model_.thresholds),
      touching_(equations, undecided_), friction_(equations, undecided_), compliant_(equations), sharing_(equations),
      state_(state) {}

bool ContactPolicy::begin(std::vector<StopLaw> laws, std::vector<FrictionLaw> frictions, ImpactLaw impacts,
                          ContactState state, LoadedJoints joints_in_space) {
    sharing_.joints_in_space = std::move(joints_in_space);
    laws_ = std::move(laws);
    std::vector<double> sides;
    for (const StopLaw& law : laws_) sides.push_back(law.side);
    compliant_.begin(laws_);
    touching_.begin(laws_, frictions, impacts);
    friction_.begin(std::move(frictions), std::move(sides));
    if (!fits(state)) return false;
    state_ = std::move(state);
    hold();
    return true;
}

bool ContactPolicy::fits(const ContactState& state) const {
    const auto is_rigid = [this](int k) { return k < static_cast<int>(laws_.size()) && laws_[k].is_rigid(); };
    return std::all_of(state.held.begin(), state.held.end(), is_rigid) && friction_.fits(state) &&
           compliant_.fits(state);
}

std::vector<double> ContactPolicy::forces(double t, const double* y, const std::vector<double>& lambda) {
    std::vector<double> found(lambda.begin() + model_.all_rows(), lambda.end());
    for (const auto& [k, parts] : state_.shares) found[k] = std::max(found[k], 0.0);
    friction_.walls().share(state_, lambda, friction_.acting.bounds(), found);
    compliant_.turn(state_, found);
    if (!friction_.acting.any_feet()) return found;
    std::vector<int> push;
    for (int k = 0; k < static_cast<int>(laws_.size()); ++k)
        if (state_.touches(k)) push.push_back(k);
    sharing_.find_least(t, y, state_, friction_.acting.laws(), static_cast<int>(laws_.size()), touching_.rows_of(push),
                        found);
    return found;
}

std::vector<double> ContactPolicy::slides(const std::vector<double>& forces) const {
    std::vector<double> found(forces.size());
    for (const auto& [k, way] : state_.sliding) {
        const std::size_t own = stops() + k;
        const int partner = friction_.acting.laws()[k].partner;
        const double size = partner < 0 ? 0.0 : std::hypot(forces[own], forces[stops() + partner]);
        found[own] = size > 0.0 ? -forces[own] / size : way;
    }
    return found;
}

void ContactPolicy::watch(StopWatch& watch, double spacing) const {
    std::vector<WatchedGap> gaps;
    std::vector<WatchedRow> rows;
    const double slack = std::max(thresholds_.contact_pulls * state_.push, std::numeric_limits<double>::min());
    for (int k = 0; k < static_cast<int>(laws_.size()); ++k)
        if (!laws_[k].is_rigid())
            continue;
        else if (const int row = model_.all_rows() + k; state_.parts_of(k))
            rows.push_back({row, 0.0, slack, 0.0, has(state_.idle, k) ? -1.0 : 1.0, -1, -1, -1, row});
        else if (!holds(k))
            gaps.push_back({k, laws_[k].side, laws_[k].slack, false, -1, 0.0});
        else if (!friction_.walls().has(state_, k))
            rows.push_back({row, 1.0, slack, 0.0, 0.0, -1, -1});
    compliant_.watch(state_, gaps);
    friction_.acting.watch(state_, gaps, rows);
    watch.watch(std::move(gaps), std::move(rows), spacing);
}

bool ContactPolicy::finds_push(const Vector& y, const std::vector<double>& lambda) {
    if (!friction_.any()) return false;
    const int k = friction_.acting.pushes(state_, lambda, std::max(state_.fastest, speed(y)));
    if (k < 0) return false;
    undecided_ = {};
    return !undecided_.is_for(Cause::pushes, {k});
}

bool ContactPolicy::meet(double t, Vector& y, const std::vector<long>& turns, int stop, bool released,
                         double interval) {
    ContactState next = state_;
    std::vector<ContactEvent> events;
    undecided_ = {};
    friction_.ahead = ahead * interval;
    const bool done = touches(t, y, turns, released ? -1 : stop, next, events) &&
                      settle(t, y, turns, stop, released, interval, next, events);
    if (done) {
        press_compliant(turns, next, events);
        next.events += static_cast<long>(events.size());
        events_.insert(events_.end(), events.begin(), events.end());
        y = after_;
        state_ = std::move(next);
    } else if (undecided_.cause == Cause::none) {
        undecided_.cause = Cause::no_inertia;
    }
    hold();
    return done;
}

void ContactPolicy::hold() {
    compliant_.act(state_);
    friction_.acting.hold(state_, touching_.rows_of(state_.held), compliant_.slides(state_));
}

bool ContactPolicy::touches(double t, const Vector& y, const std::vector<long>& turns, int met, ContactState& next,
                            std::vector<ContactEvent>& events) {
    friction_.acting.release();
    equations_.set_pose(t, y.data());
    equations_.set_velocities(y.data(), false);
    if (!equations_.factor(Metric::mass) || !compliant_.meet(t, y, turns, met, speed(y), next, events)) return false;
    std::vector<int> found;
    for (int k = 0; k < static_cast<int>(laws_.size()); ++k) {
        if (!laws_[k].is_rigid()) continue;
        const double gap = stop_gap(equations_, turns, k, laws_[k].side);
        if (holds(k) || gap <= thresholds_.touching * laws_[k].size) found.push_back(k);
    }
    return touching_.touch(std::move(found));
}

void ContactPolicy::press_compliant(const std::vector<long>& turns, ContactState& next,
                                    std::vector<ContactEvent>& events) {
    if (!compliant_.any() || (next.held.empty() && next.shares.empty() && next.sliding.empty() && next.stuck.empty()))
        return;
    friction_.acting.hold(next, touching_.rows_of(next.held), compliant_.slides(next));
    equations_.set_velocities(after_.data(), false);
    compliant_.press(after_, turns, speed(after_), next, events);
}

bool ContactPolicy::settle(double t, const Vector& y, const std::vector<long>& turns, int stop, bool released,
                           double interval, ContactState& next, std::vector<ContactEvent>& events) {
    const double near = 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t), interval);
    next.met_often = t - next.met_at <= near ? next.met_often + 1 : 1;
    next.met_at = t;
    const std::vector<int>& touch = touching_.stops();
    const auto count = static_cast<Eigen::Index>(touch.size());
    const double own = speed(y);
    Flags struck(touch.size()), staying(touch.size());
    Vector slow(count), e = Vector::Zero(count), rate;
    touching_.rates(rate);
    for (Eigen::Index i = 0; i < count; ++i) {
        const StopLaw& law = laws_[touch[i]];
        slow[i] = thresholds_.stop_rests * law.size * (holds(touch[i]) ? std::max(own, next.fastest) : own);
        struck[i] = rate[i] < -slow[i] && !holds(touch[i]);
        if (touching_.bounces(struck[i])) e[i] = law.restitution;
    }
    after_ = y;
    std::vector<ContactEvent> rests;
    if (any(struck) && !touching_.strike(t, y, struck, slow, e, rate, after_, next, events, rests)) return false;
    if (!touching_.keep_down(after_, slow, rate, next)) return false;
    for (Eigen::Index i = 0; i < count; ++i)
        staying[i] = std::abs(rate[i]) <= slow[i] && !(released && touch[i] == stop);
    Vector push = Vector::Zero(count);
    Flags opens(touch.size(), true);
    next.take_shares(nullptr, {});
    const ContactState known = next;
    do {
        next = known;
        if (friction_.any() ? !balance_frictions(t, turns, staying, stop, released, any(struck), next, push, opens)
                            : any(staying) && !press(staying, push, opens, next))
            return false;
    } while (released && let_go(push, staying));
    const bool closed = any(staying);
    const double least = (friction_.any() ? friction_.round_off() : touching_.round_off()) / thresholds_.contact_pulls;
    next.push = closed ? std::max(push.maxCoeff(), least) : 0.0;
    next.held.clear();
    for (Eigen::Index i = 0; i < count; ++i) {
        const bool met = touch[i] == stop && !released, shares = next.parts_of(touch[i]);
        const bool again = staying[i] && !shares && !friction_.acting.any_at(touch[i]) &&
                           ((met && next.met_often > 1) || (!opens[i] && holds(touch[i])));
        const bool wall = staying[i] && friction_.walls().has(next, touch[i]);
        if (again || wall || (push[i] > 0.0 && !shares)) next.held.push_back(touch[i]);
    }
    if (!next.shares.empty())
        for (const auto& [k, part] : next.shares.front().second) next.held.push_back(k);
    std::sort(next.held.begin(), next.held.end());
    if (!find_shares(t, staying, next)) return false;
    record(t, next, rests, events);
    if (events.empty() && (t - state_.met_at) * next.fastest <= thresholds_.met_soon)
        next.met_often = state_.met_often + 1;
    if (next.met_often <= thresholds_.most_meetings) return true;
    return undecided_.is_for(Cause::never_ends, stop < 0 ? std::vector<int>() : std::vector<int>{stop});
}

bool ContactPolicy::let_go(const Vector& push, Flags& staying) const {
    bool found = false;
    for (Eigen::Index i = 0; i < push.size(); ++i) {
        const bool goes = staying[i] && push[i] > 0.0 && push[i] <= thresholds_.contact_pulls * push.maxCoeff();
        if (goes) staying[i] = false, found = true;
    }
    return found;
}

bool ContactPolicy::press(const Flags& staying, Vector& push, Flags& opens, ContactState& next) {
    if (!touching_.pushes(after_, staying, push, opens)) return false;
    std::vector<int> closed;
    std::vector<Eigen::Index> which;
    take(staying, closed, which);
    const Eigen::MatrixXd B = touching_.B_of_stops()(which, which);
    Shares found;
    if (shares_of(B, B, push(which), thresholds_, found)) next.take_shares(&found, closed);
    return true;
}

void ContactPolicy::take(const Flags& staying, std::vector<int>& closed, std::vector<Eigen::Index>& which) const {
    for (std::size_t i = 0; i < staying.size(); ++i)
        if (staying[i]) closed.push_back(touching_.stops()[i]), which.push_back(static_cast<Eigen::Index>(i));
}

bool ContactPolicy::find_shares(double t, const Flags& staying, ContactState& next) {
    std::vector<int> near;
    std::vector<Eigen::Index> which;
    take(staying, near, which);
    const auto stops = static_cast<int>(laws_.size());
    return sharing_.find(t, after_, next, friction_.acting.laws(), stops, touching_.rows_of(near), next.shared);
}

bool ContactPolicy::balance_frictions(double t, const std::vector<long>& turns, const Flags& staying, int met,
                                      bool released, bool struck, ContactState& next, Vector& push, Flags& opens) {
    std::vector<int> closed;
    std::vector<Eigen::Index> which;
    take(staying, closed, which);
    push.setZero(), opens.assign(opens.size(), true);
    const int number = std::max(met - static_cast<int>(laws_.size()), -1), rest = released ? -1 : number;
    const bool gave_way = released && number >= 0 && 2 * next.met_often > thresholds_.most_meetings;
    Vector pushes;
    Flags open;
    if (!friction_.settle(t, after_, turns, touching_.rows_of(closed), rest, !struck, gave_way, next, pushes, open))
        return false;
    push(which) = pushes;
    for (std::size_t i = 0; i < which.size(); ++i) opens[static_cast<std::size_t>(which[i])] = open[i];
    return true;
}

void ContactPolicy::record(double t, const ContactState& next, const std::vector<ContactEvent>& rests,
                           std::vector<ContactEvent>& events) const {
    const auto add = [&](int k, Happening what, int way) { events.push_back({t, k, what, way, 0.0, 0.0}); };
    events.insert(events.end(), rests.begin(), rests.end());
    const auto is_recorded = [&](int k) {
        return std::none_of(rests.begin(), rests.end(), [k](const auto& each) { return each.stop == k; });
    };
    const auto stops = static_cast<int>(laws_.size());
    for (int k = 0; k < stops; ++k)
        if (next.touches(k) && !state_.touches(k) && is_recorded(k)) add(k, Happening::contact, -1);
    for (int k = 0; k < stops; ++k)
        if (state_.touches(k) && !next.touches(k)) add(k, Happening::release, 1);
    for (int k = 0; k < stops; ++k)
        if (next.decides && !state_.decides && next.parts_of(k) && next.touches(k)) add(k, Happening::decides, 1);
    if (!begins()) friction_.record(t, state_, next, events);
    for (const int k : state_.shared)
        if (!has(next.shared, k)) add(k, Happening::shared, -1);
    for (const int k : next.shared)
        if (!has(state_.shared, k)) add(k, Happening::shared, 1);
}

}  // namespace mbproj
