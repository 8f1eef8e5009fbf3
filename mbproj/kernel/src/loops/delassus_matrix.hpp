// The rows of the loops' joints, as columns Y = Zᵀ Gᵀ of the half-inverted inertias of their bodies, and S = YᵀY: which of
// them are held, and which are left out of the run because they follow from these.
#pragma once

#include <numeric>
#include <utility>

#include "elimination/elimination_order.hpp"
#include "elimination/inverse_root.hpp"
#include "loops/block_cholesky.hpp"
#include "loops/rank_revealing_cholesky.hpp"

namespace mbproj {

template <int D> class DelassusMatrix final {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;

    // A joint and some of its rows: those that are held, or those that are left out.
    struct JointRows {
        int joint, count;
        int rows[F];
        bool operator==(const JointRows& other) const {
            return joint == other.joint && count == other.count && std::equal(rows, rows + count, other.rows);
        }
    };
    // Of a joint in a list of them and one of its bodies, by its number in the loops: as many columns as it has rows.
    struct Incidence {
        int held, body;
        Matrix<F, F> Y;
    };

    DelassusMatrix(const Model<D>& model, const EliminationOrder<D>& order, const Compliance<D>& compliance)
        : model_(model), order_(order), compliance_(compliance) {
        halves.resize(order.loop_bodies.size());
        hold({});
    }

    std::vector<InverseRoot<D>> halves;  // of the loops' bodies
    BlockCholesky cholesky;
    // Whether flywheels have their inertia, as in the metric of the masses. Otherwise nothing turns them, and they nothing.
    bool flywheels_turn = true;
    // Whether compliant rows are in force, as in a stage of an implicit step: R J with -1 for a flywheel of inertia 1 each,
    // so that S has R J W⁻¹ Jᵀ Rᵀ + 1 whatever D = RᵀR is.
    bool complies = false;

    // A flywheel I that is held by a row: one more coordinate, with the half-inverse 1/√I, and -1 in that row.
    struct Flywheel {
        int row;             // of S
        std::size_t offset;  // of its diagonal entry
        double y;            // its entry of Y
        bool is_compliant;   // in place of a stiff force
    };
    const std::vector<Flywheel>& flywheels() const { return flywheels_; }
    double y(const Flywheel& flywheel) const {
        return (flywheel.is_compliant ? complies : flywheels_turn) ? flywheel.y : 0.0;
    }
    // Right-hand sides of compliant rows, which are given for J, for the rows R J; none where they are not in force.
    void scale(double* rhs) const {
        for (const int h : compliant_) {
            double* part = rhs + cholesky.row(h);
            if (complies)
                compliance_.turn(held_[h].joint, held_[h].count, part);
            else
                std::fill(part, part + held_[h].count, 0.0);
        }
    }

    const std::vector<JointRows>& held() const { return held_; }
    const std::vector<JointRows>& left_out() const { return left_out_; }
    const std::vector<Incidence>& incidences() const { return incidences_; }
    int count() const { return count_; }

    // Y and S at a pose, with a shift of the diagonal entries of C's rows.
    void fill(const Pose<D>& pose, double shift = 0.0) {
        for (Incidence& at : incidences_) fill_incidence(pose, held_[at.held], at);
        cholesky.clear();
        for (const Product& product : products_) {
            const Incidence &a = incidences_[product.a], &b = incidences_[product.b];
            const int rows = held_[a.held].count, columns = held_[b.held].count;
            double* target = cholesky.at(product.offset);
            const bool diagonal = product.a == product.b;  // of which the lower half counts
            for (int r = 0; r < rows; ++r)
                for (int c = 0; c < (diagonal ? r + 1 : columns); ++c)
                    target[r * columns + c] += a.Y.col(r).dot(b.Y.col(c));
        }
        if (shift > 0.0) penalise(shift);
        for (const Flywheel& f : flywheels_) *cholesky.at(f.offset) += y(f) != 0.0 ? f.y * f.y : 1.0;
    }

    // The same with bodies that all weigh the same, lengths in the mechanism's own.
    void fill_evenly(const Pose<D>& pose) {
        for (std::size_t b = 0; b < halves.size(); ++b)
            halves[b].bare(1.0 / (model_.length * model_.length), pose[order_.loop_bodies[b]].rotation,
                           Matrix<S::turns, S::turns>::Identity());
        const bool turn = std::exchange(flywheels_turn, false), comply = std::exchange(complies, false);
        fill(pose);
        flywheels_turn = turn;
        complies = comply;
    }

    // Columns of Y of the rows that are left out of the run, at the pose of the last `fill`.
    std::vector<Incidence> left_out_incidences(const Pose<D>& pose) const {
        std::vector<Incidence> found;
        for (std::size_t h = 0; h < left_out_.size(); ++h)
            for (const int body : model_.joints[left_out_[h].joint].bodies) {
                found.push_back({static_cast<int>(h), place_[body], Matrix<F, F>::Zero()});
                fill_incidence(pose, left_out_[h], found.back());
            }
        return found;
    }

    // Of each joint that is held, the rows that are independent at a pose: those whose distance from the span of the rows
    // before them exceeds √smallest, where all bodies weigh the same and lengths count in the mechanism's own. Overwrites S.
    std::vector<std::vector<int>> independent_rows(const Pose<D>& pose, double smallest) {
        fill_evenly(pose);
        return cholesky.independent_rows(smallest);
    }

    // Leaves all but these rows of those that are held out of the factors to come, or none. How many.
    int leave_out_all_but(const std::vector<std::vector<int>>& rows) {
        std::vector<char> dependent(count_, 1);
        for (std::size_t h = 0; h < held_.size(); ++h)
            for (const int r : rows[h]) dependent[cholesky.row(static_cast<int>(h)) + r] = 0;
        const auto count = std::count(dependent.begin(), dependent.end(), 1);
        cholesky.leave_out(count ? std::move(dependent) : std::vector<char>());
        return static_cast<int>(count);
    }

    // Of all rows of the loops' joints, in their order, holds those given, or all where there are none; leaves the others out
    // of the run.
    void hold(const std::vector<std::vector<int>>& rows) {
        std::vector<JointRows> held, left_out;
        for (std::size_t h = 0; h < order_.loop_joints.size(); ++h) {
            JointRows some{order_.loop_joints[h], 0, {}}, rest = some;
            for (int r = 0; r < model_.joints[some.joint].rows; ++r) {
                const bool is_held = rows.empty() || std::find(rows[h].begin(), rows[h].end(), r) != rows[h].end();
                JointRows& to = is_held ? some : rest;
                to.rows[to.count++] = r;
            }
            if (some.count) held.push_back(some);
            if (rest.count) left_out.push_back(rest);
        }
        if (held == held_) return;
        held_ = std::move(held);
        left_out_ = std::move(left_out);
        arrange();
    }

private:
    struct Product {  // incidences a and b share a body: YᵀY goes to this block of S
        int a, b;
        std::size_t offset;
    };

    // The structure of S for the rows that are held.
    void arrange() {
        std::vector<int> sizes;
        place_.assign(model_.size(), -1);
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b) place_[order_.loop_bodies[b]] = static_cast<int>(b);
        std::vector<std::vector<int>> touching(order_.loop_bodies.size());
        incidences_.clear();
        products_.clear();
        for (std::size_t h = 0; h < held_.size(); ++h) {
            sizes.push_back(held_[h].count);
            for (const int body : model_.joints[held_[h].joint].bodies) {
                touching[place_[body]].push_back(static_cast<int>(incidences_.size()));
                incidences_.push_back({static_cast<int>(h), place_[body], Matrix<F, F>::Zero()});
            }
        }
        std::vector<std::pair<int, int>> couplings;
        for (const auto& joints : touching)
            for (const int a : joints)
                for (const int b : joints) couplings.push_back({incidences_[a].held, incidences_[b].held});
        count_ = std::accumulate(sizes.begin(), sizes.end(), 0);
        cholesky = BlockCholesky(std::move(sizes), couplings);
        for (const auto& joints : touching)
            for (std::size_t a = 0; a < joints.size(); ++a)
                for (std::size_t b = 0; b <= a; ++b) add_product(joints[a], joints[b]);
        flywheels_.clear();
        for (int h = 0; h < static_cast<int>(held_.size()); ++h)
            if (const int joint = held_[h].joint; model_.holds_flywheel(joint)) {
                const double inertia = model_.flywheels[model_.joints[joint].row - model_.constraints.rows];
                flywheels_.push_back({cholesky.row(h), cholesky.target(h, h).offset, -1.0 / std::sqrt(inertia), false});
            }
        compliant_.clear();
        for (int h = 0; h < static_cast<int>(held_.size()); ++h)
            if (model_.is_compliant(held_[h].joint)) add_compliant(h);
    }

