// Bodies without mass, or without inertia about some axis. The equations have a unique solution all the same where no
// motion that the joints leave free goes without mass (Eq. 20). Their own W has no inverse, so a little mass is lent to
// them, and taken back by iteration: with (W + T) δ⁺ + Gᵀλ⁺ = f + T δ, whose fixed point does not hold T (the proximal
// point method, Rockafellar 1976). The error falls by about T over what moves with the body, each pass.
#pragma once

#include "model/model.hpp"

namespace mbproj {

template <class D> struct Light {
    using Twist = Column<Size<D>::freedoms, Scalar<D>>;
    int body;                      // of the loops
    Twist lent = Twist::Zero();    // T, diagonal
    Twist moved = Twist::Zero();   // δ of the last pass,
    Twist change = Twist::Zero();  // and by how much it differs from the one before
};

template <class D> Column<Size<D>::freedoms, Scalar<D>> lent_mass(const Model<D>& model) {
    Scalar<D> mass = 0.0;
    int heavy = 0;
    for (const Body<D>& body : model.bodies)
        if (body.mass > 0.0) {
            mass += body.mass;
            ++heavy;
        }
    const Scalar<D> mean = heavy ? mass / heavy : 1.0, lent_part = model.thresholds.lent_part;
    Column<Size<D>::freedoms, Scalar<D>> lent;
    lent.template head<D::axes>().setConstant(lent_part * mean);
    lent.template tail<Size<D>::turns>().setConstant(lent_part * mean * model.length * model.length);
    return lent;
}

}  // namespace mbproj
