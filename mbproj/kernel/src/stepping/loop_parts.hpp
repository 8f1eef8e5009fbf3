// What a time loop is made of, each after those that it needs.
#pragma once

#include "steppers/choice.hpp"
#include "stepping/step_trial.hpp"

namespace mbproj {

template <int D> class LoopParts {
public:
    LoopParts(const LoopParts&) = delete;
    LoopParts& operator=(const LoopParts&) = delete;

protected:
    LoopParts(Model<D> model, Tableau tableau, ProjectionSettings projection, Steps steps, const std::vector<double>& y)
        : model_(tableau.is_implicit() ? with_compliant_rows(std::move(model)) : std::move(model)),
          tableau_(std::move(tableau)), projection_(projection), steps_(std::move(steps)),
          equations_(model_, projection_), projector_(equations_, projection_, phases_),
          made_by_(stepper_of(tableau_, equations_, steps_.fixed() ? 0.0 : steps_.tolerance)), stepper_(*made_by_),
          turns_(model_, equations_, stepper_), step_end_(model_, equations_, projector_, turns_),
          schedule_(steps_), now_{steps_.start, 0.0, Eigen::Map<const Eigen::VectorXd>(y.data(), model_.layout.size()),
                                  Eigen::VectorXd::Zero(model_.layout.size())},
          trial_(steps_, now_, equations_, projector_, stepper_, step_end_, schedule_, phases_) {}
    ~LoopParts() = default;

    const Model<D> model_;
    const Tableau tableau_;
    const ProjectionSettings projection_;
    const Steps steps_;
    Phases phases_;
    EquationsOfMotion<D> equations_;
    Projector<D> projector_;
    const std::unique_ptr<Stepper<D>> made_by_;
    Stepper<D>& stepper_;
    TurnCounter<D> turns_;
    StepEnd<D> step_end_;
    Schedule schedule_;
    Standing now_;
    StepTrial<D> trial_;
};

}  // namespace mbproj
