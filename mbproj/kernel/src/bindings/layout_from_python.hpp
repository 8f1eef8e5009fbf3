// The layout of y from Python's record, checked against the model; and the actions of controllers on states.
#pragma once

#include <nanobind/stl/string.h>

#include <algorithm>
#include <string>
#include <tuple>

#include "bindings/loads_from_numpy.hpp"
#include "model/layout.hpp"

namespace mbproj {

// The name of a block, the magnitudes to which the absolute tolerance is relative, and its values at the start, or nothing.
using BlockNumbers = std::tuple<std::string, std::vector<double>, std::vector<double>>;

inline Layout layout_of(const std::vector<BlockNumbers>& blocks) {
    Layout built;
    bool controlled = true;
    for (const auto& [name, scale, start] : blocks) {
        Block* const place = name == "bodies"        ? &built.bodies
                             : name == "states"      ? &built.states
                             : name == "quadratures" ? &built.quadratures
                             : name == "followed"    ? &built.followed
                                                     : nullptr;
        if (!place || place->size > 0) refuse("layout", "has a block that is not known");
        if (!start.empty() && start.size() != scale.size()) refuse("layout", "has a block that begins with others");
        *place = {built.size(), static_cast<int>(scale.size())};
        for (std::size_t i = 0; i < scale.size(); ++i) {
            built.start.push_back(start.empty() ? 0.0 : start[i]);
            if (!std::isfinite(built.start.back()) || !(scale[i] > 0.0)) refuse("layout", "holds a wrong number");
            if (!std::isfinite(scale[i]))
                controlled = false;
            else if (!controlled)
                refuse("layout", "has controlled blocks after others");
            else
                built.scale.push_back(scale[i]);
        }
    }
    return built;
}

// Sets the layout, once the rest of the model is complete.
template <class D> void set_layout(Record& given, Model<D>& model) {
    const Layout layout = layout_of(given.take<std::vector<BlockNumbers>>("layout"));
    const auto expect = [](const Block& block, std::size_t size) {
        if (static_cast<std::size_t>(block.size) != size) refuse("layout", "has a block of a wrong size");
    };
    int apart = 0;
    if (model.loads)
        for (const Law<D>& law : model.loads->laws) apart = std::max(apart, law.apart + 1);
    const bool asked = layout.followed.size > 0;
    if (!asked && (!model.couplings.empty() || has_angles(model.loads.get())))
        refuse("layout", "does not follow the angles");
    if (layout.bodies.first != 0) refuse("layout", "does not begin with the bodies");
    expect(layout.bodies, static_cast<std::size_t>(Size<D>::state) * model.bodies.size());
    expect(layout.states, model.programs.size() - model.driven.size() - model.curves.size() - model.first_rate);
    expect(layout.quadratures, model.loads || !model.driven.empty() ? 2 + apart : 0);
    expect(layout.followed, asked ? model.coordinates.instances.size() : 0);
    model.layout = layout;
}

// Pairs (state, program of this set) of each action.
using ActionNumbers = std::vector<std::vector<std::pair<int, int>>>;

template <class D> void add_actions(Record& given, Model<D>& model) {
    if (!given.has("actions")) return;
    const Programs& programs = given.object<Programs>("action_programs");
    require_variables(programs, law_variables + static_cast<int>(model.channels.size()), "programs of actions");
    for (const auto& pairs : given.take<ActionNumbers>("actions")) {
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
