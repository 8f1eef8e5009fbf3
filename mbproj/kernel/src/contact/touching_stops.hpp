// The rigid stops that touch at a state: their impact, with the friction there, and their pushes afterwards.
#pragma once

#include "contact/contact_state.hpp"
#include "contact/impact.hpp"
#include "contact/one_sided.hpp"

namespace mbproj {

class TouchingStops final {
public:
    using Vector = Eigen::VectorXd;
    using Flags = std::vector<bool>;

    TouchingStops(Equations& equations, Undecided& undecided)
        : equations_(equations), model_(equations.mechanism()), thresholds_(model_.thresholds), undecided_(undecided),
          border_(equations.border()), slope_(model_.layout.size()) {}

    void begin(std::vector<StopLaw> laws, std::vector<FrictionLaw> frictions, ImpactLaw impacts) {
        laws_ = std::move(laws), frictions_ = std::move(frictions), impacts_ = impacts;
    }
    std::vector<ContactRow> rows_of(const std::vector<int>& stops) const;

    // Sets the stops that touch, at the factored pose in place. False where the equations have no unique solution.
    bool touch(std::vector<int> stops);
    const std::vector<int>& stops() const { return stop_; }
    // Whether the restitution of a stop counts: of struck stops, and except by Newton's law, of others with an impulse.
    bool bounces(bool struck) const { return struck || impacts_ != ImpactLaw::newton; }
    // The rates of the gaps, then of the frictions there.
    void rates(Vector& found) const { border_->rates(found); }
    Eigen::MatrixXd B_of_stops() const { return B_.topLeftCorner(count(), count()); }

    // The round-off of the last pushes.
    double round_off() const { return border_->round_off(); }

    // The impact of the stops that touch, without restitution where a bounce would be lower than the lowest that
    // counts. `rate` becomes the rates after it.
    bool strike(double t, const Vector& y, const Flags& struck, const Vector& slow, Vector e, Vector& rate,
                Vector& y_after, ContactState& next, std::vector<ContactEvent>& events,
                std::vector<ContactEvent>& rests);
    // Keeps gaps closed that would close before they are seen to open, as of a rocking body: changes y and `rate`.
    bool keep_down(Vector& y, const Vector& slow, Vector& rate, ContactState& next);

    // Sets the pushes of stops that stay closed, at y with its pose in place, and which gaps open then. Where their
    // rows depend on each other, they share the load as springs of one stiffness.
    bool pushes(const Vector& y, const Flags& staying, Vector& push, Flags& opens);

private:
    Eigen::Index count() const { return static_cast<Eigen::Index>(stop_.size()); }

    std::vector<int> of(const Flags& chosen) const;
    bool has_answer(Strike found, const Vector& before);
    // The kinetic energy that impulses z give, at rates before.
    double given(const Vector& before, const Vector& z) const { return 0.5 * z.dot(B_ * z) + z.dot(before); }
    bool creates(const Vector& y, const Vector& before, const Vector& z) const {
        return given(before, z) > thresholds_.creates_energy * equations_.kinetic_energy(y);
    }
    bool refuse_energy(const Vector& before, const Vector& e, const Vector& slow, const Vector& z);

    // Records the energy that impulses z, at rates before, take from a motion y, and the work of motions.
    void account(const Vector& y, const Vector& before, const Vector& z, ContactState& next) const;

    // Pushes with which these stops stay closed, from the last accelerations. False where there are none.
    bool hold(const Flags& staying, Vector& push) const;

    // Replaces pushes z that are not unique, of stops that do not open.
    void share(const Eigen::MatrixXd& B, const Vector& b, Vector& z) const;

    // The state after impulses z.
    bool change(const Vector& y, const Vector& z);

    // The accelerations of the gaps at y, without pushes.
    bool accelerations(const Vector& y, Vector& found);

    // The accelerations with which gaps close while stops at rest stay closed: a ball falls on another on the floor.
    bool falls(const Vector& rate, const Vector& slow, Vector& fall);
    bool lifts_less(Eigen::Index i, double rate, double fall, double height) const;

    // Whether a gap opens after an impact by less than the lowest bounce that counts, and is not `staying`; adds it,
    // and gaps at rest. Where some gaps stay closed, others that opened before may close.
    bool rocks(const Flags& low, const Vector& rate, const Vector& slow, const Vector& fall, Flags& staying) const;

    // Impulses with which these stops stay closed: a rocking body comes to rest.
    Vector without_lifting(const Flags& staying, const Vector& rate);
    std::vector<Eigen::Index> only(const Flags& chosen, const Vector& all, Eigen::MatrixXd& B, Vector& b) const;

    Equations& equations_;
    const Mechanism& model_;
    const Thresholds& thresholds_;
    Undecided& undecided_;
    const std::unique_ptr<Border> border_;
    Eigen::MatrixXd B_;  // of its rows, 0 where nothing can move
    std::vector<StopLaw> laws_;
    std::vector<FrictionLaw> frictions_;
    ImpactLaw impacts_ = ImpactLaw::newton;
    std::vector<int> stop_, rubs_;  // that touch, and the frictions at them
    Rubbing rubbing_;
    Flags moves_;  // of each row, whether something can move along it
    Vector after_, slope_, free_;
};

}  // namespace mbproj
