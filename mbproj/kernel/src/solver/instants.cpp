#include "solver/instants.hpp"

namespace mbproj {

void Instants::set_from_outside(double* y) {
    if (!from_outside_) return;
    for (const auto& [state, value] : *from_outside_) y[model_.layout.states.first + state] = value;
    from_outside_.reset();
}

void Instants::set_channels(double t, const double* y) {
    equations_.set_pose(t, y);
    equations_.set_velocities(y, false);
    variables_ = equations_.variables_at(t, y);
}

bool Instants::act(int number, double* y) {
    const Action& action = model_.actions[number];
    new_values_.clear();
    for (const int program : action.programs) {
        new_values_.push_back(model_.action_programs.value(program, variables_, nullptr));
        if (!std::isfinite(new_values_.back())) return equations_.broken(y);
    }
    for (std::size_t k = 0; k < new_values_.size(); ++k)
        y[model_.layout.states.first + action.states[k]] = new_values_[k];
    equations_.change_states(y);
    return true;
}

std::vector<double> Instants::values(const Programs& programs, double t, const double* y) {
    set_channels(t, y);
    std::vector<double> values;
    for (int k = 0; k < programs.size(); ++k) values.push_back(programs.value(k, variables_, nullptr));
    return values;
}

}  // namespace mbproj
