#include "solver/instants.hpp"

namespace mbproj {

void Instants::take_given(double* y) {
    if (!given_) return;
    for (const auto& [state, value] : *given_) y[model_.layout.states.first + state] = value;
    given_.reset();
}

void Instants::set_channels(double t, const double* y) {
    equations_.set_pose(t, y);
    equations_.set_velocities(y, false);
    variables_ = equations_.variables_at(t, y);
}

bool Instants::act(int number, double* y) {
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

std::vector<double> Instants::values(const Programs& programs, double t, const double* y) {
    set_channels(t, y);
    std::vector<double> found;
    for (int k = 0; k < programs.size(); ++k) found.push_back(programs.value(k, variables_, nullptr));
    return found;
}

}  // namespace mbproj
