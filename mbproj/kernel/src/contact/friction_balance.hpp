// Decides which stops that touch push, and which dry frictions stick or slide, from one state on: as many stick as can.
// A stop pushes, y >= 0, or opens. A friction at rest holds with |y| up to its static force, or slides against it; one
// that slides has its sliding force. Where rows depend on each other, frictions stick while some share of the load is
// within all cones. A wall is a stop along the coordinate of a joint's friction: both have the friction's row.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "contact/contact_problem.hpp"
#include "contact/shares.hpp"

namespace mbproj {

// The forces y; which frictions are stuck, each by a row; the direction in which each slides, 0 at rest; the part of
// its static force that a friction at rest without a row exerts; whether stops share a load, and how.
struct Balanced {
    Eigen::VectorXd y, direction, part;
    std::vector<bool> stuck;
    bool shared = false;
    Shares shares;
};

// Stops, then frictions: B of their rows, and the accelerations b without their forces y.
struct FrictionBalance {
    using Index = Eigen::Index;
    using Vector = Eigen::VectorXd;
    using Flags = std::vector<bool>;
    // The loads that multiply the frictions, from all forces.
    using Loads = std::function<void(const Vector& y, Vector& found)>;

    Index stops;
    Eigen::MatrixXd B;
    Vector b;
    // For each friction: its static and its sliding force per load, the direction in which it slides, 0 at rest, and an
    // acceleration that counts as round-off.
    Vector fixed, sliding, direction, still;
    std::vector<int> stop,
        partner;     // for each friction, the stop whose push multiplies it, and the other tangent, or -1
    Flags able;      // for each row, whether something can move along it
    Flags up, down;  // for each friction, whether a wall can push that way along its row
    bool gave_way =
        false;  // whether frictions have given way often at this time, though some share seemed to hold them

    // False where no forces satisfy these laws.
    bool decide(const Loads& loads, const Thresholds& thresholds, Balanced& found);
    // Whether rows depend on each other while some are walls. These laws do not cover that: walls get their own rows.
    bool depends_at_walls(const Thresholds& thresholds) const;
    // The accelerations of frictions at rest that slip by Coulomb's law. False where there is no answer.
    bool slip(const Loads& loads, const Thresholds& thresholds, Vector& found) const;
    // Whether a friction is at rest.
    bool rests(Index k) const { return with_partner(direction, k) == 0.0; }
    // The forces y that hold frictions at rest, or, where they cannot, are at most static. False where there are none.
    bool forces(const Loads& loads, const Thresholds& thresholds, Vector& y) const;

private:
    Index count() const { return fixed.size(); }
    bool moves(Index row) const { return able[static_cast<std::size_t>(row)]; }
    bool in_plane(Index k) const;
    double with_partner(const Vector& values, Index k) const;
    bool at_wall(Index k) const { return up[static_cast<std::size_t>(k)] || down[static_cast<std::size_t>(k)]; }
    bool is_within(Index k, double force, double bound) const;
    Eigen::MatrixXd pulls() const;
    bool relaxed(const Loads& loads, const Thresholds& thresholds, bool bounded, Vector& y) const;
    bool slipping(const Loads& loads, const Thresholds& thresholds, const Vector& held, Vector& y) const;
    // Which frictions at rest would exceed their static force.
    Flags beyond(const Loads& loads, const Vector& y) const;
    // Whether rows of stops depend on each other, or on rows of frictions at rest.
    bool depend(const Thresholds& thresholds) const;
    std::vector<Cone> cones(double at_stops, double at_joints, const Vector& load) const;
    template <class Solve>
    bool with_loads(const Loads& loads, const Thresholds& thresholds, const Solve& solve, Vector& y) const;
    bool all_hold(const Loads& loads, const Thresholds& thresholds, Vector& y) const;
    bool all_hold(const Loads& loads, const Thresholds& thresholds, double margin, const Vector& least,
                  Vector& y) const;
    bool has_margin(const Vector& y, double margin) const;
    bool coulomb(const Loads& loads, const Thresholds& thresholds, double part, Vector& y, Vector& slip) const;
    bool yields(const Loads& loads, const Thresholds& thresholds, Vector& y, Vector& slip) const;
    double none_slips(const Thresholds& thresholds, const Vector& y) const;
    Vector slips(const Thresholds& thresholds, const Vector& y, const Vector& load, bool holds, const Vector* slip,
                 Flags& stuck) const;
};

}  // namespace mbproj
