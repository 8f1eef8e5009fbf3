// The inverse of a body's inertia as a product, W⁻¹ = Z Zᵀ.
#pragma once

#include "model/cholesky.hpp"
#include "solver/loop_hinge.hpp"

namespace mbproj {

// W⁻¹ = Z Zᵀ of a body of the loops. A body without leaves uses the constant root of its inertia, an articulated one a
// factorisation. A body that moves by a hinge N has (NᵀWN)⁻¹ Nᵀ: Z has a column for each free motion.
template <class D> class InverseRoot final {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;

    void bare(double mass, const Rotation<D>& A, const Matrix<S::turns, S::turns>& inverse_root) {
        kind_ = Kind::bare;
        translation_ = 1.0 / sqrt(mass);
        if constexpr (D::axes == 3)
            rotation_ = inverse_root * A.transpose();
        else
            rotation_ = inverse_root;
    }
    bool articulated(const Inertia<D>& M) {
        kind_ = Kind::articulated;
        Matrix<F, F> full;
        full.template block<D::axes, D::axes>(0, 0) = M.A;
        full.template block<D::axes, S::turns>(0, D::axes) = M.B;
        full.template block<S::turns, D::axes>(D::axes, 0) = M.B.transpose();
        full.template block<S::turns, S::turns>(D::axes, D::axes) = M.C;
        return factor_.factor(full);
    }
    // Gram-Schmidt orthogonalisation in the inertia M. False where a free motion has no inertia.
    bool hinged(const LoopHinge<D>& hinge, const Inertia<D>& M) {
        kind_ = Kind::hinged;
        width_ = hinge.freedoms();
        for (int k = 0; k < width_; ++k) {
            Column<F> z = hinge.free_motion(k);
            for (int j = 0; j < k; ++j) z.add_multiple(-momenta_[j].dot(z), motions_[j]);
            momenta_[k] = M * z;
            const double moved = z.dot(momenta_[k]);
            if (!(moved > 0.0)) return false;
            const double scale = 1.0 / sqrt(moved);
            motions_[k] = scale * z;
            momenta_[k] *= scale;
        }
        free_ = {D::axes / M.A.trace(), S::turns / M.C.trace()};
        return true;
    }

    // The number of entries of Zᵀx that can differ from 0.
    int width() const { return kind_ == Kind::hinged ? width_ : F; }
    // An estimate of |Zᵀx|² for the body without its hinge.
    double free_square(const Column<F>& x) const {
        return free_.translation * x.template head<D::axes>().squaredNorm() +
               free_.rotation * x.template tail<S::turns>().squaredNorm();
    }
    // Entry k of Zᵀ x; the entries from `width` on are 0.
    double entry(int k, const Column<F>& x) const { return motions_[k].dot(x); }
    void forward(Column<F>& x) const {
        if (kind_ == Kind::hinged) {
            const Column<F> given = x;
            x.setZero();
            for (int k = 0; k < width_; ++k) x[k] = entry(k, given);
        } else if (kind_ == Kind::bare) {
            x.template head<D::axes>() *= translation_;
            x.template tail<S::turns>() = rotation_ * x.template tail<S::turns>().eval();
        } else {
            factor_.forward(x);
        }
    }
    // For a hinged body: removes from a force, given Zᵀ f, and from W what its free motions take; its parent feels the
    // rest.
    void remove(const Column<F>& coordinates, Column<F>& force) const {
        for (int k = 0; k < width_; ++k) force.add_multiple(-coordinates[k], momenta_[k]);
    }
    void remove(Inertia<D>& W) const {
        for (int k = 0; k < width_; ++k) {
            const Column<D::axes> linear = momenta_[k].template head<D::axes>();
            const Column<S::turns> angular = momenta_[k].template tail<S::turns>();
            for (int i = 0; i < D::axes; ++i) W.A.col(i).add_multiple(-linear[i], linear);
            for (int i = 0; i < S::turns; ++i) {
                W.B.col(i).add_multiple(-angular[i], linear);
                W.C.col(i).add_multiple(-angular[i], angular);
            }
        }
    }
    // Removes the motion along the hinge from a motion with the parent: x becomes x - Z Zᵀ W x.
    void hold(Column<F>& x) const {
        for (int k = 0; k < width_; ++k) x.add_multiple(-momenta_[k].dot(x), motions_[k]);
    }
    // Zᵀ (x - W p).
    void forward(Column<F>& x, const Column<F>& p) const {
        const Column<F> given = x;
        x.setZero();
        for (int k = 0; k < width_; ++k) x[k] = motions_[k].dot(given) - momenta_[k].dot(p);
    }
    // Z x.
    void backward(Column<F>& x) const {
        if (kind_ == Kind::hinged) {
            const Column<F> given = x;
            x.setZero();
            for (int k = 0; k < width_; ++k) x.add_multiple(given[k], motions_[k]);
        } else if (kind_ == Kind::bare) {
            x.template head<D::axes>() *= translation_;
            x.template tail<S::turns>() = rotation_.transpose() * x.template tail<S::turns>().eval();
        } else {
            factor_.backward(x);
        }
    }

private:
    enum class Kind { bare, articulated, hinged };
    Kind kind_ = Kind::bare;
    double translation_ = 0.0;
    Matrix<S::turns, S::turns> rotation_;
    Cholesky<F, double> factor_;
    int width_ = 0;
    Column<F> motions_[F], momenta_[F];  // Z and W Z
    struct {
        double translation, rotation;
    } free_ = {1.0, 1.0};  // about 1 / m and 1 / J of a hinged body
};

}  // namespace mbproj
