// The inverse of a body's inertia as a product, W⁻¹ = Z Zᵀ.
#pragma once

#include "algebra/cholesky.hpp"
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
            rotation_ = inverse_root * A.transpose();
        else
            rotation_ = inverse_root;
    }
    bool articulated(const Inertia<D>& M) {
        is_bare_ = false;
        Matrix<F, F> full;
        full.template block<D, D>(0, 0) = M.A;
        full.template block<D, S::turns>(0, D) = M.B;
        full.template block<S::turns, D>(D, 0) = M.B.transpose();
        full.template block<S::turns, S::turns>(D, D) = M.C;
        return factor_.factor(full);
    }
    // Zᵀ x.
    void forward(Column<F>& x) const {
        if (is_bare_) {
            x.template head<D>() *= translation_;
            x.template tail<S::turns>() = rotation_ * x.template tail<S::turns>().eval();
        } else {
            factor_.forward(x);
        }
    }
    // Z x.
    void backward(Column<F>& x) const {
        if (is_bare_) {
            x.template head<D>() *= translation_;
            x.template tail<S::turns>() = rotation_.transpose() * x.template tail<S::turns>().eval();
        } else {
            factor_.backward(x);
        }
    }

private:
    bool is_bare_ = true;
    double translation_ = 0.0;
    Matrix<S::turns, S::turns> rotation_;
    Cholesky<F> factor_;
};

}  // namespace mbproj
