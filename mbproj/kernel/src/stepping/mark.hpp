// A state between two steps from which a run can go on, with all that the next step depends on.
#pragma once

#include "contacts/contact_state.hpp"
#include "projection/projector.hpp"
#include "stepping/samples.hpp"
#include "stepping/schedule.hpp"
#include "stepping/state_events.hpp"
#include "stepping/step_size_control.hpp"
#include "stepping/turn_counter.hpp"

namespace mbproj {

struct Mark {
    double t = 0.0;
    double h = 0.0;       // of the next step
    long grid = 0;        // fixed steps made
    long part = 1;        // the next part of a step, see schedule.hpp
    bool shaped = false;  // whether the run's end has limited a step
    bool anew = false;    // another method goes on from here: its slope is evaluated
    int shortened = 0;    // how often the current step was shortened near a singular pose
    Eigen::VectorXd y;
    Eigen::VectorXd slope;  // with which the next step begins, where it is not a function of y; else none
    TurnCounter::Counted counted;
    StepSizeControl::Saved control{};
    SavedEvents events;
    std::optional<ContactState> contacts;  // where this loop decides them
    std::vector<Halved> halved;
    std::optional<Kept> kept;   // where rows hold conserved quantities
    std::vector<double> other;  // the numbers of another formulation, if one is followed
    Counters counters;
    Peaks peaks;
};

}  // namespace mbproj
