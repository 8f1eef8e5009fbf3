// Finds the stops that touch, frictions at rest and joints whose forces the motion does not determine: they share a
// load, and a run reports one share of many.
#pragma once

#include <functional>

#include "contact/acting_frictions.hpp"

namespace mbproj {

// Gives the numbers of the joints that bear some of these forces at y at t. Forces have a row for each coordinate of
// stops and frictions. In the plane joints may bear loads out of the plane.
using LoadedJoints = std::function<std::vector<int>(double t, const Eigen::VectorXd& y, const Eigen::MatrixXd& forces)>;

class Sharing final {
public:
    using Vector = Eigen::VectorXd;

    LoadedJoints joints_in_space;  // for a run in the plane

    explicit Sharing(Equations& equations)
        : equations_(equations), model_(equations.mechanism()), thresholds_(model_.thresholds),
          border_(equations.border()) {}

    // The numbers of the contacts that share a load at y at t: stops, then frictions, then joints. `near`: the rows of
    // rigid stops that touch and are at rest there. False where the equations have no unique solution.
    bool find(double t, const Vector& y, const ContactState& state, const std::vector<FrictionLaw>& laws, int stops,
              const std::vector<ContactRow>& near, std::vector<int>& found);

    // Replaces forces along coordinates of stops and frictions at y at t by those of the least-norm share. It serves
    // where frictions at stops are at rest: the run has any share. `rows`: those of the stops that push.
    void find_least(double t, const double* y, const ContactState& state, const std::vector<FrictionLaw>& laws,
                    int stops, std::vector<ContactRow> rows, std::vector<double>& forces);

private:
    using Limits = std::numeric_limits<double>;

    // A basis of the forces that do not change the motion, along rows of unit length. Rows of stops that do not push
    // count only within the span of the others: else they open. A row along which nothing can move has no part.
    std::vector<Vector> balanced_with_themselves(const std::vector<ContactRow>& rows, const ContactState& state,
                                                 Eigen::Index first) const;

    // Whether only walls share, each a stop and a friction along one joint coordinate: joints bear none of that.
    bool are_walls(const std::vector<ContactRow>& rows, const std::vector<Vector>& open) const;
    // Whether the load of a bearing changes with some of these multipliers, of forces up to a size.
    bool changes(int number, const Eigen::MatrixXd& lambda, double size) const;
    // The joints that bear some of these forces, with these multipliers.
    std::vector<int> loaded(double t, const Vector& y, const std::vector<ContactRow>& rows, const Eigen::MatrixXd& own,
                            const Eigen::MatrixXd& lambda, double size) const;
    // Whether a joint bears some of these forces.
    bool bears(const Joint& joint, const Eigen::MatrixXd& lambda, double size) const;

    Equations& equations_;
    const Mechanism& model_;
    const Thresholds& thresholds_;
    const std::unique_ptr<Border> border_;
};

}  // namespace mbproj
