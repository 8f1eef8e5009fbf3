// The states x of elements: x' = program(t, channels), one program each, in the order of their block of y.
#pragma once

#include <cmath>

#include "kinematics/channels.hpp"

namespace mbproj {

template <class D> class StateRates final {
public:
    const double* held = nullptr;  // the branches of programs, or none

    explicit StateRates(const Model<D>& model) : model_(model), block_(model.layout.states) {}

    bool any() const { return block_.size > 0; }
    // Writes x' to its block of a slope; false where a program has no finite value.
    bool set(Channels<D>& channels, Scalar<D>* slope) const {
        for (int k = 0; k < block_.size; ++k) {
            slope[block_.first + k] = model_.programs.value(model_.first_rate + k, channels.variables(), held);
            if (!isfinite(slope[block_.first + k])) return false;
        }
        return true;
    }
    // ∂x'/∂channel of state k.
    void slopes(int k, Channels<D>& channels, Scalar<D>* found) const {
        channels.variables();
        channels.slopes(model_.first_rate + k, held, law_variables, law_variables + channels.size(), found);
    }

private:
    const Model<D>& model_;
    const Block block_;
};

}  // namespace mbproj
