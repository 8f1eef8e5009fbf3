// The rigid stops that touch at a state, whose rows are independent: their impact, and how hard they push after. The reference is
// mbproj.integrate.stops.meeting.
#pragma once

#include "contacts/contact_state.hpp"
#include "contacts/whole_motion.hpp"
#include "laws/impact.hpp"

namespace mbproj {

template <class D> class TouchingStops final {
public:
    using Vector = Eigen::VectorXd;
    using Flags = std::vector<bool>;

    explicit TouchingStops(EquationsOfMotion<D>& equations)
        : equations_(equations), model_(equations.model()), thresholds_(model_.thresholds), border_(model_),
          slope_(model_.layout.size()) {}

    void begin(std::vector<StopLaw> laws, ImpactLaw impacts) { laws_ = std::move(laws), impacts_ = impacts; }
    std::vector<ContactRow> rows_of(const std::vector<int>& stops) const {
        std::vector<ContactRow> rows;
        for (const int k : stops) rows.push_back({k, laws_[k].side, model_.stops.bound[k]});
        return rows;
    }

    // At a state of which the pose is in place and factored, these touch. False where their rows depend on each other.
    bool touch(std::vector<int> stops) {
        stop_ = std::move(stops);
        border_.hold(rows_of(stop_));
        return border_.factor(equations_.pose(), equations_.solver()) && border_.cholesky().full();
    }
    const std::vector<int>& stops() const { return stop_; }
    // Whose restitution counts where these are struck: by impulses that of others, too, which have some.
    bool bounces(bool struck) const { return struck || impacts_ != ImpactLaw::newton; }
    // How fast the gaps open.
    void rates(Vector& found) const { border_.rates(equations_.motion(), found); }

    // Of how hard they push, as they were seen last.
    double round_off() const { return border_.round_off(); }

    // The impact of the stops that touch; where a bounce would be lower than any that counts, without restitution. `rate` is what
    // it is after.
    bool strike(double t, const Vector& y, const Flags& struck, const Vector& slow, Vector e, Vector& rate,
                Vector& y_after, ContactState& next, std::vector<ContactEvent>& events,
                std::vector<ContactEvent>& rests) {
        const Vector before = rate;
        const Eigen::Index count = before.size();
        Impact impact;
        Vector fall;
        const auto hit = [&] {
            if (!impact.strike(impacts_, border_.operator_of_rows(), before, e, slow, thresholds_.no_push))
                return false;
            rate = impact.after;
            return change(y, impact.impulse);
        };
        if (!hit() || !falls(rate, slow, fall)) return false;
        Flags low(struck.size());
        for (Eigen::Index i = 0; i < count; ++i) {
            low[i] = struck[i] && e[i] > 0.0 && e[i] < 1.0 && lifts_less(i, rate[i], fall[i]);
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
            rate = before + border_.operator_of_rows() * z;
            if (!change(y, z) || !falls(rate, slow, fall)) return false;
        }
        const double given = 0.5 * z.dot(border_.operator_of_rows() * z) + z.dot(before);
        if (-given < -thresholds_.creates_energy * kinetic_energy(model_, y)) return false;
        next.lost -= given;
        if (!model_.driven.empty()) next.work += kinetic_energy(model_, after_) - kinetic_energy(model_, y) - given;
        for (Eigen::Index i = 0; i < count; ++i)
            if (impact.impulse[i] > 0.0)
                events.push_back({t, stop_[i], struck[i] ? Happening::impact : Happening::push, -1, impact.impulse[i],
                                  impact.taken[i]});
        y_after = after_;
        return true;
    }

    // How hard stops push that stay closed, at y at the pose in place.
    bool pushes(const Vector& y, const Flags& staying, Vector& push) {
        push = Vector::Zero(static_cast<Eigen::Index>(stop_.size()));
        if (!accelerations(y, free_)) return false;
        Eigen::MatrixXd B;
        Vector b, z;
        const std::vector<Eigen::Index> which = only(staying, free_, B, b);
        if (!one_sided(B, b, thresholds_.no_push, z)) return false;
        for (std::size_t i = 0; i < which.size(); ++i) push[which[i]] = z[static_cast<Eigen::Index>(i)];
        return true;
    }
    // The same, and which gaps open then.
    bool pushes(const Vector& y, const Flags& staying, Vector& push, Flags& opens) {
        if (!pushes(y, staying, push)) return false;
        const Vector after = free_ + border_.operator_of_rows() * push;
        for (std::size_t i = 0; i < opens.size(); ++i) {
            const auto k = static_cast<Eigen::Index>(i);
            opens[i] = border_.opens(k, after[k]);
        }
        return true;
    }

private:
    // The state after impulses z.
    bool change(const Vector& y, const Vector& z) {
        if (!border_.respond(equations_.solver(), z)) return false;
        after_ = y;
        add_velocities(equations_, after_);
        return true;
    }

    // How the gaps accelerate after, where nothing pushes.
    bool accelerations(const Vector& y, Vector& found) {
        equations_.set_velocities(y.data(), false);
        if (!equations_.slope_at(y.data(), slope_.data())) return false;
        const auto count = static_cast<Eigen::Index>(stop_.size());
        border_.accelerations(equations_.pose(), equations_.solver(), equations_.motion(), count, found);
        return true;
    }

    // How gaps are accelerated shut where those that rest stay: a ball falls on another one that the floor holds.
    bool falls(const Vector& rate, const Vector& slow, Vector& fall) {
        Flags rest(stop_.size());
        for (std::size_t i = 0; i < rest.size(); ++i)
            rest[i] = std::abs(rate[static_cast<Eigen::Index>(i)]) <= slow[static_cast<Eigen::Index>(i)];
        Vector push;
        if (!pushes(after_, rest, push)) return false;
        fall = -(free_ + border_.operator_of_rows() * push);
        return true;
    }
    bool lifts_less(Eigen::Index i, double rate, double fall) const {
        const double reached = fall > 0.0 ? rate * rate / (2.0 * fall) : std::numeric_limits<double>::infinity();
        return rate > 0.0 && reached < thresholds_.lowest_bounce * laws_[stop_[i]].size;
    }

    // Whether some gap opens after an impact by less than any bounce that counts, and does not stay closed; now it does, and what
    // rests does. Where some are kept closed, others may fall shut that opened before.
    bool rocks(const Flags& low, const Vector& rate, const Vector& slow, const Vector& fall, Flags& staying) const {
        bool more = false;
        Flags next = staying;
        for (Eigen::Index i = 0; i < rate.size(); ++i) {
            const bool lifted = !low[i] && rate[i] > slow[i] && lifts_less(i, rate[i], fall[i]);
            more = more || (lifted && !staying[i]);
            next[i] = next[i] || lifted || std::abs(rate[i]) <= slow[i];
        }
        if (more) staying = next;
        return more;
    }

    // Impulses with which these stops stay closed: what rocks comes to rest.
    Vector without_lifting(const Flags& staying, const Vector& rate) {
        Eigen::MatrixXd B;
        Vector b, z, found = Vector::Zero(rate.size());
        const std::vector<Eigen::Index> which = only(staying, rate, B, b);
        SemidefiniteCholesky cholesky;
        cholesky.factor(B, thresholds_.no_push);
        cholesky.solve(b, z);
        for (std::size_t i = 0; i < which.size(); ++i) found[which[i]] = z[static_cast<Eigen::Index>(i)];
        return found;
    }
    std::vector<Eigen::Index> only(const Flags& chosen, const Vector& all, Eigen::MatrixXd& B, Vector& b) const {
        std::vector<Eigen::Index> which;
        for (std::size_t i = 0; i < chosen.size(); ++i)
            if (chosen[i]) which.push_back(static_cast<Eigen::Index>(i));
        B = border_.operator_of_rows()(which, which);
        b = all(which);
        return which;
    }

    EquationsOfMotion<D>& equations_;
    const Model<D>& model_;
    const Thresholds& thresholds_;
    ContactBorder<D> border_;
    std::vector<StopLaw> laws_;
    ImpactLaw impacts_ = ImpactLaw::newton;
    std::vector<int> stop_;  // that touch
    Vector after_, slope_, free_;
};

}  // namespace mbproj
