// The stepper of a tableau.
#pragma once

#include "steppers/explicit_runge_kutta.hpp"
#include "steppers/implicit_runge_kutta.hpp"

namespace mbproj {

template <int D>
std::unique_ptr<Stepper<D>> stepper_of(const Tableau& tableau, EquationsOfMotion<D>& equations, double tolerance) {
    if (tableau.is_implicit()) return std::make_unique<ImplicitRungeKutta<D>>(tableau, equations, tolerance);
    return std::make_unique<ExplicitRungeKutta<D>>(tableau, equations);
}

}  // namespace mbproj
