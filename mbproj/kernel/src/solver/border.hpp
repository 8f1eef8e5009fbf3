// Contacts as a border on the joints' factor. N are the gradients of coordinates that only contacts hold. Their Delassus operator
// is B = N (W⁻¹ - W⁻¹GᵀS⁻¹GW⁻¹) Nᵀ: one solve with the current factor for each row, for accelerations, projections and impulses
// alike. The factor, its order and its redundant rows do not depend on contacts.
#pragma once

#include <algorithm>
#include <cmath>

#include "solver/feet.hpp"

namespace mbproj {

// A row that keeps the coordinate of a stop or of a dry friction, by its number, `at` a value. `sign` is the side of a
// stop, so that the row is its gap.
struct ContactRow {
    int coordinate;
    double sign, at;
};

// Of the pose, motion and factor in place.
class Border {
public:
    using Vector = Eigen::VectorXd;

    Border(const Border&) = delete;
    Border& operator=(const Border&) = delete;
    virtual ~Border() = default;

    // Sets the rows that hold from now on.
    void hold(std::vector<ContactRow> rows, std::vector<SlidingRow> slides = {}, std::vector<ContactFoot> feet = {}) {
        rows_ = std::move(rows), slides_ = std::move(slides), given_ = false;
        feet_.hold(std::move(feet), rows_.size());
    }
    // Sets forces along rows that are no constraints.
    void give(std::vector<ContactRow> rows, Vector forces) {
        hold(std::move(rows));
        pushes_ = std::move(forces), given_ = true;
    }
    bool gives() const { return given_; }
    const std::vector<ContactRow>& rows() const { return rows_; }
    bool any() const { return !rows_.empty() && !given_; }
    bool acts() const { return any() || !slides_.empty(); }
    // Whether friction depends on pushes along the rows.
    bool has_feet() const { return feet_.any(); }
    // The law of a friction that leaves no unique forces, or -1.
    int jammed() const { return feet_.jammed(); }

    // Sets N.
    virtual void set_normals() = 0;
    // Sets N, and B with the solver's factor; reactions where bearings need them, or on request. False where the
    // equations have no unique solution.
    virtual bool factor(bool reacts = false) = 0;
    const Eigen::MatrixXd& operator_of_rows() const { return B_; }
    // The change of the joints' multipliers by a unit force along each row, where bearings depend on them.
    const Eigen::MatrixXd& reactions() const { return reactions_; }
    // Whether anything can move along a row. Where nothing can, B is round-off of its value without joints.
    bool moves(Eigen::Index k) const { return !is_held_ && B_(k, k) > no_push_ * loose_[k]; }
    // The factor of the independent rows.
    const SemidefiniteCholesky& cholesky() const { return cholesky_; }

    // The rates N u.
    virtual void rates(Vector& found) const = 0;
    // g'' of the rows in the solver's last motion. In the first `first` rows, values within the round-off of the whole
    // motion become 0. The energy of accelerations bounds each row's share: |g''|² <= B Σ (m r''² + ω'ᵀ J ω').
    virtual void accelerations(Eigen::Index first, Vector& found) = 0;
    // Whether the gap of one of these first rows opens with this acceleration.
    bool opens(Eigen::Index k, double acceleration) const { return acceleration > rests_[k]; }
    // The round-off of forces along these rows.
    double round_off() const {
        double most = 0.0;
        for (Eigen::Index k = 0; k < rests_.size(); ++k)
            if (rests_[k] > 0.0) most = std::max(most, rests_[k] / B_(k, k));
        return most;
    }
    // The forces z along the rows with b + B z = 0; they are 0 along dependent rows.
    void close(const Vector& b, Vector& z) const { cholesky_.solve(b, z); }
    // Solves for the change by impulses z along the rows, with the right-hand sides c of the joints' rows.
    virtual bool respond(const Vector& z, const double* c = nullptr) = 0;
    const Vector& free_accelerations() const { return free_; }

protected:
    Border(bool is_held, double no_push) : is_held_(is_held), no_push_(no_push) {}

    std::vector<ContactRow> rows_;
    std::vector<SlidingRow> slides_;
    Feet feet_;
    bool given_ = false;
    Eigen::MatrixXd B_, reactions_;
    SemidefiniteCholesky cholesky_;
    Vector free_, pushes_, loose_, rests_;

private:
    const bool is_held_;  // whether the mechanism has no degree of freedom
    const double no_push_;
};

}  // namespace mbproj
