// The leaves of the joint graph, children before their parents: their elimination and their solution.
#pragma once

#include "solver/elimination_order.hpp"
#include "solver/hinge_multipliers.hpp"

namespace mbproj {

template <class D> class Leaves final {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;
    using Wrench = Column<F>;

    Leaves(const Model<D>& model, const std::vector<Leaf<D>>& leaves)
        : model_(model), leaves_(leaves), factors_(leaves.size()), scratch_(leaves.size()) {
        for (std::size_t l = 0; l < leaves.size(); ++l)
            if (!leaves[l].flywheels.empty()) {
                scratch_[l].flywheels = static_cast<int>(flywheels_.size());
                flywheels_.emplace_back(leaves[l].hinge, leaves[l].flywheels);
            }
    }

    // Sets the hinges at a pose; the reference point of each child is its joint. Returns the joint whose rows are dependent, or
    // -1. Without `compliance` there are no stiff forces.
    int set_pose(const Pose<D>& pose, std::vector<Point<D>>& reference, const Compliance<D>* compliance) {
        for (std::size_t l = 0; l < factors_.size(); ++l) {
            HingeFrame<D>& frame = factors_[l].frame;
            if (!frame.update(model_, leaves_[l].hinge, pose)) return leaves_[l].joint;
            reference[leaves_[l].hinge.child] = frame.child_arm;
        }
        return flywheels_.empty() ? -1 : set_flywheels(pose, compliance);
    }

    // Adds the articulated inertias of the leaves to their parents, with the inertia of flywheels where they `turn`. Returns the
    // joint of a free motion without inertia, or -1.
    int factor(std::vector<Inertia<D>>& inertias, const std::vector<Point<D>>& reference, bool turn) {
        turn_ = turn && !flywheels_.empty();
        return turn_ ? factor_leaves<true>(inertias, reference) : factor_leaves<false>(inertias, reference);
    }

    // Solves from the leaves inwards: the forces on the leaves add to those on their parents.
    void solve_up(const double* c, std::vector<Wrench>& force) {
        of_flywheels_ = 0.0;
        turn_ ? solve_leaves_up<true>(c, force) : solve_leaves_up<false>(c, force);
    }
    // Solves outwards again, from the motions of the parents; multipliers on request.
    void solve_down(std::vector<Wrench>& delta, double* lambda) {
        turn_ ? solve_leaves_down<true>(delta, lambda) : solve_leaves_down<false>(delta, lambda);
    }

    // Σ I s'² of the flywheels in the last solution for velocities.
    double of_flywheels() const { return of_flywheels_; }

private:
    struct Scratch {
        Wrench g, p;  // the force less inertia times p; the particular motion
        double h[F];
        int flywheels = -1;  // its number among the leaves with flywheels, or -1
    };

    // The functions below are compiled twice, so that mechanisms without flywheels pay nothing for them.

    const HingeFlywheels<D>* flywheels_of(const Scratch& s) const {
        return s.flywheels >= 0 ? &flywheels_[s.flywheels] : nullptr;
    }

    int set_flywheels(const Pose<D>& pose, const Compliance<D>* compliance) {
        for (std::size_t l = 0; l < factors_.size(); ++l)
            if (const int f = scratch_[l].flywheels;
                f >= 0 && !flywheels_[f].update(model_, pose, factors_[l].frame, compliance))
                return leaves_[l].joint;
        return -1;
    }

    template <bool turns> int factor_leaves(std::vector<Inertia<D>>& inertias, const std::vector<Point<D>>& reference) {
        static const double nothing[F] = {};
        for (std::size_t l = 0; l < factors_.size(); ++l) {
            const Hinge<D>& hinge = leaves_[l].hinge;
            HingeFactor<D>& f = factors_[l];
            f.M = inertias[hinge.child];
            f.link = f.frame.parent_arm - reference[hinge.parent];
            const double* added = nothing;
            if constexpr (turns)
                if (const auto* flywheels = flywheels_of(scratch_[l])) added = flywheels->added();
            Inertia<D> left;
            if (!f.template eliminate<turns>(hinge, left, added)) return leaves_[l].joint;
            if (hinge.parent < model_.size()) {
                left.move(f.link);
                inertias[hinge.parent].add(left);
            }
        }
        return -1;
    }

    template <bool turns> void solve_leaves_up(const double* c, std::vector<Wrench>& force) {
        for (std::size_t l = 0; l < factors_.size(); ++l)
            up<turns>(leaves_[l].hinge, factors_[l], scratch_[l], c, force);
    }
    template <bool turns> void solve_leaves_down(std::vector<Wrench>& delta, double* lambda) {
        for (std::size_t l = factors_.size(); l-- > 0;)
            down<turns>(leaves_[l].hinge, factors_[l], scratch_[l], delta, lambda);
    }

    template <bool turns>
    void up(const Hinge<D>& hinge, const HingeFactor<D>& f, Scratch& s, const double* c, std::vector<Wrench>& force) {
        s.p = particular(model_, hinge, f.frame, c);
        s.g = force[hinge.child] - f.M * s.p;
        Wrench rest = s.g;
        double pushed[F] = {};
        if constexpr (turns)
            if (const auto* flywheels = flywheels_of(s)) flywheels->push(c, s.p, pushed);
        f.template upward<turns>(hinge, s.h, rest, pushed);
        rest.template tail<S::turns>() += moment(f.link, Point<D>(rest.template head<D::axes>()));
        force[hinge.parent] += rest;
    }

    template <bool turns> void down(const Hinge<D>& hinge, const HingeFactor<D>& f, const Scratch& s,
                                    std::vector<Wrench>& delta, double* lambda) {
        Wrench u = delta[hinge.parent];
        u.template head<D::axes>() += turned_by(Turn<D>(u.template tail<S::turns>()), f.link);
        f.downward(hinge, s.h, u);
        if (lambda || turns) {
            Wrench wrench = f.M * u - s.g;
            if constexpr (turns)
                if (const auto* flywheels = flywheels_of(s))
                    wrench -= flywheels->pull(f.frame, wrench, lambda, of_flywheels_);
            if (lambda) hinge_multipliers<D>(model_, hinge, f.frame, wrench, lambda);
        }
        delta[hinge.child] = u + s.p;
    }

    const Model<D>& model_;
    const std::vector<Leaf<D>>& leaves_;
    std::vector<HingeFactor<D>> factors_;
    std::vector<Scratch> scratch_;
    std::vector<HingeFlywheels<D>> flywheels_;  // of the leaves with flywheels
    double of_flywheels_ = 0.0;
    bool turn_ = true;
};

}  // namespace mbproj
