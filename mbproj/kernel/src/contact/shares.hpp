// How stops that touch share a load, where their rows depend on each other. Independent rows of some stops are held;
// each push is a weighted sum of the multipliers of these rows.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "model/thresholds.hpp"

namespace mbproj {

// A largest set of independent rows among some rows of B, in ascending order.
std::vector<Eigen::Index> independent(const Eigen::MatrixXd& B, std::vector<Eigen::Index> rows, double least);

// Takes rows of B one by one, and tells which are outside the span of those before.
class Span final {
public:
    Span(const Eigen::MatrixXd& B, double least) : B_(B), least_(least) {}
    // Whether a row is outside the span, which then includes it.
    bool takes(Eigen::Index row);
    bool holds(Eigen::Index row) const { return !(part_beyond(row) > least_); }
    // The part of a row outside the span, relative to its square.
    double part_beyond(Eigen::Index row) const;

private:
    double beyond(Eigen::Index row, Eigen::VectorXd& along) const;

    const Eigen::MatrixXd& B_;
    const double least_;
    std::vector<Eigen::VectorXd> basis_;  // the components of all rows along each basis vector
};

// The stops whose rows are held, and the parts of their multipliers with which each stop pushes. An `idle` stop does
// not push now, and its parts give a negative push until it does. A stop that is `apart` opens, and has no share.
// `decides`: whether the motion depends on how the stops share.
struct Shares {
    std::vector<Eigen::Index> rows;
    Eigen::MatrixXd parts;
    std::vector<bool> idle, apart;
    bool decides = false;
};

// The shares of stops with these pushes, as of springs of equal stiffness, from B of their rows. `B_pulled` is the
// effect of each push with the friction that slides there. False where the rows of stops that push, and of stops whose
// rows depend on those, are independent.
bool shares_of(const Eigen::MatrixXd& B, const Eigen::MatrixXd& B_pulled, const Eigen::VectorXd& push,
               const Thresholds& thresholds, Shares& found);

}  // namespace mbproj
