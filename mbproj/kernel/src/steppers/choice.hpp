// The stepper of a tableau.
#pragma once

#include "steppers/diagonally_implicit.hpp"
#include "steppers/explicit_runge_kutta.hpp"

namespace mbproj {

template <int D> std::unique_ptr<Stepper<D>> stepper_of(const Tableau& tableau, EquationsOfMotion<D>& equations,
                                                        double length, double tolerance) {
    if (tableau.is_implicit()) return std::make_unique<DiagonallyImplicit<D>>(tableau, equations, length, tolerance);
    return std::make_unique<ExplicitRungeKutta<D>>(tableau, equations, length);
}

}  // namespace mbproj
