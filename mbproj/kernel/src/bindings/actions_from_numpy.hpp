// What controllers do, from Python.
#pragma once

#include "bindings/loads_from_numpy.hpp"

namespace mbproj {

// Pairs (state, program of this set) of each action.
using ActionNumbers = std::vector<std::vector<std::pair<int, int>>>;

template <class D> void set_actions(Model<D>& model, const ActionNumbers& given, const Programs& programs) {
    require_variables(programs, law_variables + static_cast<int>(model.channels.size()), "programs of actions");
    model.actions.clear();
    for (const auto& pairs : given) {
        Action action;
        for (const auto& [state, program] : pairs) {
            action.states.push_back(index_below(state, model.layout.states.size, "actions"));
            action.programs.push_back(index_below(program, programs.size(), "actions"));
        }
        model.actions.push_back(std::move(action));
    }
    model.action_programs = programs;
}

}  // namespace mbproj
