#include "contact/touching_stops.hpp"

namespace mbproj {

std::vector<ContactRow> TouchingStops::rows_of(const std::vector<int>& stops) const {
    std::vector<ContactRow> rows;
    for (const int k : stops) rows.push_back({k, laws_[k].side, model_.stops.bound[k]});
    return rows;
}

bool TouchingStops::touch(std::vector<int> stops) {
    stop_ = std::move(stops);
    std::vector<ContactRow> rows = rows_of(stop_);
    rubs_.clear(), rubbing_ = {};
    for (int k = 0; k < static_cast<int>(frictions_.size()); ++k)
        if (has(stop_, frictions_[k].stop)) rubs_.push_back(k);
    for (const int k : rubs_) {
        const FrictionLaw& law = frictions_[k];
        const auto at = [](const std::vector<int>& all, int each) {
            return each < 0 ? -1 : static_cast<int>(std::find(all.begin(), all.end(), each) - all.begin());
        };
        rows.push_back({static_cast<int>(laws_.size()) + k, 1.0, 0.0});
        rubbing_.coefficient.push_back(law.sliding);
        rubbing_.partner.push_back(at(rubs_, law.partner)), rubbing_.by.push_back(at(stop_, law.stop));
    }
    border_->hold(std::move(rows));
    if (!border_->factor()) return false;
    B_ = border_->operator_of_rows();
    moves_.clear();
    for (Eigen::Index k = 0; k < B_.rows(); ++k) {
        moves_.push_back(border_->moves(k));
        if (!moves_.back()) B_.row(k).setZero(), B_.col(k).setZero();
    }
    return true;
}

bool TouchingStops::strike(double t, const Vector& y, const Flags& struck, const Vector& slow, Vector e, Vector& rate,
                           Vector& y_after, ContactState& next, std::vector<ContactEvent>& events,
                           std::vector<ContactEvent>& rests) {
    const Vector before = rate;
    Impact impact;
    Vector fall;
    const auto hit = [&] {
        if (!has_answer(impact.strike(impacts_, B_, before, e, slow, rubbing_, moves_, thresholds_), before))
            return false;
        if (creates(y, before, impact.impulse)) return refuse_energy(before, e, slow, impact.impulse);
        rate = impact.after;
        return change(y, impact.impulse);
    };
    if (!hit() || !falls(rate, slow, fall)) return false;
    Flags low(struck.size());
    for (Eigen::Index i = 0; i < count(); ++i) {
        low[i] = struck[i] && e[i] > 0.0 && e[i] < 1.0 && lifts_less(i, rate[i], fall[i], thresholds_.lowest_bounce);
        if (!low[i]) continue;
        rests.push_back({t + 2.0 * rate[i] / (fall[i] * (1.0 - e[i])), stop_[i], Happening::rest, -1, 0.0, 0.0});
        e[i] = 0.0;
    }
    if (!rests.empty() && (!hit() || !falls(rate, slow, fall))) return false;
    const Vector hit_rate = rate;
    Vector z = impact.impulse;
    Flags staying(struck.size());
    while (rocks(low, rate, slow, fall, staying)) {
        z = impact.impulse + without_lifting(staying, hit_rate);
        rate = before + B_ * z;
        if (!change(y, z) || !falls(rate, slow, fall)) return false;
    }
    account(y, before, z, next);
    for (Eigen::Index i = 0; i < count(); ++i)
        if (impact.impulse[i] > 0.0)
            events.push_back(
                {t, stop_[i], struck[i] ? Happening::impact : Happening::push, -1, impact.impulse[i], impact.taken[i]});
    next.rubbed.resize(frictions_.size(), 0.0);
    for (std::size_t k = 0; k < rubs_.size(); ++k)
        next.rubbed[rubs_[k]] += impact.taken[count() + static_cast<Eigen::Index>(k)];
    y_after = after_;
    return true;
}

bool TouchingStops::keep_down(Vector& y, const Vector& slow, Vector& rate, ContactState& next) {
    Flags lifts(stop_.size());
    bool any = false;
    for (Eigen::Index i = 0; i < count(); ++i) any = any || rate[i] > slow[i];
    Vector fall;
    after_ = y;
    if (!any) return true;
    if (!falls(rate, slow, fall)) return false;
    any = false;
    for (Eigen::Index i = 0; i < count(); ++i) {
        lifts[i] = rate[i] > slow[i] && lifts_less(i, rate[i], fall[i], thresholds_.stop_slack);
        any = any || lifts[i];
    }
    if (!any) return true;
    const Vector before = rate, z = without_lifting(lifts, rate);
    rate = before + B_ * z;
    if (!change(y, z)) return false;
    account(y, before, z, next);
    y = after_;
    return true;
}

bool TouchingStops::pushes(const Vector& y, const Flags& staying, Vector& push, Flags& opens) {
    if (!accelerations(y, free_)) return false;
    if (!hold(staying, push)) return undecided_.is_for(Cause::driven_into, of(staying));
    const Vector after = free_ + B_of_stops() * push;
    for (std::size_t i = 0; i < opens.size(); ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        opens[i] = border_->opens(k, after[k]);
    }
    return true;
}

std::vector<int> TouchingStops::of(const Flags& chosen) const {
    std::vector<int> found;
    for (std::size_t i = 0; i < stop_.size(); ++i)
        if (chosen[i]) found.push_back(stop_[i]);
    return found;
}

bool TouchingStops::has_answer(Strike found, const Vector& before) {
    if (found == Strike::done) return true;
    Flags closing(stop_.size());
    for (Eigen::Index i = 0; i < count(); ++i) closing[static_cast<std::size_t>(i)] = before[i] < 0.0;
    return undecided_.is_for(Cause::driven_into, of(closing));
}

bool TouchingStops::refuse_energy(const Vector& before, const Vector& e, const Vector& slow, const Vector& z) {
    Flags pushing(stop_.size());
    for (Eigen::Index i = 0; i < count(); ++i) pushing[static_cast<std::size_t>(i)] = z[i] > 0.0;
    undecided_.energy = given(before, z);
    for (const ImpactLaw law : impact_laws) {
        Impact other;
        if (other.strike(law, B_, before, e, slow, rubbing_, moves_, thresholds_) == Strike::done &&
            given(before, other.impulse) <= 0.0)
            undecided_.laws.push_back(static_cast<int>(law));
    }
    return undecided_.is_for(Cause::creates_energy, of(pushing));
}

void TouchingStops::account(const Vector& y, const Vector& before, const Vector& z, ContactState& next) const {
    next.lost -= given(before, z);
    if (!model_.driven_count() == 0)
        next.work += equations_.kinetic_energy(after_) - equations_.kinetic_energy(y) - given(before, z);
}

bool TouchingStops::hold(const Flags& staying, Vector& push) const {
    push = Vector::Zero(count());
    Eigen::MatrixXd B;
    Vector b, z;
    const std::vector<Eigen::Index> which = only(staying, free_, B, b);
    if (!one_sided(B, b, thresholds_.no_push, z)) return false;
    share(B, b, z);
    push(which) = z;
    return true;
}

void TouchingStops::share(const Eigen::MatrixXd& B, const Vector& b, Vector& z) const {
    const Vector left = b + B * z;
    std::vector<Eigen::Index> stay;
    for (Eigen::Index k = 0; k < b.size(); ++k)
        if (B(k, k) > 0.0 && std::abs(left[k]) <= thresholds_.no_push * b.cwiseAbs().maxCoeff()) stay.push_back(k);
    if (independent(B, stay, thresholds_.no_push).size() == stay.size()) return;
    std::vector<Cone> cones;
    for (int k = 0; k < static_cast<int>(stay.size()); ++k) cones.push_back({k, {}, 0.0, {}});
    if (Vector y; contact_problem(B(stay, stay), b(stay), cones, thresholds_, y)) z(stay) = y;
}

bool TouchingStops::change(const Vector& y, const Vector& z) {
    if (!border_->respond(z)) return false;
    after_ = y;
    equations_.add_velocities(after_);
    return true;
}

bool TouchingStops::accelerations(const Vector& y, Vector& found) {
    equations_.set_velocities(y.data(), false);
    if (!equations_.own_slope_at(y.data(), slope_.data())) return false;
    border_->accelerations(count(), found);
    found.conservativeResize(count());
    return true;
}

bool TouchingStops::falls(const Vector& rate, const Vector& slow, Vector& fall) {
    Flags rest(stop_.size());
    for (std::size_t i = 0; i < rest.size(); ++i)
        rest[i] = std::abs(rate[static_cast<Eigen::Index>(i)]) <= slow[static_cast<Eigen::Index>(i)];
    Vector push;
    if (!accelerations(after_, free_)) return false;
    if (!hold(rest, push)) push.setZero();
    fall = -(free_ + B_of_stops() * push);
    return true;
}

bool TouchingStops::lifts_less(Eigen::Index i, double rate, double fall, double height) const {
    const double reached = fall > 0.0 ? rate * rate / (2.0 * fall) : std::numeric_limits<double>::infinity();
    return rate > 0.0 && reached < height * laws_[stop_[i]].size;
}

bool TouchingStops::rocks(const Flags& low, const Vector& rate, const Vector& slow, const Vector& fall,
                          Flags& staying) const {
    bool more = false;
    Flags next = staying;
    for (Eigen::Index i = 0; i < count(); ++i) {
        const bool lifted = !low[i] && rate[i] > slow[i] && lifts_less(i, rate[i], fall[i], thresholds_.lowest_bounce);
        more = more || (lifted && !staying[i]);
        next[i] = next[i] || lifted || std::abs(rate[i]) <= slow[i];
    }
    if (more) staying = next;
    return more;
}

TouchingStops::Vector TouchingStops::without_lifting(const Flags& staying, const Vector& rate) {
    Eigen::MatrixXd B;
    Vector b, z, found = Vector::Zero(rate.size());
    const std::vector<Eigen::Index> which = only(staying, rate, B, b);
    SemidefiniteCholesky cholesky;
    cholesky.factor(B, thresholds_.no_push);
    cholesky.solve(b, z);
    for (std::size_t i = 0; i < which.size(); ++i) found[which[i]] = z[static_cast<Eigen::Index>(i)];
    return found;
}

std::vector<Eigen::Index> TouchingStops::only(const Flags& chosen, const Vector& all, Eigen::MatrixXd& B,
                                              Vector& b) const {
    std::vector<Eigen::Index> which;
    for (std::size_t i = 0; i < chosen.size(); ++i)
        if (chosen[i]) which.push_back(static_cast<Eigen::Index>(i));
    B = B_(which, which);
    b = all(which);
    return which;
}

}  // namespace mbproj
