// Changes of elements' states at instants, by controllers and from outside, as in
// mbproj.integrate.point.
#pragma once

#include <optional>
#include <utility>

#include "dynamics/equations.hpp"

namespace mbproj {

class Instants final {
public:
    using Given = std::vector<std::pair<int, double>>;  // numbers of states, and their new values

    explicit Instants(Equations& equations) : model_(equations.mechanism()), equations_(equations) {}

    bool any_given() const { return given_.has_value(); }
    void give(Given states) { given_ = std::move(states); }
    void take_given(double* y) {
        if (!given_) return;
        for (const auto& [state, value] : *given_) y[model_.layout.states.first + state] = value;
        given_.reset();
    }
    // Sets the variables of controllers for y at t, before the first controller acts there.
    void set_channels(double t, const double* y) {
        equations_.set_pose(t, y);
        equations_.set_velocities(y, false);
        variables_ = equations_.variables_at(t, y);
    }
    // The action of a controller at y, for which the variables are set. False where a program has no finite value.
    bool act(int number, double* y) {
        const Action& action = model_.actions[number];
        found_.clear();
        for (const int program : action.programs) {
            found_.push_back(model_.action_programs.value(program, variables_, nullptr));
            if (!std::isfinite(found_.back())) return equations_.broken(y);
        }
        for (std::size_t k = 0; k < found_.size(); ++k) y[model_.layout.states.first + action.states[k]] = found_[k];
        equations_.change_states(y);
        return true;
    }
    // The values of programs of the time and channels for y at t.
    std::vector<double> values(const Programs& programs, double t, const double* y) {
        set_channels(t, y);
        std::vector<double> found;
        for (int k = 0; k < programs.size(); ++k) found.push_back(programs.value(k, variables_, nullptr));
        return found;
    }

private:
    const Mechanism& model_;
    Equations& equations_;
    const Series<double>* variables_ = nullptr;
    std::optional<Given> given_;
    std::vector<double> found_;  // the values that an action sets
};

}  // namespace mbproj
