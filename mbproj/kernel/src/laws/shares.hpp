// How stops that touch share what they push, where their rows depend on each other: some of them hold rows, and the pushes of all
// are parts of what these bear. The reference is mbproj.dynamics.friction.shares.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "model/thresholds.hpp"

namespace mbproj {

// Of some rows of B as many as do not depend on each other, in ascending order.
std::vector<Eigen::Index> independent(const Eigen::MatrixXd& B, std::vector<Eigen::Index> rows, double least);

// Rows of B one after another: which are outside of what those before them span.
class Span final {
public:
    Span(const Eigen::MatrixXd& B, double least) : B_(B), least_(least) {}
    // Whether a row is outside; it is inside from now on.
    bool takes(Eigen::Index row);
    bool holds(Eigen::Index row) const { return !(part_beyond(row) > least_); }
    // How much of a row is outside, as a part of its square.
    double part_beyond(Eigen::Index row) const;

private:
    double beyond(Eigen::Index row, Eigen::VectorXd& along) const;

    const Eigen::MatrixXd& B_;
    const double least_;
    std::vector<Eigen::VectorXd> basis_;  // of all rows their parts along each
};

// Of stops that touch: those that hold rows, and the parts of their multipliers that each pushes with. Of those that are `idle` the
// parts give less than nothing, as long as they do not push; those that are `apart` have no share, since they open. Whether the motion
// depends on how they share is `decides`.
struct Shares {
    std::vector<Eigen::Index> rows;
    Eigen::MatrixXd parts;
    std::vector<bool> idle, apart;
    bool decides = false;
};

// Of stops that push so, with B of their rows, and of what each push does together with the friction that slides by it. False where
// the rows of those that push, and of those that follow from them, are independent. As their motion goes on they share as springs
// of one stiffness do.
bool shares_of(const Eigen::MatrixXd& B, const Eigen::MatrixXd& B_pulled, const Eigen::VectorXd& push,
               const Thresholds& thresholds, Shares& found);

}  // namespace mbproj
