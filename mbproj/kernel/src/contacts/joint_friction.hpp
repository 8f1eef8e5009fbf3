// Dry friction at joints: which sticks and which slides, and what ends that. One that sticks holds a row of the border, one that
// slides is a law, of which the part 1 or -1 counts. What sticks at a stop along its own coordinate, a wall, is held by both: their
// one row may push away from the wall as hard as it has to. The reference is mbproj.integrate.stops.rubbing.
#pragma once

#include "contacts/acting_frictions.hpp"
#include "contacts/whole_motion.hpp"
#include "laws/friction_balance.hpp"

namespace mbproj {

template <class D> class JointFriction final {
public:
    using Vector = Eigen::VectorXd;

    explicit JointFriction(EquationsOfMotion<D>& equations)
        : acting(equations), equations_(equations), model_(equations.model()), thresholds_(model_.thresholds),
          border_(model_), lambda_(model_.all_multipliers()) {}

    // The frictions come after the stops, which have these sides.
    void begin(std::vector<FrictionLaw> laws, std::vector<double> sides) {
        laws_ = laws;
        stops_ = static_cast<int>(sides.size());
        acting.begin(std::move(laws), std::move(sides));
    }
    bool any() const { return !laws_.empty(); }
    bool fits(const ContactState& state) const {
        const auto is_one = [this](const auto& each) { return each.first < static_cast<int>(laws_.size()); };
        const auto are_some = [&](const auto& all) { return std::all_of(all.begin(), all.end(), is_one); };
        return are_some(state.sliding) && are_some(state.stuck) && are_some(state.bearing);
    }
    const Walls<D>& walls() const { return acting.walls(); }
    ActingFrictions<D> acting;

    // At y at t, with whole turns, while these stops touch and stay: what frictions do from here on, how hard the stops push,
    // and which of them may open: walls are left out. `met` has come to rest, or none, -1; after an impact no friction is `known`
    // to stick. y is without what moves of frictions at rest. False where that is not for this class.
    bool settle(double t, Vector& y, const std::vector<long>& turns, std::vector<ContactRow> stops, int met, bool known,
                ContactState& next, Vector& push, std::vector<bool>& opens) {
        const std::vector<ContactRow> closed = stops;
        touching_ = walls().take_from(stops);
        const auto first = static_cast<Eigen::Index>(stops.size()), count = static_cast<Eigen::Index>(laws_.size());
        for (Eigen::Index k = 0; k < count; ++k) stops.push_back({stops_ + static_cast<int>(k), 1.0, 0.0});
        border_.hold(std::move(stops));
        equations_.set_pose(t, y.data());
        equations_.set_velocities(y.data(), false);
        if (!equations_.factor(Metric::mass) || !border_.factor(equations_.pose(), equations_.solver())) return false;
        equations_.seen(t, y.data());
        fixed_ = acting.bounds();
        Vector rate, rests;
        border_.rates(equations_.motion(), rate);
        rest(rate.tail(count), met, known, next, rests);
        if (!are_independent(first, rests) || !stop_all(y, first, next.fastest, rate)) return false;
        FrictionBalance balance{
            first, border_.operator_of_rows(), {}, Vector(count), Vector(count), Vector(count), Vector(count), {}, {},
            {}};
        for (Eigen::Index i = 0; i < first + count; ++i) balance.able.push_back(border_.moves(i));
        for (Eigen::Index k = 0; k < count; ++k) {
            const double speed = rests[k] != 0.0 ? 0.0 : rate[first + k];
            balance.direction[k] = speed > 0.0 ? 1.0 : speed < 0.0 ? -1.0 : 0.0;
            balance.sliding[k] = at(laws_[k], speed);
            balance.fixed[k] = fixed_[static_cast<std::size_t>(k)];
            balance.still[k] = thresholds_.rest_acceleration * next.fastest * next.fastest * laws_[k].size;
            balance.up.push_back(Walls<D>::push(touching_[k], 1.0));
            balance.down.push_back(Walls<D>::push(touching_[k], -1.0));
        }
        if (!accelerations(y, first, balance.b) || (first == 0 && rests.isZero(0.0) && !is_bounded(balance)))
            return false;
        Vector forces;
        std::vector<bool> stuck;
        const auto loads = [this](const Vector& along, Vector& found) { see_loads(along, found); };
        if (!balance.decide(loads, thresholds_, forces, stuck)) return false;
        Vector load;
        loads(forces, load);
        const Vector after = balance.b + balance.B * forces;
        push.resize(static_cast<Eigen::Index>(closed.size()));
        opens.assign(closed.size(), true);
        Eigen::Index own = 0;
        for (std::size_t i = 0; i < closed.size(); ++i) {
            const int k = walls().along(closed[i].coordinate);
            if (k < 0) opens[i] = border_.opens(own, after[own]);
            const double force = k < 0 ? forces[own++] : closed[i].sign * forces[first + k];
            push[static_cast<Eigen::Index>(i)] =
                k < 0 ? force : Walls<D>::push_of(force, fixed_[static_cast<std::size_t>(k)] * load[k]);
        }
        take(balance.direction, stuck, turns, known, next);
        return true;
    }

    // Of how hard stops push, as they were seen last.
    double round_off() const { return border_.round_off(); }

    // What begins to stick or to slide, or turns.
    void record(double t, const ContactState& before, const ContactState& after,
                std::vector<ContactEvent>& events) const {
        for (int k = 0; k < static_cast<int>(laws_.size()); ++k) {
            const double was = among(before.sliding, k, 0.0), now = among(after.sliding, k, 0.0);
            if ((was == 0.0) != (now == 0.0))
                events.push_back(
                    {t, stops_ + k, now != 0.0 ? Happening::slip : Happening::stick, static_cast<int>(now), 0.0, 0.0});
            else if (was * now < 0.0)
                events.push_back({t, stops_ + k, Happening::turn, static_cast<int>(now), 0.0, 0.0});
        }
        walls().record(t, before, after, events);
    }

private:
    using Limits = std::numeric_limits<double>;

    // How hard it resists sliding at a speed, at the state that was seen last: as the law does that slides forwards.
    double at(const FrictionLaw& law, double speed) const {
        return law.bound < 0 ? law.at(speed) : -given(equations_, model_.loads->laws[law.law].program, std::abs(speed));
    }
    // Which do not slide: those that are known to stick, those that are no faster than round-off or than what was met at rest.
    void rest(const Vector& rate, int met, bool known, const ContactState& state, Vector& rests) const {
        rests = Vector::Zero(rate.size());
        double slow = thresholds_.stop_rests * state.fastest;
        if (met >= 0) slow = std::max(slow, 8.0 * std::abs(rate[met]) / laws_[met].size);
        for (Eigen::Index k = 0; k < rate.size(); ++k) rests[k] = std::abs(rate[k]) <= slow * laws_[k].size ? 1.0 : 0.0;
        for (const auto& [k, at] : state.stuck)
            if (known) rests[k] = 1.0;
        for (std::size_t k = 0; k < touching_.size(); ++k)
            if (!touching_[k].empty()) rests[static_cast<Eigen::Index>(k)] = 1.0;
    }

    // Whether rows of the stops and of frictions at rest along which something moves do not depend on each other.
    bool are_independent(Eigen::Index first, const Vector& rests) {
        which_.clear();
        const Eigen::MatrixXd& B = border_.operator_of_rows();
        for (Eigen::Index i = 0; i < B.rows(); ++i)
            if (i < first || (rests[i - first] != 0.0 && border_.moves(i))) which_.push_back(i);
        cholesky_.factor(B(which_, which_), thresholds_.no_push);
        return cholesky_.full();
    }

    // What rests does not move at all: methods that do not close velocities leave more than round-off.
    bool stop_all(Vector& y, Eigen::Index first, double fastest, Vector& rate) {
        Vector wanted = Vector::Zero(static_cast<Eigen::Index>(which_.size())), own, z = Vector::Zero(rate.size());
        bool moves = false;
        for (std::size_t i = 0; i < which_.size(); ++i) {
            if (which_[i] < first) continue;
            wanted[static_cast<Eigen::Index>(i)] = rate[which_[i]];
            const double slow = thresholds_.stop_rests * fastest * laws_[which_[i] - first].size;
            moves = moves || std::abs(rate[which_[i]]) > slow;
        }
        if (!moves) return true;
        cholesky_.solve(wanted, own);
        for (std::size_t i = 0; i < which_.size(); ++i) z[which_[i]] = own[static_cast<Eigen::Index>(i)];
        if (!border_.respond(equations_.solver(), z)) return false;
        add_velocities(equations_, y);
        equations_.set_velocities(y.data(), false);
        border_.rates(equations_.motion(), rate);
        return true;
    }

    // Of the rows, `first` those of stops, where neither stops nor frictions act; and what bearings carry then.
    bool accelerations(const Vector& y, Eigen::Index first, Vector& found) {
        slope_.resize(y.size());
        if (!equations_.slope_at(y.data(), slope_.data(), lambda_.data())) return false;
        border_.accelerations(equations_.pose(), equations_.solver(), equations_.motion(), first, found);
        base_.clear(), responses_.clear();
        for (const Bearing<D>& bearing : model_.bearings)
            base_.emplace_back(model_, equations_.pose(), bearing, lambda_.data());
        for (Eigen::Index i = 0; i < found.size() && !base_.empty(); ++i) {
            const Vector reaction = border_.reactions().col(i);
            responses_.emplace_back();
            for (const Bearing<D>& bearing : model_.bearings)
                responses_.back().emplace_back(model_, equations_.pose(), bearing, reaction.data());
        }
        return true;
    }

    void see_loads(const Vector& forces, Vector& found) const {
        found.resize(static_cast<Eigen::Index>(laws_.size()));
        for (std::size_t k = 0; k < laws_.size(); ++k) {
            const int number = laws_[k].bearing;
            double& own = found[static_cast<Eigen::Index>(k)];
            own = 1.0;
            if (number < 0) continue;
            Supports<D> at = base_[number];
            for (Eigen::Index i = 0; i < forces.size(); ++i) at.add(responses_[i][number], forces[i]);
            own = model_.bearings[number].preload + at.load(model_.bearings[number]);
        }
    }

    // Whether no load grows by more than itself where all slide.
    bool is_bounded(const FrictionBalance& balance) const {
        const auto count = static_cast<Eigen::Index>(model_.bearings.size());
        if (count == 0) return true;
        Eigen::MatrixXd left = Eigen::MatrixXd::Identity(count, count);
        for (std::size_t k = 0; k < laws_.size(); ++k)
            for (Eigen::Index j = 0; j < count && laws_[k].bearing >= 0; ++j)
                left(j, laws_[k].bearing) -=
                    balance.sliding[static_cast<Eigen::Index>(k)] * responses_[k][j].load(model_.bearings[j]);
        const Vector x = solved(left, Vector::Ones(count));
        return x.allFinite() && x.minCoeff() > 0.0;
    }

    void take(const Vector& direction, const std::vector<bool>& stuck, const std::vector<long>& turns, bool known,
              ContactState& next) const {
        const Numbered before = known ? next.stuck : Numbered();
        next.sliding.clear(), next.stuck.clear();
        for (int k = 0; k < static_cast<int>(laws_.size()); ++k) {
            if (direction[k] != 0.0) next.sliding.emplace_back(k, direction[k]);
            if (!stuck[k]) continue;
            const int coordinate = model_.stops.joint_coordinate[stops_ + k];
            const Coordinate<D> along(model_.stops.coordinates, stops_ + k, equations_.pose());
            const bool turned = coordinate >= 0 && is_angle(along.p.kind);
            const double whole = turned ? 2.0 * M_PI * static_cast<double>(turns[coordinate]) : 0.0;
            next.stuck.emplace_back(k, touching_[k].empty() ? among(before, k, along.value() + whole)
                                                            : touching_[k].front().at);
        }
    }

    EquationsOfMotion<D>& equations_;
    const Model<D>& model_;
    const Thresholds& thresholds_;
    ContactBorder<D> border_;  // of stops that touch, and of all frictions
    std::vector<FrictionLaw> laws_;
    std::vector<double> fixed_;                      // the static force of each, where they were settled last
    std::vector<std::vector<ContactRow>> touching_;  // walls of each friction
    int stops_ = 0;
    std::vector<double> lambda_;
    Vector slope_;
    std::vector<Eigen::Index> which_;  // of the border that are at rest
    SemidefiniteCholesky cholesky_;    // of these
    std::vector<Supports<D>> base_;
    std::vector<std::vector<Supports<D>>> responses_;  // to a force of size 1 along each row
};

}  // namespace mbproj
