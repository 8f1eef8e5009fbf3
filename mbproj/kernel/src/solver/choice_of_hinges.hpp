// Chooses the bodies of the loops that move by a hinge: first those that one hinge joins to the ground; then those between two
// joints, from a parent that moves by no hinge. The other rows of such a body pass on to its parent, where they couple no more
// rows than the elimination of the hinge's own rows would.
#pragma once

#include "solver/inertia_cancellation.hpp"
#include "solver/loop_hinge.hpp"

namespace mbproj {

template <class D> class ChoiceOfHinges final {
public:
    ChoiceOfHinges(const Model<D>& model, const std::vector<int>& loop_bodies, InertiaCancellation<D>& cancellation)
        : model_(model), loop_bodies_(loop_bodies), cancellation_(cancellation), joints_of_(model.size()),
          moves_(model.size()), carries_(model.size() + 1) {}

    // Chooses hinges among the joints in `joint_left`, and removes them there. Light bodies have none (light_body.hpp).
    std::vector<LoopHinge<D>> choose(std::vector<bool>& joint_left) {
        for (int j = 0; j < static_cast<int>(model_.joints.size()); ++j)
            if (joint_left[j])
                for (const int body : model_.joints[j].bodies) joints_of_[body].push_back(j);
        for (const bool from_ground : {true, false})
            for (const int body : loop_bodies_)
                if (!model_.bodies[body].is_light && !moves_[body] && !carries_[body])
                    if (const auto hinge = hinge_of(body, from_ground)) joint_left[hinge->joint()] = false;
        return std::move(chosen_);
    }

private:
    const LoopHinge<D>* hinge_of(int body, bool from_ground) {
        if (!from_ground && joints_of_[body].size() != 2) return nullptr;
        for (const int j : joints_of_[body]) {
            if (model_.holds_flywheel(j) || model_.is_compliant(j)) continue;
            const auto hinge = as_hinge(model_, model_.joints[j], body);
            if (!hinge || (hinge->parent == model_.size()) != from_ground) continue;
            if (hinge->taken() < (from_ground ? LoopHinge<D>::fewest_taken : model_.thresholds.fewest_passed)) continue;
            if (!from_ground && !can_carry(*hinge)) continue;
            cancellation_.take_over(*hinge);
            moves_[body] = carries_[hinge->parent] = true;
            chosen_.emplace_back(j, *hinge);
            return &chosen_.back();
        }
        return nullptr;
    }
    bool can_carry(const Hinge<D>& hinge) const {
        return !moves_[hinge.parent] && !model_.bodies[hinge.parent].is_light &&
               !cancellation_.cancels_parent_inertia(hinge);
    }

    const Model<D>& model_;
    const std::vector<int>& loop_bodies_;
    InertiaCancellation<D>& cancellation_;
    std::vector<std::vector<int>> joints_of_;
    std::vector<bool> moves_, carries_;
    std::vector<LoopHinge<D>> chosen_;
};

}  // namespace mbproj
