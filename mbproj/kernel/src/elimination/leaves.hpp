// The leaves of the graph of joints: eliminated one after another, children before their parents, and solved for.
#pragma once

#include "elimination/elimination_order.hpp"
#include "elimination/hinge_multipliers.hpp"

namespace mbproj {

template <int D> class Leaves final {
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

    // The hinges at a pose; each child's reference point is its joint. The joint whose rows are dependent, or -1.
    int set_pose(const Pose<D>& pose, std::vector<Point<D>>& reference) {
        for (std::size_t l = 0; l < factors_.size(); ++l) {
            HingeFrame<D>& frame = factors_[l].frame;
            if (!frame.update(model_, leaves_[l].hinge, pose)) return leaves_[l].joint;
            if (const int f = scratch_[l].flywheels; f >= 0 && !flywheels_[f].update(model_, pose, frame))
                return leaves_[l].joint;
            reference[leaves_[l].hinge.child] = frame.child_arm;
        }
        return -1;
    }

    // Adds what parents feel of their leaves to their inertias, with that of flywheels where they `turn`. The joint of
    // which a free motion moves no mass, or -1.
    int factor(std::vector<Inertia<D>>& inertias, const std::vector<Point<D>>& reference, bool turn) {
        turn_ = turn;
        for (std::size_t l = 0; l < factors_.size(); ++l) {
            const Hinge<D>& hinge = leaves_[l].hinge;
            HingeFactor<D>& f = factors_[l];
            f.M = inertias[hinge.child];
            f.link = f.frame.parent_arm - reference[hinge.parent];
            Inertia<D> left;
            const HingeFlywheels<D>* flywheels = turning(scratch_[l]);
            if (!(flywheels ? f.template eliminate<true>(hinge, left, flywheels->added())
                            : f.template eliminate<false>(hinge, left)))
                return leaves_[l].joint;
            if (hinge.parent < model_.size()) {
                left.move(f.link);
                inertias[hinge.parent].add(left);
            }
        }
        return -1;
    }

    // From the leaves inwards: the forces on parents gain those on their leaves.
    void solve_up(const double* c, std::vector<Wrench>& force) {
        of_flywheels_ = 0.0;
        for (std::size_t l = 0; l < factors_.size(); ++l) up(leaves_[l].hinge, factors_[l], scratch_[l], c, force);
    }
    // And back, from the motions of the parents; multipliers on request.
    void solve_down(std::vector<Wrench>& delta, double* lambda) {
        for (std::size_t l = factors_.size(); l-- > 0;) down(leaves_[l].hinge, factors_[l], scratch_[l], delta, lambda);
    }

    // Σ I s'² of the flywheels, of the last solution for velocities.
    double of_flywheels() const { return of_flywheels_; }

private:
    struct Scratch {
        Wrench g, p;  // force less inertia times p; the particular motion
        double h[F];
        int flywheels = -1;  // its number among the leaves that have any
    };

    // The flywheels of a leaf; none where nothing turns them.
    const HingeFlywheels<D>* turning(const Scratch& s) const {
        return turn_ && s.flywheels >= 0 ? &flywheels_[s.flywheels] : nullptr;
    }

    void up(const Hinge<D>& hinge, const HingeFactor<D>& f, Scratch& s, const double* c, std::vector<Wrench>& force) {
        s.p = particular(model_, hinge, f.frame, c);
        s.g = force[hinge.child] - f.M * s.p;
        Wrench rest = s.g;
        if (const auto* flywheels = turning(s)) {
            double pushed[F];
            flywheels->push(c, s.p, pushed);
            f.template upward<true>(hinge, s.h, rest, pushed);
        } else {
            f.template upward<false>(hinge, s.h, rest);
        }
        rest.template tail<S::turns>() += moment(f.link, Point<D>(rest.template head<D>()));
        force[hinge.parent] += rest;
    }

    void down(const Hinge<D>& hinge, const HingeFactor<D>& f, const Scratch& s, std::vector<Wrench>& delta,
              double* lambda) {
        Wrench u = delta[hinge.parent];
        u.template head<D>() += turned_by(Turn<D>(u.template tail<S::turns>()), f.link);
        f.downward(hinge, s.h, u);
        if (const auto* flywheels = turning(s)) {
            const Wrench wrench = f.M * u - s.g;
            const Wrench pull = flywheels->pull(f.frame, wrench, lambda, of_flywheels_);
            if (lambda) hinge_multipliers<D>(model_, hinge, f.frame, wrench - pull, lambda);
        } else if (lambda) {
            hinge_multipliers<D>(model_, hinge, f.frame, f.M * u - s.g, lambda);
        }
        delta[hinge.child] = u + s.p;
    }

    const Model<D>& model_;
    const std::vector<Leaf<D>>& leaves_;
    std::vector<HingeFactor<D>> factors_;
    std::vector<Scratch> scratch_;
    std::vector<HingeFlywheels<D>> flywheels_;  // of the leaves that have any
    double of_flywheels_ = 0.0;
    bool turn_ = true;
};

}  // namespace mbproj
