// Dry frictions between two events. A friction that sticks is a row of the border; one that slides is a law, times its
// part; one at rest without a row exerts a part of its static force. And the events that end this.
#pragma once

#include "contact/contact_state.hpp"
#include "contact/stop_watch.hpp"
#include "contact/walls.hpp"

namespace mbproj {

class ActingFrictions final {
public:
    explicit ActingFrictions(Equations& equations)
        : equations_(equations), model_(equations.mechanism()), thresholds_(model_.thresholds), walls_(equations) {}

    // Frictions are numbered after the stops, whose sides these are.
    void begin(std::vector<FrictionLaw> laws, std::vector<double> sides);
    const Walls& walls() const { return walls_; }
    const std::vector<FrictionLaw>& laws() const { return laws_; }
    // Whether any friction is at a stop; at this stop.
    bool any_feet() const {
        return std::any_of(laws_.begin(), laws_.end(), [](const FrictionLaw& law) { return law.stop >= 0; });
    }
    bool any_at(int stop) const {
        return std::any_of(laws_.begin(), laws_.end(), [=](const FrictionLaw& law) { return law.stop == stop; });
    }

    // Sets the frictions to this state from now on, with these other rows that hold, and others that slide.
    void hold(const ContactState& state, std::vector<ContactRow> rows, std::vector<SlidingRow> slides);
    // The static force of each friction at the last state, not multiplied by a load.
    std::vector<double> bounds() const;
    // Makes no friction act.
    void release();
    void watch(const ContactState& state, std::vector<WatchedGap>& gaps, std::vector<WatchedRow>& rows) const;

    // The friction that pushes along the motion in place, with these multipliers, or -1. Slow ones keep their direction, and rates
    // within round-off have none.
    int pushes(const ContactState& state, const std::vector<double>& lambda, double fastest) const;

private:
    using Limits = std::numeric_limits<double>;

    // Sliding in a plane is watched along directions at this angle to its own, rad: their rates are positive until it
    // comes to rest, or has turned by a right angle less this angle.
    static constexpr double aside = M_PI / 3.0;

    // The stops whose pushes are sums of the rows' forces: those that share a load, and those with friction.
    std::vector<ContactFoot> feet_of(const ContactState& state, const std::vector<ContactRow>& rows) const;
    void watch_rate(const ContactState& state, int k, std::vector<WatchedGap>& gaps) const;
    void watch_force(const ContactState& state, int k, std::vector<WatchedRow>& rows) const;

    Equations& equations_;
    const Mechanism& model_;
    const Thresholds& thresholds_;
    Walls walls_;
    std::vector<FrictionLaw> laws_;
    int stops_ = 0;
};

}  // namespace mbproj
