// The states x of elements: x' = program(t, channels), one program each, in the order of their block of y.
#pragma once

#include <cmath>

#include "algebra/decompositions.hpp"
#include "kinematics/channels.hpp"

namespace mbproj {

template <int D> class StateRates final {
public:
    const double* held = nullptr;  // the branches of programs, or none

    explicit StateRates(const Model<D>& model) : model_(model), block_(model.layout.states) {}

    bool any() const { return block_.size > 0; }
    // x' in its block of a slope; false where a program has no finite value.
    bool set(Channels<D>& channels, double* slope) const {
        for (int k = 0; k < block_.size; ++k) {
            slope[block_.first + k] = model_.programs.value(model_.first_rate + k, channels.variables(), held);
            if (!std::isfinite(slope[block_.first + k])) return false;
        }
        return true;
    }
    // ∂x'/∂channel of state k.
    void slopes(int k, Channels<D>& channels, double* found) const {
        channels.variables();
        channels.slopes(model_.programs, model_.first_rate + k, held, law_variables, law_variables + channels.size(),
                        found);
    }

    // (I - g f_x)⁻¹ e of the block of e; what has no slope counts as constant.
    void eliminate(Channels<D>& channels, double g, double* e) const {
        if (!any()) return;
        Eigen::MatrixXd left = Eigen::MatrixXd::Identity(block_.size, block_.size);
        std::vector<double> by_channels(channels.size());
        for (int k = 0; k < block_.size; ++k) {
            slopes(k, channels, by_channels.data());
            for (std::size_t c = 0; c < by_channels.size(); ++c)
                if (model_.channels[c].kind == ChannelKind::state && std::isfinite(by_channels[c]))
                    left(k, model_.channels[c].index) -= g * by_channels[c];
        }
        Eigen::Map<Eigen::VectorXd> own(e + block_.first, block_.size);
        own = solved(left, own);
    }

private:
    const Model<D>& model_;
    const Block block_;
};

}  // namespace mbproj
