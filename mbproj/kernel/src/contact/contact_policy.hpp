// Decides which contacts hold, and what happens at a meeting: impacts, contacts that begin and end, bounces that come
// to rest, sticking and sliding.
#pragma once

#include "contact/compliant_stops.hpp"
#include "contact/dry_friction.hpp"
#include "contact/sharing.hpp"
#include "contact/touching_stops.hpp"

namespace mbproj {

class ContactPolicy final {
public:
    using Vector = Eigen::VectorXd;

    ContactPolicy(Equations& equations, ContactState& state);

    // False where the state does not fit these laws.
    bool begin(std::vector<StopLaw> laws, std::vector<FrictionLaw> frictions, ImpactLaw impacts, ContactState state,
               LoadedJoints joints_in_space);
    bool fits(const ContactState& state) const;
    // The state was set: its rows hold.
    void resume() { hold(); }
    bool any() const { return !laws_.empty() || friction_.any(); }
    // Whether no meeting has been decided yet, not even that at the start of a run.
    bool begins() const { return !std::isfinite(state_.met_at); }
    const ContactState& state() const { return state_; }
    // Why the last meeting could not be decided.
    const Undecided& undecided() const { return undecided_; }
    std::size_t stops() const { return laws_.size(); }
    std::vector<ContactEvent> take_events() { return std::exchange(events_, {}); }
    // The force along each coordinate of stops and frictions at y at t, from the multipliers there.
    std::vector<double> forces(double t, const double* y, const std::vector<double>& lambda);
    // The direction in which each friction slides, 0 for others; in a plane it is opposite to the friction's force.
    std::vector<double> slides(const std::vector<double>& forces) const;

    // Sets the events that end the current contacts, for which `watch` looks.
    void watch(StopWatch& watch, double spacing) const;
    // Records the speed of the fastest part at a state, in lengths of the mechanism and rad per s.
    void record_speed(const Vector& y) { state_.fastest = std::max(state_.fastest, speed(y)); }

    // Whether a friction pushes along the motion to y, whose pose and motion are in place, with these multipliers.
    bool finds_push(const Vector& y, const std::vector<double>& lambda);

    // Decides a meeting at y at t, with whole turns: this stop or friction is met or comes to rest, or is `released`;
    // with -1 contacts are not known. Changes y to the state after it. False where nothing can be decided: then nothing
    // has changed. `interval`: the time between two samples.
    bool meet(double t, Vector& y, const std::vector<long>& turns, int stop, bool released, double interval);

private:
    using Flags = std::vector<bool>;

    static constexpr double ahead = 1e-2;  // of the time between two samples: when the direction of a slip is looked at

    bool holds(int stop) const { return has(state_.held, stop) || state_.parts_of(stop); }
    void hold();
    double speed(const Vector& y) const { return equations_.fastest_part(y); }

    // Finds the rigid stops that touch at a state, with their border, while no contact acts; decides which compliant
    // stops push. False where the equations have no unique solution.
    bool touches(double t, const Vector& y, const std::vector<long>& turns, int met, ContactState& next,
                 std::vector<ContactEvent>& events);

    bool settle(double t, const Vector& y, const std::vector<long>& turns, int stop, bool released, double interval,
                ContactState& next, std::vector<ContactEvent>& events);

    // Decides again which compliant stops push, with the forces of the contacts that act from here on.
    void press_compliant(const std::vector<long>& turns, ContactState& next, std::vector<ContactEvent>& events);

    static bool any(const Flags& flags) { return std::find(flags.begin(), flags.end(), true) != flags.end(); }

    // Whether stops that stay push by no more than round-off while another is released; they are released with it.
    bool let_go(const Vector& push, Flags& staying) const;

    // Sets the pushes of stops without friction that stay, and how they share a load.
    bool press(const Flags& staying, Vector& push, Flags& opens, ContactState& next);

    // Lists the stops that stay closed, and their places among those that touch.
    void take(const Flags& staying, std::vector<int>& closed, std::vector<Eigen::Index>& which) const;

    // Finds the contacts whose forces the motion does not determine from here on.
    bool find_shares(double t, const Flags& staying, ContactState& next);

    // Decides what frictions do from here on, while these stops stay closed, and sets the stops' pushes.
    bool balance_frictions(double t, const std::vector<long>& turns, const Flags& staying, int met, bool released,
                           bool struck, ContactState& next, Vector& push, Flags& opens);

    void record(double t, const ContactState& next, const std::vector<ContactEvent>& rests,
                std::vector<ContactEvent>& events) const;

    Equations& equations_;
    const Mechanism& model_;
    const Thresholds& thresholds_;
    Undecided undecided_;
    TouchingStops touching_;
    DryFriction friction_;
    CompliantStops compliant_;
    Sharing sharing_;
    std::vector<StopLaw> laws_;
    ContactState& state_;
    std::vector<ContactEvent> events_;
    Vector after_;
};

}  // namespace mbproj
