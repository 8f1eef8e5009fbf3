// The stepper of a tableau.
#pragma once

#include "steppers/explicit_runge_kutta.hpp"
#include "steppers/implicit_runge_kutta.hpp"
#include "steppers/kinematic_steps.hpp"

namespace mbproj {

template <class D> std::unique_ptr<Stepper<D>> stepper_of(const Tableau& tableau, EquationsOfMotion<D>& equations,
                                                          Projector<D>& projector, double tolerance) {
    if (tableau.kinematic) return std::make_unique<KinematicSteps<D>>(tableau, equations, projector);
    if (tableau.is_implicit()) return std::make_unique<ImplicitRungeKutta<D>>(tableau, equations, tolerance);
    return std::make_unique<ExplicitRungeKutta<D>>(tableau, equations);
}

}  // namespace mbproj
