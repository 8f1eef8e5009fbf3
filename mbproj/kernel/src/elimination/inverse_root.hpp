// The inverse of a body's inertia as a product, W⁻¹ = Z Zᵀ.
#pragma once

#include <Eigen/Cholesky>

#include "elimination/articulated_body.hpp"

namespace mbproj {

// W⁻¹ = Z Zᵀ of a body of the loops: of a bare one from the constant root of its inertia, of an articulated one by factorisation.
template <int D> class InverseRoot final {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;

    void bare(double mass, const Rotation<D>& A, const Matrix<S::turns, S::turns>& inverse_root) {
        is_bare_ = true;
        translation_ = 1.0 / std::sqrt(mass);
        if constexpr (D == 3)
            rotation_.noalias() = inverse_root * A.transpose();
        else
            rotation_ = inverse_root;
    }
    bool articulated(const Inertia<D>& M) {
        is_bare_ = false;
        Matrix<F, F> full;
        full.template topLeftCorner<D, D>() = M.A;
        full.template topRightCorner<D, S::turns>() = M.B;
        full.template bottomLeftCorner<S::turns, D>() = M.B.transpose();
        full.template bottomRightCorner<S::turns, S::turns>() = M.C;
        factor_.compute(full);
        return factor_.info() == Eigen::Success;
    }
    // Zᵀ x.
    void forward(Column<F>& x) const {
        if (is_bare_) {
            x.template head<D>() *= translation_;
            x.template tail<S::turns>() = rotation_ * x.template tail<S::turns>().eval();
        } else {
            factor_.matrixL().solveInPlace(x);
        }
    }
    // Z x.
    void backward(Column<F>& x) const {
        if (is_bare_) {
            x.template head<D>() *= translation_;
            x.template tail<S::turns>() = rotation_.transpose() * x.template tail<S::turns>().eval();
        } else {
            factor_.matrixU().solveInPlace(x);
        }
    }

private:
    bool is_bare_ = true;
    double translation_ = 0.0;
    Matrix<S::turns, S::turns> rotation_;
    Eigen::LLT<Matrix<F, F>> factor_;
};

}  // namespace mbproj
