// The states x of elements: x' = program(t, x), one program each, in the order of their block of y.
#pragma once

#include <cmath>
#include <vector>

#include "algebra/decompositions.hpp"
#include "model/model.hpp"

namespace mbproj {

template <int D> class StateRates final {
public:
    explicit StateRates(const Model<D>& model)
        : programs_(model.rates.get()), block_(model.layout.states), variables_(1 + block_.size) {}

    bool any() const { return block_.size > 0; }
    // x' in its block of a slope, at y at t; false where a program has no finite value.
    bool set(double t, const double* y, double* slope) {
        place(t, y);
        for (int k = 0; k < block_.size; ++k) {
            const double rate = programs_->run(k, variables_.data()).x;
            if (!std::isfinite(rate)) return false;
            slope[block_.first + k] = rate;
        }
        return true;
    }

    // (I - g f_x)⁻¹ e of the block of e, f_x at y at t; what has no slope there counts as constant.
    void eliminate(double t, const double* y, double g, double* e) {
        if (!any()) return;
        place(t, y);
        Eigen::MatrixXd left = Eigen::MatrixXd::Identity(block_.size, block_.size);
        for (int j = 0; j < block_.size; ++j) {
            variables_[1 + j].d = 1.0;
            for (int k = 0; k < block_.size; ++k)
                if (const double slope = programs_->run(k, variables_.data()).d; std::isfinite(slope))
                    left(k, j) -= g * slope;
            variables_[1 + j].d = 0.0;
        }
        Eigen::Map<Eigen::VectorXd> own(e + block_.first, block_.size);
        own = solved(left, own);
    }

private:
    void place(double t, const double* y) {
        variables_[0] = {t, 0.0, 0.0};
        for (int k = 0; k < block_.size; ++k) variables_[1 + k] = {y[block_.first + k], 0.0, 0.0};
    }

    const Programs* programs_;
    const Block block_;
    std::vector<Series> variables_;
};

}  // namespace mbproj
