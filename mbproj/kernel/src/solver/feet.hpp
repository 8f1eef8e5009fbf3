// Stops that touch and share the forces of contact rows, and dry friction by their pushes. With forces z along rows N the pushes
// are p = P z, and friction adds forces F p. With E, the effect of F along the rows: (B + E P) z + b = 0.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "model/decompositions.hpp"
#include "model/semidefinite.hpp"

namespace mbproj {

// A friction that slides, with the law that gives its force.
struct SlidingRow {
    int coordinate, law;
};
// A stop that touches. It pushes with these parts of the rows' forces; its push multiplies the laws of its friction.
struct ContactFoot {
    int stop;
    std::vector<std::pair<std::size_t, double>> parts;
    std::vector<SlidingRow> rubs;
};

class Feet final {
public:
    using Vector = Eigen::VectorXd;
    using Matrix = Eigen::MatrixXd;

    void hold(std::vector<ContactFoot> feet, std::size_t rows);
    // Whether friction depends on their pushes.
    bool any() const { return any_; }
    // The law of a friction that leaves no unique forces, or -1.
    int jammed() const { return jammed_; }

    // Sets the equations of the rows from B, its factor, and the joints' reactions to each row. effect(foot, column,
    // reactions) gives the change by the friction of a foot with a push of 1. False where the forces are not unique.
    template <class Effect> bool add_friction(const Matrix& B, const Matrix& reactions,
                                              const SemidefiniteCholesky& factor, const Effect& effect) {
        const auto feet = P_.rows();
        Matrix E(B.rows(), feet), R(reactions.rows(), feet);
        Vector column;
        for (Eigen::Index f = 0; f < feet; ++f) {
            if (!effect(feet_[static_cast<std::size_t>(f)], column, R.rows() ? &R(0, f) : nullptr)) return false;
            E.col(f) = column;
        }
        left_ = B + E * P_;
        reactions_ = reactions + R * P_;
        return is_unique(factor, E);
    }
    // The forces along the rows, where b are the accelerations without them.
    void close(const Vector& b, Vector& z) const { z = solved(left_, -b); }
    const Matrix& reactions() const { return reactions_; }

    // Calls take(foot, push) with the forces of the rows.
    template <class Take> void each(const Take& take, const Vector& z) const {
        if (feet_.empty()) return;
        const Vector pushes = P_ * z;
        for (std::size_t f = 0; f < feet_.size(); ++f) take(feet_[f], pushes[static_cast<Eigen::Index>(f)]);
    }

private:
    // Whether no push grows by more than itself, as loads of bearings: (I - K) x = 1 has a positive solution, K the
    // largest growth of each push with each other one. Pushes may shrink by any part.
    bool is_unique(const SemidefiniteCholesky& factor, const Matrix& E);

    std::vector<ContactFoot> feet_;
    Matrix P_, left_, reactions_;
    bool any_ = false;
    int jammed_ = -1;
};

}  // namespace mbproj
