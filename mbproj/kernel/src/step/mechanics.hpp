// What a run computes with: the equations of its model, the projection, and the method of its steps.
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
    Phases phases;

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
// `tolerance`: that of the steps' errors, or 0 where steps are fixed.
template <class D> std::unique_ptr<Mechanics> mechanics_of(Model<D> model, Tableau tableau,
                                                           const ProjectionSettings& projection, double tolerance);

}  // namespace mbproj
