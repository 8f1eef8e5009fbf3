// Compliant stops: each is a law of the scene that acts while it pushes. Which push, and what ends that.
#pragma once

#include "contact/contact_state.hpp"
#include "contact/stop_gap.hpp"
#include "contact/stop_watch.hpp"

namespace mbproj {

class CompliantStops final {
public:
    using Vector = Eigen::VectorXd;

    explicit CompliantStops(Equations& equations)
        : equations_(equations), model_(equations.mechanism()), thresholds_(model_.thresholds),
          border_(equations.border()), slope_(model_.layout.size()) {}

    void begin(const std::vector<StopLaw>& laws);
    bool any() const { return !laws_.empty(); }
    bool fits(const ContactState& state) const;

    // Makes the stops push from now on that push in this state.
    void act(const ContactState& state);
    std::vector<SlidingRow> slides(const ContactState& state) const;
    void watch(const ContactState& state, std::vector<WatchedGap>& gaps) const;
    // Replaces the forces along the coordinates of stops that push by their pushes.
    void turn(const ContactState& state, std::vector<double>& forces) const {
        for (const auto& [k, by] : state.pushing) forces[k] = std::max(law(k).side * forces[k], 0.0);
    }

    // Decides which stops begin to push and which end, at y with whole turns. Its pose is in place and factored, its
    // velocities are in place, and neither rigid stops nor frictions act. The stop `met` begins, even where its gap
    // neither moves nor accelerates. `own`: the speed of the fastest part, in lengths of the mechanism and rad per s;
    // gaps that are much slower are at rest. A stop whose gap opens, but will close again within its slack, pushes.
    // False where the equations have no unique solution.
    bool meet(double t, const Vector& y, const std::vector<long>& turns, int met, double own, ContactState& next,
              std::vector<ContactEvent>& events);

    // Whether a stop at rest pushes depends on the forces of the contacts of `next`, which now act; the motion in place
    // is that after the meeting. A stop with no gap has no force yet, so that nothing else depends on this.
    void press(const Vector& y, const std::vector<long>& turns, double own, ContactState& next,
               std::vector<ContactEvent>& events);

private:
    const StopLaw& law(int number) const;
    static bool pushes(const ContactState& state, int number);
    double gap(int k, const StopLaw& stop, const std::vector<long>& turns) const {
        return stop_gap(equations_, turns, k, stop.side);
    }
    double rate(int k, const StopLaw& stop) const { return stop.side * equations_.at_stop(k).rate; }
    bool is_closed(int k, const StopLaw& stop, const std::vector<long>& turns) const {
        return std::abs(gap(k, stop, turns)) <= thresholds_.touching * stop.size;
    }
    // Makes a stop push from now on, or no more.
    void begin(int k, const StopLaw& stop, ContactState& next) const;
    static void end(int k, ContactState& next);
    // The acceleration of the gap of the border's row.
    bool accelerates(const Vector& y, double& found);

    Equations& equations_;
    const Mechanism& model_;
    const Thresholds& thresholds_;
    const std::unique_ptr<Border> border_;  // of one stop
    std::vector<std::pair<int, StopLaw>> laws_;
    Vector slope_;
};

}  // namespace mbproj
