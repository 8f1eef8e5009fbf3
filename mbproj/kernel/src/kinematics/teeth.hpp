// Teeth and threads: a pose alone knows the row of a gear or screw but for whole ones; counted turns tell which. The
// definitions are those of mbproj.dynamics.equations.teeth.
#pragma once

#include "kinematics/pose.hpp"
#include "kinematics/primitives.hpp"

namespace mbproj {

template <int D> class Teeth final {
public:
    explicit Teeth(const Model<D>& model) : model_(model) {}

    // Notes what the sums of gears and screws count from, where a run begins: `expected` are the joints' coordinates, turns
    // counted, and `C` is to the nearest tooth.
    void start(const Pose<D>& pose, const std::vector<double>& expected, const double* C) {
        start_.clear();
        for (const Mesh& mesh : model_.meshes) start_.push_back(sum(mesh, pose, expected) - C[mesh.row]);
    }

    // The rows of gears and screws in C, from the nearest tooth on to the one in mesh; as they are before the start.
    void count(const Pose<D>& pose, const std::vector<double>& expected, double* C) const {
        for (std::size_t m = 0; m < start_.size(); ++m) {
            const Mesh& mesh = model_.meshes[m];
            const double apart = sum(mesh, pose, expected) - start_[m] - C[mesh.row];
            C[mesh.row] += mesh.period * std::nearbyint(apart / mesh.period);
        }
    }

private:
    // What the two coordinates come to, turns counted.
    double sum(const Mesh& mesh, const Pose<D>& pose, const std::vector<double>& expected) const {
        double total = 0.0;
        for (int side = 0; side < 2; ++side) {
            const int index = mesh.coordinates[side];
            const Instance& p = model_.coordinates.instances[index];
            Point<D> x[most_slots];
            for (int s = 0; s < p.slot_count; ++s) {
                const Attachment<D>& a = model_.coordinates.attachments[p.slots[s]];
                x[s] = pose[a.body].rotation * a.local;
                if (a.is_point) x[s] += pose[a.body].position;
            }
            const double found = value<D>(p, x);
            total += mesh.weights[side] * (model_.counts_turns[index] ? near(found, expected[index]) : found);
        }
        return total;
    }

    const Model<D>& model_;
    std::vector<double> start_;
};

}  // namespace mbproj
