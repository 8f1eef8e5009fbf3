// Which contacts hold, and what happens where one is met: Newton's impact, contacts that begin and end, bounces that come to rest.
// For rigid stops without friction whose rows are independent, and dry friction at joints; the reference is mbproj.integrate.stops.meeting.
#pragma once

#include "contacts/joint_friction.hpp"
#include "contacts/one_sided.hpp"

namespace mbproj {

template <int D> class ContactPolicy final {
public:
    using Vector = Eigen::VectorXd;

    explicit ContactPolicy(EquationsOfMotion<D>& equations)
        : equations_(equations), model_(equations.model()), thresholds_(model_.thresholds), border_(model_),
          friction_(equations), slope_(model_.layout.size()) {}

    void begin(std::vector<StopLaw> laws, std::vector<FrictionLaw> frictions, ContactState state) {
        laws_ = std::move(laws);
        std::vector<double> sides;
        for (const StopLaw& law : laws_) sides.push_back(law.side);
        friction_.begin(std::move(frictions), std::move(sides));
        resume(std::move(state));
    }
    void resume(ContactState state) {
        state_ = std::move(state);
        friction_.hold(state_, rows_of(state_.held));
    }
    bool any() const { return !laws_.empty() || friction_.any(); }
    const ContactState& state() const { return state_; }
    std::size_t stops() const { return laws_.size(); }
    std::vector<ContactEvent> take_events() { return std::exchange(events_, {}); }
    // The force along each coordinate of stops and frictions, of the last multipliers.
    std::vector<double> forces(const std::vector<double>& lambda) const {
        std::vector<double> found(lambda.begin() + model_.all_rows(), lambda.end());
        friction_.walls().share(state_, lambda, found);
        return found;
    }

    // What ends the contacts as they are.
    void watch(StopWatch<D>& watch, double spacing) const {
        std::vector<WatchedGap> gaps;
        std::vector<WatchedRow> rows;
        const double slack = std::max(thresholds_.contact_pulls * state_.push, std::numeric_limits<double>::min());
        for (int k = 0; k < static_cast<int>(laws_.size()); ++k)
            if (!holds(k))
                gaps.push_back({k, laws_[k].side, laws_[k].slack, false, -1, 0.0});
            else if (!friction_.walls().has(state_, k))
                rows.push_back({model_.all_rows() + k, 1.0, slack, 0.0, 0.0, -1, -1});
        friction_.watch(state_, gaps, rows);
        watch.watch(std::move(gaps), std::move(rows), spacing);
    }
    // How fast the fastest part moves at a state, in lengths of the mechanism and rad per s.
    void see_speed(const Vector& y) { state_.fastest = std::max(state_.fastest, speed(y)); }

    // At y at t, with whole turns, this stop is met, or `released`, or a friction comes to rest, or is `released`: y is what it is after. False where that is not for this
    // policy: nothing has changed then. `interval` lies between two samples.
    bool meet(double t, Vector& y, const std::vector<long>& turns, int stop, bool released, double interval) {
        ContactState next = state_;
        std::vector<ContactEvent> events;
        const bool done = touches(t, y, turns) && settle(t, y, turns, stop, released, interval, next, events);
        if (done) {
            next.events += static_cast<long>(events.size());
            events_.insert(events_.end(), events.begin(), events.end());
            y = after_;
            state_ = std::move(next);
        }
        friction_.hold(state_, rows_of(state_.held));
        return done;
    }

private:
    using Flags = std::vector<bool>;

    bool holds(int stop) const { return std::find(state_.held.begin(), state_.held.end(), stop) != state_.held.end(); }
    std::vector<ContactRow> rows_of(const std::vector<int>& stops) const {
        std::vector<ContactRow> rows;
        for (const int k : stops) rows.push_back({k, laws_[k].side, model_.stops.bound[k]});
        return rows;
    }

    double speed(const Vector& y) const { return fastest_part(model_, y); }
    double kinetic(const Vector& y) const { return kinetic_energy(model_, y); }

    // The stops that touch at a state and their border, without contacts. False where their rows depend on each other.
    bool touches(double t, const Vector& y, const std::vector<long>& turns) {
        friction_.release();
        equations_.set_pose(t, y.data());
        equations_.set_velocities(y.data(), false);
        if (!equations_.factor(Metric::mass)) return false;
        const Stops<D>& stops = model_.stops;
        stop_.clear();
        for (int k = 0; k < static_cast<int>(laws_.size()); ++k) {
            const int coordinate = stops.joint_coordinate[k];
            const double whole = coordinate < 0 ? 0.0 : 2.0 * M_PI * static_cast<double>(turns[coordinate]);
            const double value = Coordinate<D>(stops.coordinates, k, equations_.pose()).value() + whole;
            const double gap = laws_[k].side * (value - stops.bound[k]);
            if (holds(k) || gap <= thresholds_.touching * laws_[k].size) stop_.push_back(k);
        }
        border_.hold(rows_of(stop_));
        return border_.factor(equations_.pose(), equations_.solver()) && border_.cholesky().full();
    }

    bool settle(double t, const Vector& y, const std::vector<long>& turns, int stop, bool released, double interval,
                ContactState& next, std::vector<ContactEvent>& events) {
        const double near = 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t), interval);
        next.met_often = t - next.met_at <= near ? next.met_often + 1 : 1;
        next.met_at = t;
        if (next.met_often > thresholds_.most_meetings) return false;
        const auto count = static_cast<Eigen::Index>(stop_.size());
        const double own = speed(y);
        Flags struck(stop_.size());
        Vector slow(count), e = Vector::Zero(count), rate;
        border_.rates(equations_.motion(), rate);
        for (Eigen::Index i = 0; i < count; ++i) {
            const StopLaw& law = laws_[stop_[i]];
            slow[i] = thresholds_.stop_rests * law.size * (holds(stop_[i]) ? std::max(own, next.fastest) : own);
            struck[i] = rate[i] < -slow[i] && !holds(stop_[i]);
            if (struck[i]) e[i] = law.restitution;
        }
        after_ = y;
        std::vector<ContactEvent> rests;
        if (std::find(struck.begin(), struck.end(), true) != struck.end() &&
            !strike(t, y, struck, slow, e, rate, next, events, rests))
            return false;
        Flags staying(stop_.size());
        for (Eigen::Index i = 0; i < count; ++i)
            staying[i] = std::abs(rate[i]) <= slow[i] && !(released && stop_[i] == stop);
        Vector push = Vector::Zero(count);
        const bool closed = std::find(staying.begin(), staying.end(), true) != staying.end();
        if (friction_.any() ? !rub(t, turns, staying, released ? -1 : stop, struck, next, push)
                            : closed && !pushes(staying, push))
            return false;
        next.held.clear();
        next.push = count ? push.maxCoeff() : 0.0;
        for (Eigen::Index i = 0; i < count; ++i) {
            const bool again = next.met_often > 1 && !released && stop_[i] == stop && staying[i];
            const bool wall = staying[i] && friction_.walls().has(next, stop_[i]);
            if (push[i] > 0.0 || again || wall) next.held.push_back(stop_[i]);
        }
        record(t, next.held, rests, events);
        friction_.record(t, state_, next, events);
        return true;
    }

    // What frictions do from here on, while these stops stay closed, and how hard those push.
    bool rub(double t, const std::vector<long>& turns, const Flags& staying, int met, const Flags& struck,
             ContactState& next, Vector& push) {
        std::vector<int> closed;
        std::vector<Eigen::Index> which;
        for (std::size_t i = 0; i < staying.size(); ++i)
            if (staying[i]) closed.push_back(stop_[i]), which.push_back(static_cast<Eigen::Index>(i));
        const bool known = std::find(struck.begin(), struck.end(), true) == struck.end();
        const int rest = std::max(met - static_cast<int>(laws_.size()), -1);
        Vector pushes;
        if (!friction_.settle(t, after_, turns, rows_of(closed), rest, known, next, pushes)) return false;
        push(which) = pushes;
        return true;
    }

    void record(double t, const std::vector<int>& held, const std::vector<ContactEvent>& rests,
                std::vector<ContactEvent>& events) const {
        const auto among = [](const std::vector<int>& all, int k) {
            return std::find(all.begin(), all.end(), k) != all.end();
        };
        events.insert(events.end(), rests.begin(), rests.end());
        for (const int k : held)
            if (!holds(k) && std::none_of(rests.begin(), rests.end(), [k](const auto& each) { return each.stop == k; }))
                events.push_back({t, k, Happening::contact, -1, 0.0, 0.0});
        for (const int k : state_.held)
            if (!among(held, k)) events.push_back({t, k, Happening::release, 1, 0.0, 0.0});
    }

    // The impact of the stops that touch; where a bounce would be lower than any that counts, without restitution. `rate` is what
    // it is after.
    bool strike(double t, const Vector& y, const Flags& struck, const Vector& slow, Vector e, Vector& rate,
                ContactState& next, std::vector<ContactEvent>& events, std::vector<ContactEvent>& rests) {
        const Vector before = rate;
        const Eigen::Index count = before.size();
        Vector z, fall;
        const auto hit = [&] {
            Vector b = before;
            for (Eigen::Index i = 0; i < count; ++i)
                if (before[i] < 0.0) b[i] *= 1.0 + e[i];
            if (!one_sided(border_.operator_of_rows(), b, thresholds_.no_push, z)) return false;
            rate = before + border_.operator_of_rows() * z;
            return change(y, z);
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
        const Vector impulse = z;
        Flags staying(struck.size());
        bool lifts = false;
        for (Eigen::Index i = 0; i < count; ++i) {
            const bool lifted = !low[i] && rate[i] > slow[i] && lifts_less(i, rate[i], fall[i]);
            lifts = lifts || lifted;
            staying[i] = lifted || std::abs(rate[i]) <= slow[i];
        }
        if (lifts) {
            z += without_lifting(staying, rate);
            rate = before + border_.operator_of_rows() * z;
            if (!change(y, z)) return false;
        }
        const double given = 0.5 * z.dot(border_.operator_of_rows() * z) + z.dot(before);
        if (-given < -thresholds_.creates_energy * kinetic(y)) return false;
        next.lost -= given;
        if (!model_.driven.empty()) next.work += kinetic(after_) - kinetic(y) - given;
        for (Eigen::Index i = 0; i < count; ++i)
            if (impulse[i] > 0.0)
                events.push_back({t, stop_[i], struck[i] ? Happening::impact : Happening::push, -1, impulse[i],
                                  -0.5 * impulse[i] * (before[i] + rate[i])});
        return true;
    }

    // The state after impulses z.
    bool change(const Vector& y, const Vector& z) {
        if (!border_.respond(equations_.solver(), z)) return false;
        after_ = y;
        add_velocities(equations_, after_);
        return true;
    }

    // How the gaps accelerate after, where nothing pushes.
    bool accelerations(Vector& found) {
        equations_.set_velocities(after_.data(), false);
        if (!equations_.slope_at(after_.data(), slope_.data())) return false;
        Vector bend;
        border_.changes(equations_.solver(), found);
        border_.bends(equations_.motion(), bend);
        found += bend;
        return true;
    }

    // How gaps are accelerated shut where those that rest stay: a ball falls on another one that the floor holds.
    bool falls(const Vector& rate, const Vector& slow, Vector& fall) {
        Flags rest(stop_.size());
        for (std::size_t i = 0; i < rest.size(); ++i)
            rest[i] = std::abs(rate[static_cast<Eigen::Index>(i)]) <= slow[static_cast<Eigen::Index>(i)];
        Vector push;
        if (!pushes(rest, push)) return false;
        fall = -(free_ + border_.operator_of_rows() * push);
        return true;
    }
    bool lifts_less(Eigen::Index i, double rate, double fall) const {
        const double reached = fall > 0.0 ? rate * rate / (2.0 * fall) : std::numeric_limits<double>::infinity();
        return rate > 0.0 && reached < thresholds_.lowest_bounce * laws_[stop_[i]].size;
    }

    // How hard stops push that stay closed after.
    bool pushes(const Flags& staying, Vector& push) {
        push = Vector::Zero(static_cast<Eigen::Index>(stop_.size()));
        if (!accelerations(free_)) return false;
        Eigen::MatrixXd B;
        Vector b, z;
        const std::vector<Eigen::Index> which = only(staying, free_, B, b);
        if (!one_sided(B, b, thresholds_.no_push, z)) return false;
        for (std::size_t i = 0; i < which.size(); ++i) push[which[i]] = z[static_cast<Eigen::Index>(i)];
        return true;
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
    JointFriction<D> friction_;
    std::vector<StopLaw> laws_;
    ContactState state_;
    std::vector<ContactEvent> events_;
    std::vector<int> stop_;  // that touch
    Vector after_, slope_, free_;
};

}  // namespace mbproj
