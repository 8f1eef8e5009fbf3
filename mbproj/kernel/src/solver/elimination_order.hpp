// The order of elimination, found once. First come the leaves of the joint graph, each with the joint on which it hangs. The
// loops are left, with all joints that are not hinges. Some of their bodies move by one of their hinges; none where rows are
// redundant, since the rows of such hinges may be the ones to leave out.
#pragma once

#include <queue>

#include "solver/choice_of_hinges.hpp"
#include "solver/hinge_flywheels.hpp"

namespace mbproj {

template <class D> struct Leaf {
    int joint;
    Hinge<D> hinge;
    std::vector<int>
        flywheels;  // joints of the flywheels that its free motions turn, and compliant joints of its coordinates
};

template <class D> struct EliminationOrder {
    std::vector<Leaf<D>> leaves;   // in the order of their elimination: children before their parents
    std::vector<int> loop_bodies;  // with the roots of floating trees
    std::vector<int> loop_joints;
    std::vector<LoopHinge<D>> loop_hinges;  // at most one for each of loop_bodies; their parents have none

    // Light bodies stay in the loops, where they can be lent inertia. So do bodies that are too heavy for their parents, and all
    // bodies where `eliminate` is false.
    EliminationOrder(const Model<D>& model, bool eliminate) {
        const int n = model.size();
        std::vector<std::vector<int>> joints_of(n);
        std::vector<std::vector<int>> flywheels_of(n);
        for (int j = 0; j < static_cast<int>(model.joints.size()); ++j)
            for (const int body : model.joints[j].bodies)
                (model.holds_flywheel(j) || model.is_compliant(j) ? flywheels_of : joints_of)[body].push_back(j);
        std::vector<bool> joint_left(model.joints.size(), true), body_left(n, true);
        std::vector<int> degree(n);
        std::queue<int> candidates;
        InertiaCancellation<D> cancellation(model);
        for (int b = n - 1; b >= 0; --b) {
            degree[b] = static_cast<int>(joints_of[b].size());
            if (degree[b] == 1 && eliminate) candidates.push(b);
        }
        while (!candidates.empty()) {
            const int body = candidates.front();
            candidates.pop();
            if (degree[body] != 1 || model.bodies[body].is_light) continue;
            int joint = -1;
            for (const int j : joints_of[body])
                if (joint_left[j]) joint = j;
            const auto hinge = as_hinge(model, model.joints[joint], body);
            if (!hinge || cancellation.cancels_parent_inertia(*hinge)) continue;
            std::vector<int> turned;
            for (const int j : flywheels_of[body])
                if (joint_left[j]) turned.push_back(j);
            if (!HingeFlywheels<D>::fit(model, *hinge, turned)) continue;
            cancellation.take_over(*hinge);
            for (const int j : turned) joint_left[j] = false;
            leaves.push_back({joint, *hinge, std::move(turned)});
            joint_left[joint] = body_left[body] = false;
            for (const int other : model.joints[joint].bodies)
                if (--degree[other] == 1 && other != body) candidates.push(other);
        }
        for (int b = 0; b < n; ++b)
            if (body_left[b]) loop_bodies.push_back(b);
        if (eliminate && model.rows.redundant == 0)
            loop_hinges = ChoiceOfHinges<D>(model, loop_bodies, cancellation).choose(joint_left);
        for (int j = 0; j < static_cast<int>(model.joints.size()); ++j)
            if (joint_left[j]) loop_joints.push_back(j);
    }
};

}  // namespace mbproj
