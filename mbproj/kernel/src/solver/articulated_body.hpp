// The leaves of the joint graph are eliminated body by body. A parent feels a body that hangs on one joint as an articulated
// inertia (Featherstone 2008, ch. 7). Here the joint has a right-hand side of its own, so that the same elimination gives
// accelerations and both corrections.
#pragma once

#include "solver/hinge.hpp"

namespace mbproj {

// A symmetric inertia [A B; Bᵀ C] in (v, ω) at a reference point.
template <class D> struct Inertia {
    using S = Size<D>;
    Matrix<D::axes, D::axes> A;
    Matrix<D::axes, S::turns> B;
    Matrix<S::turns, S::turns> C;

    // m and J of a body whose centre of mass is at -s from the reference point.
    [[gnu::always_inline]] void set(double mass, const Matrix<S::turns, S::turns>& J, const Point<D>& s) {
        A = mass * Matrix<D::axes, D::axes>::Identity();
        for (int i = 0; i < D::axes; ++i) B.row(i) = moment(s, Point<D>(-mass * Point<D>::Unit(i))).transpose();
        C = J;
        for (int i = 0; i < S::turns; ++i) C.col(i) -= moment(s, Point<D>(B.col(i)));
    }
    // Changes the reference point: `arm` leads from the new one to the old one, v_old = v_new + ω × arm.
    [[gnu::always_inline]] void move(const Point<D>& arm) {
        for (int i = 0; i < S::turns; ++i) C.row(i) += moment(arm, Point<D>(B.col(i))).transpose();
        for (int i = 0; i < D::axes; ++i) B.row(i) += moment(arm, Point<D>(A.col(i))).transpose();
        for (int i = 0; i < S::turns; ++i) C.col(i) += moment(arm, Point<D>(B.col(i)));
    }
    void add_lent_inertia(const Column<S::freedoms>& diagonal) {
        A.diagonal() += diagonal.template head<D::axes>();
        C.diagonal() += diagonal.template tail<S::turns>();
    }
    void add(const Inertia& other) {
        A += other.A;
        B += other.B;
        C += other.C;
    }
    Column<S::freedoms> operator*(const Column<S::freedoms>& u) const {
        Column<S::freedoms> product;
        const auto v = u.template head<D::axes>();
        const auto w = u.template tail<S::turns>();
        product.template head<D::axes>() = A * v + B * w;
        product.template tail<S::turns>() = B.transpose() * v + C * w;
        return product;
    }
};

// One free motion of a hinge, a translation or a rotation along n, and the factors of its elimination.
template <class D> struct FreeMotion {
    Column<Size<D>::freedoms, double> U;  // M n
    double reciprocal;                    // 1 / nᵀ M n
};

// The elimination of one hinge, with its factors for the solution. The free motions are eliminated one by one, the translations
// first, as if massless bodies with one freedom each stood between child and parent.
template <class D> struct HingeFactor {
    using S = Size<D>;
    static constexpr int F = S::freedoms;
    HingeFrame<D> frame;
    Point<D> link;  // from the parent's reference point to this joint's
    Inertia<D> M;   // of the child with its leaves, at the joint's point
    FreeMotion<D> motions[F];

    // Turns M into the articulated inertia that the parent feels. False where a free motion has no inertia. `added`: the inertia
    // of the flywheels that each motion turns, or null.
    template <bool turns>
    [[gnu::always_inline]] bool eliminate(const Hinge<D>& hinge, Inertia<D>& left, const double* added) {
        left = M;
        FreeMotion<D>* motion = motions;
        for (int k = 0; k < hinge.free_translations(); ++k, ++motion) {
            const auto n = frame.N_t.col(k);
            motion->U.template head<D::axes>() = left.A * n;
            motion->U.template tail<S::turns>() = left.B.transpose() * n;
            double pivot = n.dot(motion->U.template head<D::axes>());
            if constexpr (turns) pivot += *added++;
            if (!remove(*motion, pivot, left)) return false;
        }
        for (int k = 0; k < hinge.free_rotations(); ++k, ++motion) {
            const auto n = frame.N_r.col(k);
            motion->U.template head<D::axes>() = left.B * n;
            motion->U.template tail<S::turns>() = left.C * n;
            double pivot = n.dot(motion->U.template tail<S::turns>());
            if constexpr (turns) pivot += *added++;
            if (!remove(*motion, pivot, left)) return false;
        }
        return true;
    }

    // h = nᵀ g / nᵀ M n of each free motion, and g less h U. `pushed`: the flywheels' part of nᵀ g.
    template <bool turns>
    [[gnu::always_inline]] void upward(const Hinge<D>& hinge, double* h, Column<F>& g, const double* pushed) const {
        const FreeMotion<D>* motion = motions;
        for (int k = 0; k < hinge.free_translations(); ++k, ++motion, ++h) {
            double along = frame.N_t.col(k).dot(g.template head<D::axes>());
            if constexpr (turns) along += *pushed++;
            *h = along * motion->reciprocal;
            g.add_multiple(-*h, motion->U);
        }
        for (int k = 0; k < hinge.free_rotations(); ++k, ++motion, ++h) {
            double about = frame.N_r.col(k).dot(g.template tail<S::turns>());
            if constexpr (turns) about += *pushed++;
            *h = about * motion->reciprocal;
            g.add_multiple(-*h, motion->U);
        }
    }

    // u = u_parent + Σ n z with z = h - Uᵀu / nᵀ M n, one free motion after another.
    [[gnu::always_inline]] void downward(const Hinge<D>& hinge, const double* h, Column<F>& u) const {
        int last = hinge.free_translations() + hinge.free_rotations() - 1;
        for (int k = hinge.free_rotations() - 1; k >= 0; --k, --last)
            u.template tail<S::turns>().add_multiple(h[last] - motions[last].reciprocal * motions[last].U.dot(u),
                                                     frame.N_r.col(k));
        for (int k = hinge.free_translations() - 1; k >= 0; --k, --last)
            u.template head<D::axes>().add_multiple(h[last] - motions[last].reciprocal * motions[last].U.dot(u),
                                                    frame.N_t.col(k));
    }

private:
    static bool remove(FreeMotion<D>& motion, double pivot, Inertia<D>& left) {
        if (!(pivot > 0.0)) return false;
        motion.reciprocal = 1.0 / pivot;
        const Column<F> V = motion.reciprocal * motion.U;
        for (int i = 0; i < D::axes; ++i) left.A.col(i).add_multiple(-motion.U[i], V.template head<D::axes>());
        for (int i = 0; i < S::turns; ++i) {
            left.B.col(i).add_multiple(-motion.U[D::axes + i], V.template head<D::axes>());
            left.C.col(i).add_multiple(-motion.U[D::axes + i], V.template tail<S::turns>());
        }
        return true;
    }
};

}  // namespace mbproj
