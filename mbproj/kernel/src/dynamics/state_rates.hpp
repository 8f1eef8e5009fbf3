// The states x of elements: x' = program(t, x), one program each, in the order of their block of y.
#pragma once

#include <cmath>
#include <vector>

#include "model/model.hpp"

namespace mbproj {

template <int D> class StateRates final {
public:
    explicit StateRates(const Model<D>& model)
        : programs_(model.rates.get()), block_(model.layout.states), variables_(1 + block_.size) {}

    bool any() const { return block_.size > 0; }
    // x' in its block of a slope, at y at t; false where a program has no finite value.
    bool set(double t, const double* y, double* slope) {
        variables_[0] = {t, 1.0, 0.0};
        for (int k = 0; k < block_.size; ++k) variables_[1 + k] = {y[block_.first + k], 0.0, 0.0};
        for (int k = 0; k < block_.size; ++k) {
            const double rate = programs_->run(k, variables_.data()).x;
            if (!std::isfinite(rate)) return false;
            slope[block_.first + k] = rate;
        }
        return true;
    }

private:
    const Programs* programs_;
    const Block block_;
    std::vector<Series> variables_;
};

}  // namespace mbproj
