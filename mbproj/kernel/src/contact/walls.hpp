// Walls: rigid stops along coordinates of joints with dry friction. A friction that sticks at a wall shares one row
// with it. The motion does not determine their shares of the row's force; the smallest is reported.
#pragma once

#include "contact/contact_state.hpp"
#include "solver/equations.hpp"

namespace mbproj {

class Walls final {
public:
    explicit Walls(const Equations& equations) : equations_(equations), model_(equations.mechanism()) {}

    // The sides of the stops, and the laws of the frictions, which are numbered after them.
    void begin(std::vector<double> sides, std::vector<FrictionLaw> laws) {
        sides_ = std::move(sides), laws_ = std::move(laws);
    }

    // The first friction along a stop's coordinate, or -1.
    int along(int stop) const;
    // Whether a friction sticks at this stop, if it holds.
    bool has(const ContactState& state, int stop) const;
    // Whether a friction sticks at a wall on this side.
    bool any(const ContactState& state, int friction, double side) const;
    // Removes the rows of walls at which frictions stick: the frictions' rows hold.
    void remove(const ContactState& state, std::vector<ContactRow>& rows) const;

    // The walls of each friction among the rows of stops that touch; removes them from these rows.
    std::vector<std::vector<ContactRow>> take_from(std::vector<ContactRow>& rows) const;
    // Makes frictions at rest at a wall among these stops stick there.
    void stick(const std::vector<ContactRow>& closed, ContactState& next) const;
    static bool push(const std::vector<ContactRow>& walls, double side) {
        return std::any_of(walls.begin(), walls.end(), [side](const ContactRow& row) { return row.sign == side; });
    }
    // The push of a wall that shares this force with friction up to a bound: half of it, or what friction leaves.
    static double push_of(double force, double bound) {
        return force > 0.0 ? force - std::min(0.5 * force, bound) : 0.0;
    }

    // Divides the forces of shared rows between walls and frictions. `fixed`: the static forces, not multiplied by
    // loads.
    void share(const ContactState& state, const std::vector<double>& lambda, const std::vector<double>& fixed,
               std::vector<double>& forces) const;

private:
    bool is_along(int stop, int friction) const;

    const Equations& equations_;
    const Mechanism& model_;
    std::vector<double> sides_;
    std::vector<FrictionLaw> laws_;
};

}  // namespace mbproj