    void add_compliant(int h) {
        compliant_.push_back(h);
        for (int r = 0; r < held_[h].count; ++r) {
            const std::size_t diagonal = cholesky.target(h, h).offset + r * (held_[h].count + 1);
            flywheels_.push_back({cholesky.row(h) + r, diagonal, -1.0, true});
        }
    }

    void penalise(double shift) {
        for (int h = 0; h < static_cast<int>(held_.size()); ++h) {
            double* block = cholesky.at(cholesky.target(h, h).offset);
            if (!model_.holds_flywheel(held_[h].joint) && !model_.is_compliant(held_[h].joint))
                for (int r = 0; r < held_[h].count; ++r) block[r * (held_[h].count + 1)] += shift;
        }
    }

    void add_product(int a, int b) {
        const auto target = cholesky.target(incidences_[a].held, incidences_[b].held);
        products_.push_back(target.transposed ? Product{b, a, target.offset} : Product{a, b, target.offset});
    }

    void fill_incidence(const Pose<D>& pose, const JointRows& held, Incidence& at) const {
        Matrix<F, F> G;
        if (!flywheels_turn && model_.holds_flywheel(held.joint)) return at.Y.setZero(), void();
        const bool is_compliant = model_.is_compliant(held.joint);
        if (is_compliant && !complies) return at.Y.setZero(), void();
        jacobian<D>(model_, pose, model_.joints[held.joint], order_.loop_bodies[at.body], G);
        if (is_compliant)
            for (int c = 0; c < F; ++c) compliance_.turn(held.joint, held.count, &G(0, c));
        for (int r = 0; r < held.count; ++r) {
            Column<F> y = G.row(held.rows[r]).transpose();
            halves[at.body].forward(y);
            at.Y.col(r) = y;
        }
    }

    const Model<D>& model_;
    const EliminationOrder<D>& order_;
    const Compliance<D>& compliance_;
    std::vector<JointRows> held_, left_out_;
    std::vector<Incidence> incidences_;
    std::vector<Product> products_;
    std::vector<Flywheel> flywheels_;
    std::vector<int> compliant_;  // joints of those held
    std::vector<int> place_;      // of a body in the loops
    int count_ = 0;               // rows that are held
};

}  // namespace mbproj
