// Bodies without mass, or without inertia about some axis. The equations still have a unique solution where every motion that the
// joints allow moves some mass (Eq. 20). The body's own W has no inverse. So a little inertia T is lent to it, and an iteration
// takes it back: (W + T) δ⁺ + Gᵀλ⁺ = f + T δ, whose fixed point does not contain T (the proximal point method, Rockafellar 1976).
// Each pass reduces the error by about T over the inertia that moves with the body.
#pragma once

#include "model/model.hpp"

namespace mbproj {

template <class D> struct Light {
    using Twist = Column<Size<D>::freedoms, double>;
    int body;                      // its number in the loops
    Twist lent = Twist::Zero();    // T, diagonal
    Twist moved = Twist::Zero();   // δ of the last pass,
    Twist change = Twist::Zero();  // and its change from the pass before
};

template <class D> Column<Size<D>::freedoms, double> lent_mass(const Model<D>& model) {
    double mass = 0.0;
    int heavy = 0;
    for (const Body<D>& body : model.bodies)
        if (body.mass > 0.0) {
            mass += body.mass;
            ++heavy;
        }
    const double mean = heavy ? mass / heavy : 1.0, lent_part = model.thresholds.lent_part;
    Column<Size<D>::freedoms, double> lent;
    lent.template head<D::axes>().setConstant(lent_part * mean);
    lent.template tail<Size<D>::turns>().setConstant(lent_part * mean * model.length * model.length);
    return lent;
}

}  // namespace mbproj
