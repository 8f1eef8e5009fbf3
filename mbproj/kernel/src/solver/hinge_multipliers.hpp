// The right-hand sides and the multipliers of a hinge's rows.
#pragma once

#include "solver/hinge.hpp"

namespace mbproj {

// The smallest motion at the joint's point that meets the rows' right-hand sides.
template <class D> [[gnu::always_inline]] inline Column<Size<D>::freedoms, double>
particular(const Model<D>& model, const Hinge<D>& hinge, const HingeFrame<D>& frame, const double* c) {
    constexpr int F = Size<D>::freedoms, W = Size<D>::turns;
    const auto& instances = model.constraints.instances;
    Column<F> p = Column<F>::Zero();
    if (hinge.coincident) {
        p.template head<D::axes>() = matrix_at<D::axes>(c + instances[hinge.translations[0]].row);
    } else {
        for (int k = 0; k < hinge.translation_count; ++k)
            p.template head<D::axes>().add_multiple(c[instances[hinge.translations[k]].row], frame.P_t.col(k));
    }
    for (int k = 0; k < hinge.rotation_count; ++k)
        p.template tail<W>().add_multiple(c[instances[hinge.rotations[k]].row], frame.P_r.col(k));
    return hinge.sign * p;
}

// λ of a hinge's rows from the wrench that the joint exerts on the child, -Gᵀλ.
template <class D> void hinge_multipliers(const Model<D>& model, const Hinge<D>& hinge, const HingeFrame<D>& frame,
                                          const Column<Size<D>::freedoms, double>& wrench, double* lambda) {
    constexpr int W = Size<D>::turns;
    const auto& instances = model.constraints.instances;
    if (hinge.coincident) {
        matrix_at<D::axes>(lambda + instances[hinge.translations[0]].row) =
            -hinge.sign * wrench.template head<D::axes>();
    } else {
        for (int k = 0; k < hinge.translation_count; ++k)
            lambda[instances[hinge.translations[k]].row] =
                -hinge.sign * frame.P_t.col(k).dot(wrench.template head<D::axes>());
    }
    for (int k = 0; k < hinge.rotation_count; ++k)
        lambda[instances[hinge.rotations[k]].row] = -hinge.sign * frame.P_r.col(k).dot(wrench.template tail<W>());
}

}  // namespace mbproj
