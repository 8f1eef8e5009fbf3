#include "contact/dry_friction.hpp"

namespace mbproj {

DryFriction::DryFriction(Equations& equations, Undecided& undecided)
    : acting(equations), equations_(equations), model_(equations.mechanism()), thresholds_(model_.thresholds),
      undecided_(undecided), border_(equations.border()), later_(equations.border()),
      lambda_(model_.all_multipliers()) {}

void DryFriction::begin(std::vector<FrictionLaw> laws, std::vector<double> sides) {
    laws_ = laws;
    stops_ = static_cast<int>(sides.size());
    acting.begin(std::move(laws), std::move(sides));
}

bool DryFriction::fits(const ContactState& state) const {
    const auto is_one = [this](const auto& each) { return each.first < static_cast<int>(laws_.size()); };
    const auto are_some = [&](const auto& all) { return std::all_of(all.begin(), all.end(), is_one); };
    return are_some(state.sliding) && are_some(state.stuck) && are_some(state.bearing);
}

bool DryFriction::settle(double t, Vector& y, const std::vector<long>& turns, const std::vector<ContactRow>& closed,
                         int met, bool known, bool gave_way, ContactState& next, Vector& push, Flags& opens,
                         bool own_walls) {
    std::vector<ContactRow> rows = closed, none;
    touching_ = walls().take_from(own_walls ? none : rows);
    first_ = static_cast<Eigen::Index>(rows.size());
    std::vector<int> stops;
    for (const ContactRow& row : rows) stops.push_back(row.coordinate);
    rubs_.clear();
    for (int k = 0; k < static_cast<int>(laws_.size()); ++k)
        if (laws_[k].stop < 0 || has(stops, laws_[k].stop)) rubs_.push_back(k), rows.push_back({stops_ + k, 1.0, 0.0});
    border_->hold(std::move(rows));
    equations_.set_pose(t, y.data());
    equations_.set_velocities(y.data(), false);
    if (!equations_.factor(Metric::mass) || !border_->factor()) return false;
    equations_.variables_at(t, y.data());
    fixed_ = acting.bounds();
    border_->rates(rate_);
    const Flags rests = rest(met, known, next);
    if (!stop_all(y, rests, next.fastest)) return false;
    FrictionBalance problem = balance(stops, rests, next.fastest);
    problem.gave_way = gave_way;
    const Vector speed = rate_.tail(problem.fixed.size());
    if (problem.depends_at_walls(thresholds_))
        return settle(t, y, turns, closed, met, known, gave_way, next, push, opens, true);
    const bool all_slide = std::find(rests.begin(), rests.end(), true) == rests.end();
    if (!accelerations(*border_, y, problem.b)) return false;
    if (first_ == 0 && all_slide)
        if (const std::vector<int> names = jams(problem); !names.empty())
            return undecided_.is_for(Cause::no_balance, names);
    const FrictionBalance before = problem;
    Balanced found;
    const auto loads = [&](const Vector& along, Vector& carried) { loads_of(problem, along, carried); };
    if (!problem.decide(loads, thresholds_, found)) return undecided_.is_for(Cause::no_balance, at_rest(problem));
    Vector load;
    loads(found.y, load);
    const Vector after = problem.b + problem.B * found.y;
    push.resize(static_cast<Eigen::Index>(closed.size()));
    opens.assign(closed.size(), true);
    Eigen::Index own = 0;
    for (std::size_t i = 0; i < closed.size(); ++i) {
        const int k = own_walls ? -1 : walls().along(closed[i].coordinate);
        if (k < 0) opens[i] = border_->opens(own, after[own]);
        const double force = k < 0 ? found.y[own++] : closed[i].sign * found.y[first_ + place(k)];
        push[static_cast<Eigen::Index>(i)] =
            k < 0 ? force : Walls::push_of(force, fixed_[static_cast<std::size_t>(k)] * load[place(k)]);
    }
    take(found, problem, speed, after.tail(speed.size()), turns, known, next);
    next.take_shares(found.shared ? &found.shares : nullptr, stops);
    if (own_walls) walls().stick(closed, next);
    return next.starting.empty() || turn(t, y, before, found, next);
}

void DryFriction::record(double t, const ContactState& before, const ContactState& after,
                         std::vector<ContactEvent>& events) const {
    for (int k = 0; k < static_cast<int>(laws_.size()); ++k) {
        const FrictionLaw& law = laws_[k];
        if (law.partner >= 0 && law.partner < k) continue;
        if (law.stop >= 0 && !(before.touches(law.stop) && after.touches(law.stop))) continue;
        const double was = among(before.sliding, k, 0.0), now = among(after.sliding, k, 0.0);
        const auto add = [&](Happening what) {
            events.push_back({t, stops_ + k, what, static_cast<int>(std::nearbyint(now)), 0.0, 0.0});
        };
        if (has(before.sliding, k) != has(after.sliding, k))
            add(has(after.sliding, k) ? Happening::slip : Happening::stick);
        else if (was * now < 0.0 && law.stop < 0)
            add(Happening::turn);
    }
}

double DryFriction::speed(std::size_t i) const {
    const int other = partner_of(rubs_[i]);
    const double own = rate_[first_ + static_cast<Eigen::Index>(i)];
    return other < 0 ? std::abs(own) : std::hypot(own, rate_[first_ + other]);
}

DryFriction::Flags DryFriction::rest(int met, bool known, const ContactState& state) const {
    Flags found(rubs_.size());
    double slow = thresholds_.stop_rests * state.fastest;
    for (std::size_t i = 0; i < rubs_.size(); ++i) {
        if (rubs_[i] != met) continue;
        const double own = speed(i) / laws_[met].size;
        if (laws_[met].partner < 0 || own < thresholds_.turned_speed * state.fastest) slow = std::max(slow, 8.0 * own);
    }
    for (std::size_t i = 0; i < rubs_.size(); ++i) {
        const int k = rubs_[i];
        const bool sticks = known && (has(state.stuck, k) || (has(state.bearing, k) && !faster(i, state)));
        found[i] = sticks || speed(i) <= slow * laws_[k].size || !touching_[k].empty();
    }
    return found;
}

bool DryFriction::stop_all(Vector& y, const Flags& rests, double fastest) {
    std::vector<Eigen::Index> which;
    Vector wanted = Vector::Zero(rate_.size()), z = wanted, own;
    bool moves = false;
    for (Eigen::Index i = 0; i < rate_.size(); ++i) {
        const Eigen::Index at = i - first_;
        if (at >= 0 && !rests[static_cast<std::size_t>(at)]) continue;
        if (border_->moves(i) || at < 0) which.push_back(i);
        if (at < 0 || !border_->moves(i)) continue;
        wanted[i] = rate_[i];
        moves = moves || std::abs(rate_[i]) > thresholds_.stop_rests * fastest * laws_[rubs_[at]].size;
    }
    if (!moves) return true;
    SemidefiniteCholesky cholesky;
    cholesky.factor(border_->operator_of_rows()(which, which), thresholds_.no_push);
    cholesky.solve(wanted(which), own);
    z(which) = own;
    if (!border_->respond(z)) return false;
    equations_.add_velocities(y);
    equations_.set_velocities(y.data(), false);
    border_->rates(rate_);
    return true;
}

FrictionBalance DryFriction::balance(const std::vector<int>& stops, const Flags& rests, double fastest) {
    const auto count = static_cast<Eigen::Index>(rubs_.size());
    for (std::size_t i = 0; i < rubs_.size(); ++i)
        if (rests[i]) rate_[first_ + static_cast<Eigen::Index>(i)] = 0.0;
    FrictionBalance found;
    found.stops = first_, found.B = border_->operator_of_rows();
    found.fixed = found.sliding = found.direction = found.still = Vector(count);
    for (Eigen::Index i = 0; i < first_ + count; ++i) found.able.push_back(border_->moves(i));
    for (Eigen::Index i = 0; i < count; ++i) {
        const int k = rubs_[static_cast<std::size_t>(i)];
        const double fast = speed(static_cast<std::size_t>(i));
        found.direction[i] = fast > 0.0 ? rate_[first_ + i] / fast : 0.0;
        found.sliding[i] = at(laws_[k], fast);
        found.fixed[i] = fixed_[static_cast<std::size_t>(k)];
        found.still[i] = thresholds_.rest_acceleration * fastest * fastest * laws_[k].size;
        const auto at = std::find(stops.begin(), stops.end(), laws_[k].stop);
        found.stop.push_back(laws_[k].stop < 0 ? -1 : static_cast<int>(at - stops.begin()));
        found.partner.push_back(partner_of(k));
        found.up.push_back(Walls::push(touching_[k], 1.0));
        found.down.push_back(Walls::push(touching_[k], -1.0));
    }
    return found;
}

bool DryFriction::turn(double t, const Vector& y, const FrictionBalance& before, const Balanced& now,
                       ContactState& next) {
    Vector soon, later;
    const Vector slope = slope_;
    const bool known = slip_after(ahead, t, y, slope, before, now, next, soon) &&
                       slip_after(2.0 * ahead, t, y, slope, before, now, next, later);
    equations_.set_pose(t, y.data());
    equations_.set_velocities(y.data(), false);
    if (!equations_.factor(Metric::mass)) return false;
    if (!known) return true;
    const auto unit = [&](const Vector& slip, Eigen::Index k, Eigen::Index other) {
        return Eigen::Vector2d(slip[k], slip[other]).normalized().eval();
    };
    for (const int k : next.starting) {
        const Eigen::Index own = place(k), other = place(laws_[k].partner);
        if (laws_[k].partner < k || unit(soon, own, other).isZero() || unit(later, own, other).isZero()) continue;
        const Eigen::Vector2d rate = (unit(later, own, other) - unit(soon, own, other)) / ahead,
                              first = (unit(soon, own, other) - ahead * rate).normalized();
        for (auto& [number, way] : next.sliding)
            if (number == k || number == laws_[k].partner) way = first[number == k ? 0 : 1];
        if (rate.norm() * ahead > thresholds_.slips && !has(next.turned, k)) next.turned.push_back(k);
        next.turning.emplace_back(k, rate[0]), next.turning.emplace_back(laws_[k].partner, rate[1]);
    }
    return true;
}

bool DryFriction::slip_after(double h, double t, const Vector& y, const Vector& slope, FrictionBalance problem,
                             const Balanced& now, const ContactState& next, Vector& slip) {
    equations_.set_pose(t, y.data());
    equations_.set_velocities(y.data(), false);
    if (!equations_.factor(Metric::mass)) return false;
    border_->set_normals();
    if (!border_->respond(h * now.y)) return false;
    Vector later = y + h * slope;
    equations_.add_velocities(later);
    later_->hold(border_->rows());
    equations_.set_pose(t + h, later.data());
    equations_.set_velocities(later.data(), false);
    if (!equations_.factor(Metric::mass) || !later_->factor() || !accelerations(*later_, later, problem.b))
        return false;
    problem.B = later_->operator_of_rows();
    for (std::size_t i = 0; i < rubs_.size(); ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        const bool begins = has(next.starting, rubs_[i]);
        problem.direction[k] = begins ? 0.0 : now.direction[k];
        if (begins) problem.fixed[k] = problem.sliding[k];
    }
    const auto loads = [&](const Vector& along, Vector& carried) { loads_of(problem, along, carried); };
    return problem.slip(loads, thresholds_, slip);
}

bool DryFriction::accelerations(Border& border, const Vector& y, Vector& found) {
    slope_.resize(y.size());
    if (!equations_.own_slope_at(y.data(), slope_.data(), lambda_.data())) return false;
    border.accelerations(first_, found);
    base_.clear(), responses_.clear();
    const int bearings = equations_.bearing_count();
    for (int k = 0; k < bearings; ++k) base_.push_back(equations_.supports(k, lambda_.data()));
    for (Eigen::Index i = 0; i < found.size() && !base_.empty(); ++i) {
        const Vector reaction = border.reactions().col(i);
        responses_.emplace_back();
        for (int k = 0; k < bearings; ++k) responses_.back().push_back(equations_.supports(k, reaction.data()));
    }
    return true;
}

void DryFriction::loads_of(const FrictionBalance& problem, const Vector& forces, Vector& found) const {
    found.resize(static_cast<Eigen::Index>(rubs_.size()));
    for (std::size_t at = 0; at < rubs_.size(); ++at) {
        const int number = laws_[rubs_[at]].bearing, stop = problem.stop[at];
        double& own = found[static_cast<Eigen::Index>(at)];
        own = stop < 0 ? 1.0 : forces[stop];
        if (stop >= 0 || number < 0) continue;
        Supports carried = base_[number];
        for (Eigen::Index i = 0; i < forces.size(); ++i) carried.add(responses_[i][number], forces[i]);
        own = equations_.preload(number) + equations_.load(number, carried);
    }
}

std::vector<int> DryFriction::jams(const FrictionBalance& problem) const {
    const auto count = Eigen::Index{equations_.bearing_count()};
    if (count == 0) return {};
    Eigen::MatrixXd left = Eigen::MatrixXd::Identity(count, count);
    for (std::size_t at = 0; at < rubs_.size(); ++at)
        for (Eigen::Index j = 0; j < count && laws_[rubs_[at]].bearing >= 0; ++j)
            left(j, laws_[rubs_[at]].bearing) -= problem.sliding[static_cast<Eigen::Index>(at)] *
                                                 equations_.load(static_cast<int>(j), responses_[at][j]);
    const Vector x = solved(left, Vector::Ones(count));
    if (x.allFinite() && x.minCoeff() > 0.0) return {};
    Eigen::Index worst;
    left.diagonal().minCoeff(&worst);
    std::vector<int> found;
    for (const int k : rubs_)
        if (laws_[k].bearing == worst) found.push_back(k);
    return found;
}

std::vector<int> DryFriction::at_rest(const FrictionBalance& problem) const {
    std::vector<int> found;
    for (std::size_t i = 0; i < rubs_.size(); ++i)
        if (problem.rests(static_cast<Eigen::Index>(i))) found.push_back(rubs_[i]);
    return found.empty() ? rubs_ : found;
}

void DryFriction::take(const Balanced& found, const FrictionBalance& problem, const Vector& rate,
                       const Vector& acceleration, const std::vector<long>& turns, bool known,
                       ContactState& next) const {
    const Numbered before = known ? next.stuck : Numbered();
    next.sliding.clear(), next.stuck.clear(), next.bearing.clear();
    next.straight.clear(), next.starting.clear(), next.turning.clear();
    for (std::size_t i = 0; i < rubs_.size(); ++i) {
        const auto at = static_cast<Eigen::Index>(i);
        const int k = rubs_[i], other = partner_of(k);
        if (problem.stop[i] >= 0 && !(found.y[problem.stop[i]] > 0.0)) continue;
        const bool across = other >= 0 && found.direction[other] != 0.0;
        if (found.part[at] != 0.0) next.bearing.emplace_back(k, found.part[at]);
        if (found.stuck[i]) next.stuck.emplace_back(k, value_of(before, k, turns));
        if (found.direction[at] == 0.0 && !across) continue;
        next.sliding.emplace_back(k, found.direction[at]);
        const double slow = 2.0 * thresholds_.straight_speed * next.fastest * laws_[k].size;
        if (other < 0 || std::hypot(rate[at], rate[other]) > slow) continue;
        const bool stops = rate[at] * acceleration[at] + rate[other] * acceleration[other] < 0.0;
        (stops ? next.straight : next.starting).push_back(k);
    }
}

double DryFriction::value_of(const Numbered& before, int k, const std::vector<long>& turns) const {
    if (!touching_[k].empty()) return touching_[k].front().at;
    const int coordinate = model_.stops.joint_coordinate[stops_ + k];
    const bool turned = coordinate >= 0 && equations_.is_angle_at_stop(stops_ + k);
    return among(before, k,
                 equations_.at_stop(stops_ + k).value +
                     (turned ? 2.0 * M_PI * static_cast<double>(turns[coordinate]) : 0.0));
}

}  // namespace mbproj
