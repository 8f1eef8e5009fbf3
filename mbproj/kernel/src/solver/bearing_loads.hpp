// The loads of bearings where friction is proportional to the load and is part of it. The multipliers are linear in the forces.
// With the response fⱼ of the bearings to each friction, Newton's method solves L = load(f₀ + Σ Lⱼ fⱼ) for the loads L. Where
// friction is so strong that a load may grow by more than itself, there is no solution, or there are two (Painlevé).
#pragma once

#include "kinematics/bearings.hpp"
#include "model/decompositions.hpp"
#include "solver/contact_border.hpp"

namespace mbproj {

template <class D> class BearingLoads final {
public:
    explicit BearingLoads(const Model<D>& model) : model_(model), none_(model.all_rows(), 0.0), lambda_(none_) {
        if (!model.loads) return;
        for (std::size_t l = 0; l < model.loads->laws.size(); ++l)
            if (model.loads->laws[l].bearing >= 0) laws_.push_back(static_cast<int>(l));
    }

    // Whether friction depends on a bearing.
    bool any() const { return !laws_.empty(); }
    // The law that had no unique solution at the last state, or -1.
    int jammed() const { return jammed_; }

    // Sets the loads at a pose, with the right-hand side gamma of the rows. The solver has all forces but these
    // frictions, which are in `applied`; the rows of `contacts` hold in each solution. False where the equations have
    // no solution, or not only one: then `jammed` is the law.
    bool settle(Applied<D>& applied, KktSolver<D>& solver, ContactBorder<D>& contacts, const Pose<D>& pose,
                const double* gamma) {
        jammed_ = -1;
        if (!solver.solve(gamma, lambda_.data())) return false;
        if (contacts.any()) contacts.add_reactions(true, lambda_);
        const std::size_t bearings = model_.bearings.size();
        find_supports(pose, base_);
        responses_.assign(bearings, std::vector<Supports>(bearings));
        for (const int l : laws_) {
            applied.clear();
            applied.add(*model_.loads, l, pose, applied.given[l]);
            for (int b = 0; b < model_.size(); ++b) solver.set_force(b, applied.force[b], applied.torque[b]);
            if (!solver.solve(none_.data(), lambda_.data())) return false;
            if (contacts.any()) contacts.add_reactions(false, lambda_);
            find_supports(pose, own_);
            const int by = model_.loads->laws[l].bearing;
            for (std::size_t k = 0; k < bearings; ++k) responses_[k][by].add(own_[k], 1.0);
        }
        return is_unique() && newton(applied.carried);
    }

private:
    void find_supports(const Pose<D>& pose, std::vector<Supports>& found) {
        found.clear();
        for (const Bearing<D>& bearing : model_.bearings)
            found.push_back(supports_of(model_, pose, bearing, lambda_.data()));
    }

    // Whether no loads grow by more than themselves: (I - K) x = 1 has a positive solution, K the largest growth of each load
    // with each other one. The load of a bearing that only pushes may shrink by any amount.
    bool is_unique() {
        const auto count = static_cast<Eigen::Index>(model_.bearings.size());
        Eigen::MatrixXd left = Eigen::MatrixXd::Identity(count, count);
        for (Eigen::Index k = 0; k < count; ++k)
            for (Eigen::Index j = 0; j < count; ++j) left(k, j) -= growth(k, j);
        const Eigen::VectorXd x = solved(left, Eigen::VectorXd::Ones(count));
        Eigen::Index worst = 0;
        if (x.allFinite() && x.minCoeff() > 0.0) return true;
        left.diagonal().minCoeff(&worst);
        jammed_ = laws_.front();
        for (const int l : laws_)
            if (model_.loads->laws[l].bearing == worst) jammed_ = l;
        return false;
    }

    double growth(Eigen::Index k, Eigen::Index j) const {
        const Bearing<D>& bearing = model_.bearings[k];
        if (bearing.is_push()) return std::max(base_[k].slope(bearing, responses_[k][j]), 0.0);
        return responses_[k][j].load(bearing);
    }

    bool newton(std::vector<double>& loads) {
        const auto count = static_cast<Eigen::Index>(model_.bearings.size());
        Eigen::VectorXd L = Eigen::VectorXd::Zero(count), off(count);
        Eigen::MatrixXd slope(count, count);
        for (int pass = 0; pass < model_.thresholds.most_passes; ++pass) {
            for (Eigen::Index k = 0; k < count; ++k) {
                const Bearing<D>& bearing = model_.bearings[k];
                Supports at = base_[k];
                for (Eigen::Index j = 0; j < count; ++j) at.add(responses_[k][j], L[j]);
                off[k] = L[k] - bearing.preload - at.load(bearing);
                for (Eigen::Index j = 0; j < count; ++j)
                    slope(k, j) = (k == j ? 1.0 : 0.0) - at.slope(bearing, responses_[k][j]);
            }
            const Eigen::VectorXd change = solved(slope, off);
            L -= change;
            if (!L.allFinite()) return false;
            if (change.cwiseAbs().maxCoeff() <= model_.thresholds.no_digits * L.cwiseAbs().maxCoeff()) break;
        }
        std::copy(L.begin(), L.end(), loads.begin());
        return true;
    }

    const Model<D>& model_;
    const std::vector<double> none_;
    std::vector<double> lambda_;
    std::vector<int> laws_;
    std::vector<Supports> base_, own_;
    std::vector<std::vector<Supports>> responses_;  // of each bearing to friction by a load of 1 on each
    int jammed_ = -1;
};

}  // namespace mbproj
