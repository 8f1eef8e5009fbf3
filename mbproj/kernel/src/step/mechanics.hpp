// What a run computes with: the equations of its model, the projection onto C = 0 and G v = -C_t, and the method of its
// steps. The interface has no dimension: a run is compiled once for models in the plane and in space, whose classes are
// templates. mechanics.cpp joins both.
#pragma once

#include <memory>

#include "model/phase_times.hpp"
#include "solver/projector.hpp"
#include "step/stepper.hpp"

namespace mbproj {

class Mechanics {
public:
    const Tableau tableau;
    const ProjectionSettings projection;
    Phases phases;  // the time that each part of the steps takes

    Mechanics(const Mechanics&) = delete;
    Mechanics& operator=(const Mechanics&) = delete;
    virtual ~Mechanics() = default;
    virtual Equations& equations() = 0;
    virtual Projector& projector() = 0;
    virtual Stepper& stepper() = 0;

protected:
    Mechanics(Tableau method, const ProjectionSettings& settings) : tableau(std::move(method)), projection(settings) {}
};

template <class D> struct Model;
// The mechanics of a model with D axes. `tolerance`: that of the steps' errors, or 0 where steps are fixed.
template <class D> std::unique_ptr<Mechanics> mechanics_of(Model<D> model, Tableau tableau,
                                                           const ProjectionSettings& projection, double tolerance);

}  // namespace mbproj
