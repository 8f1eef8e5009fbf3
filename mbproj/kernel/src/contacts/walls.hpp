// Walls: rigid stops along coordinates of joints with dry friction. A friction that sticks at a wall shares one row
// with it. The motion does not determine their shares of the row's force; the smallest is reported.
#pragma once

#include "contacts/contact_state.hpp"
#include "dynamics/equations.hpp"

namespace mbproj {

class Walls final {
public:
    explicit Walls(const Equations& equations) : equations_(equations), model_(equations.mechanism()) {}

    // The sides of the stops, and the laws of the frictions, which are numbered after them.
    void begin(std::vector<double> sides, std::vector<FrictionLaw> laws) {
        sides_ = std::move(sides), laws_ = std::move(laws);
    }

    // The first friction along a stop's coordinate, or -1.
    int along(int stop) const {
        for (int k = 0; k < static_cast<int>(laws_.size()); ++k)
            if (is_along(stop, k)) return k;
        return -1;
    }
    // Whether a friction sticks at this stop, if it holds.
    bool has(const ContactState& state, int stop) const {
        return std::any_of(state.stuck.begin(), state.stuck.end(),
                           [&](const auto& each) { return is_along(stop, each.first); });
    }
    // Whether a friction sticks at a wall on this side.
    bool any(const ContactState& state, int friction, double side) const {
        return std::any_of(state.held.begin(), state.held.end(),
                           [&](int stop) { return is_along(stop, friction) && sides_[stop] == side; });
    }
    // Removes the rows of walls at which frictions stick: the frictions' rows hold.
    void remove(const ContactState& state, std::vector<ContactRow>& rows) const {
        const auto is_wall = [&](const ContactRow& row) { return has(state, row.coordinate); };
        rows.erase(std::remove_if(rows.begin(), rows.end(), is_wall), rows.end());
    }

    // The walls of each friction among the rows of stops that touch; removes them from these rows.
    std::vector<std::vector<ContactRow>> take_from(std::vector<ContactRow>& rows) const {
        std::vector<std::vector<ContactRow>> found(laws_.size());
        std::vector<ContactRow> others;
        for (const ContactRow& row : rows) {
            const int k = along(row.coordinate);
            (k < 0 ? others : found[k]).push_back(row);
        }
        rows = std::move(others);
        return found;
    }
    // Makes frictions at rest at a wall among these stops stick there.
    void stick(const std::vector<ContactRow>& closed, ContactState& next) const {
        for (const ContactRow& row : closed) {
            const int k = along(row.coordinate);
            if (k < 0 || mbproj::has(next.sliding, k) || next.parts_of(row.coordinate)) continue;
            const auto is_own = [k](const auto& each) { return each.first == k; };
            for (Numbered* all : {&next.stuck, &next.bearing})
                all->erase(std::remove_if(all->begin(), all->end(), is_own), all->end());
            next.stuck.emplace_back(k, row.at);
        }
    }
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
               std::vector<double>& forces) const {
        for (const int stop : state.held)
            for (const auto& [k, at] : state.stuck) {
                if (!is_along(stop, k)) continue;
                double& force = forces[sides_.size() + k];
                const double load = laws_[k].bearing < 0 ? 1.0 : equations_.load(laws_[k].bearing, lambda.data());
                forces[stop] = push_of(sides_[stop] * force, fixed[static_cast<std::size_t>(k)] * load);
                force -= sides_[stop] * forces[stop];
            }
    }

private:
    bool is_along(int stop, int friction) const {
        const auto& coordinates = model_.stops.joint_coordinate;
        return coordinates[stop] >= 0 && coordinates[stop] == coordinates[sides_.size() + friction];
    }

    const Equations& equations_;
    const Mechanism& model_;
    std::vector<double> sides_;
    std::vector<FrictionLaw> laws_;
};

}  // namespace mbproj
