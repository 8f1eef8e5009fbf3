#include "step/mechanics.hpp"

#include "solver/newton_projector.hpp"
#include "step/explicit_runge_kutta.hpp"
#include "step/implicit_runge_kutta.hpp"
#include "step/kinematic_steps.hpp"

namespace mbproj {

namespace {

template <class D> class MechanicsOf final : public Mechanics {
public:
    MechanicsOf(Model<D> model, Tableau method, const ProjectionSettings& settings, double tolerance)
        : Mechanics(std::move(method), settings),
          model_(tableau.is_implicit() ? with_compliant_rows(std::move(model)) : std::move(model)),
          equations_(model_, projection), projector_(equations_, projection, phases), stepper_(stepper_of(tolerance)) {}

    Equations& equations() override { return equations_; }
    Projector& projector() override { return projector_; }
    Stepper& stepper() override { return *stepper_; }

private:
    std::unique_ptr<Stepper> stepper_of(double tolerance) {
        if (tableau.kinematic) return std::make_unique<KinematicSteps<D>>(tableau, equations_, projector_);
        if (tableau.is_implicit()) return std::make_unique<ImplicitRungeKutta<D>>(tableau, equations_, tolerance);
        return std::make_unique<ExplicitRungeKutta>(tableau, equations_);
    }

    const Model<D> model_;
    EquationsOfMotion<D> equations_;
    NewtonProjector<D> projector_;
    const std::unique_ptr<Stepper> stepper_;
};

}  // namespace

template <class D> std::unique_ptr<Mechanics> mechanics_of(Model<D> model, Tableau tableau,
                                                           const ProjectionSettings& projection, double tolerance) {
    return std::make_unique<MechanicsOf<D>>(std::move(model), std::move(tableau), projection, tolerance);
}

template std::unique_ptr<Mechanics> mechanics_of(Model<Plane<double>>, Tableau, const ProjectionSettings&, double);
template std::unique_ptr<Mechanics> mechanics_of(Model<Space<double>>, Tableau, const ProjectionSettings&, double);

}  // namespace mbproj
