// Decides at a meeting which dry frictions at joints and at stops stick and which slide from there on, with the stops
// that touch. A friction that sticks at a wall, a stop along its own coordinate, shares one row with it: the row may
// push away from the wall without a bound.
#pragma once

#include "contact/acting_frictions.hpp"
#include "contact/friction_balance.hpp"

namespace mbproj {

class DryFriction final {
public:
    using Vector = Eigen::VectorXd;
    using Flags = std::vector<bool>;

    DryFriction(Equations& equations, Undecided& undecided);

    // Frictions are numbered after the stops, whose sides these are.
    void begin(std::vector<FrictionLaw> laws, std::vector<double> sides);
    bool any() const { return !laws_.empty(); }
    bool fits(const ContactState& state) const;
    const Walls& walls() const { return acting.walls(); }
    ActingFrictions acting;
    double ahead = 0.0;  // how long after a slip has begun its direction is looked at, s

    // Decides what frictions do from y at t on, with whole turns, while these stops touch and stay closed. Sets the
    // pushes of the stops, how they share a load, and which of them may open. `met`: the friction that has come to
    // rest, or -1; after an impact no friction is `known` to stick; `gave_way`: frictions have done so often at this time. Frictions at rest lose the rest of their velocity
    // in y. With `own_walls`, walls have rows of their own. False where nothing can be decided.
    bool settle(double t, Vector& y, const std::vector<long>& turns, const std::vector<ContactRow>& closed, int met,
                bool known, bool gave_way, ContactState& next, Vector& push, Flags& opens, bool own_walls = false);

    // The round-off of the stops' last pushes.
    double round_off() const { return border_->round_off(); }

    // Records frictions that begin to stick or slide, or reverse; at stops that touch, the first of two tangents.
    void record(double t, const ContactState& before, const ContactState& after,
                std::vector<ContactEvent>& events) const;

private:
    using Limits = std::numeric_limits<double>;

    // The sliding force at a speed at the last state, as the law has it for sliding forwards.
    double at(const FrictionLaw& law, double speed) const {
        return law.bound < 0 ? law.at(speed) : -equations_.given(equations_.program_of(law.law), std::abs(speed));
    }
    // The place of a friction in `rubs_`.
    Eigen::Index place(int k) const { return std::find(rubs_.begin(), rubs_.end(), k) - rubs_.begin(); }
    int partner_of(int k) const { return laws_[k].partner < 0 ? -1 : static_cast<int>(place(laws_[k].partner)); }
    // The speed along a friction of `rubs_`; for two tangents, that in their plane.
    double speed(std::size_t i) const;

    // The frictions at rest: known to stick, at walls, or no faster than round-off, or than `met`, which is at rest. Other rows keep
    // those without a row at rest, if they do.
    Flags rest(int met, bool known, const ContactState& state) const;
    bool faster(std::size_t i, const ContactState& state) const {
        return speed(i) > thresholds_.turned_speed * state.fastest * laws_[rubs_[i]].size;
    }

    // Removes the velocities of frictions at rest: methods that do not close velocities leave more than round-off.
    bool stop_all(Vector& y, const Flags& rests, double fastest);
    FrictionBalance balance(const std::vector<int>& stops, const Flags& rests, double fastest);

    // Sets directions of sliding that begins, and the rates at which they turn: friction is opposite to a velocity that is not there
    // yet, but arises from the forces a little later. A constant direction is wrong by as much as the forces change. False
    // where the equations have no unique solution.
    bool turn(double t, const Vector& y, const FrictionBalance& before, const Balanced& now, ContactState& next);
    // The accelerations of frictions that are starting to slide, with these forces until then. False where they are not known.
    bool slip_after(double h, double t, const Vector& y, const Vector& slope, FrictionBalance problem,
                    const Balanced& now, const ContactState& next, Vector& slip);

    // The accelerations of a border's rows without stops and frictions, and the loads of bearings then.
    bool accelerations(Border& border, const Vector& y, Vector& found);
    void loads_of(const FrictionBalance& problem, const Vector& forces, Vector& found) const;

    // The frictions whose load grows by more than itself where all slide, and no stop touches.
    std::vector<int> jams(const FrictionBalance& problem) const;
    // The frictions that are still at rest, or all where none is.
    std::vector<int> at_rest(const FrictionBalance& problem) const;

    // Sets what each friction does, from accelerations of all of `rubs_`; at a stop that does not push there is none.
    void take(const Balanced& found, const FrictionBalance& problem, const Vector& rate, const Vector& acceleration,
              const std::vector<long>& turns, bool known, ContactState& next) const;
    // The value of the coordinate where a friction is stuck; the same as before if it was stuck.
    double value_of(const Numbered& before, int k, const std::vector<long>& turns) const;

    Equations& equations_;
    const Mechanism& model_;
    const Thresholds& thresholds_;
    Undecided& undecided_;
    const std::unique_ptr<Border> border_;  // of stops that touch, and of the frictions that rub
    const std::unique_ptr<Border> later_;   // of the same rows a little later
    std::vector<FrictionLaw> laws_;
    std::vector<double> fixed_;                      // the static force of each at the last decision
    std::vector<std::vector<ContactRow>> touching_;  // walls of each friction
    std::vector<int> rubs_;                          // the frictions at joints and at stops that touch
    int stops_ = 0;
    Eigen::Index first_ = 0;  // the number of the border's rows of stops
    std::vector<double> lambda_;
    Vector slope_, rate_;
    std::vector<Supports> base_;
    std::vector<std::vector<Supports>> responses_;  // to a force of size 1 along each row
};

}  // namespace mbproj
