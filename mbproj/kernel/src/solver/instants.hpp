// Changes of elements' states at an instant between two steps. First come the values from outside, which Python gives
// to a run that waits for them (mbproj.motion.stepwise); then the controllers of the scene act.
#pragma once

#include <optional>
#include <utility>

#include "solver/equations.hpp"

namespace mbproj {

class Instants final {
public:
    using NewStates = std::vector<std::pair<int, double>>;  // the number of each state, and its new value

    explicit Instants(Equations& equations) : model_(equations.mechanism()), equations_(equations) {}

    // Keeps values from outside until `set_from_outside` writes them into y, once.
    void give(NewStates states) { from_outside_ = std::move(states); }
    bool has_from_outside() const { return from_outside_.has_value(); }
    void set_from_outside(double* y);

    // Sets the variables of programs for y at t: once, before the first `act` of an instant, so that all controllers of
    // the instant read the same time and channels.
    void set_channels(double t, const double* y);
    // Sets the states of action `number` in y, all at once. False where a program of it has no finite value.
    bool act(int number, double* y);
    // The values of programs of the time and channels, for y at t.
    std::vector<double> values(const Programs& programs, double t, const double* y);

private:
    const Mechanism& model_;
    Equations& equations_;
    const Series<double>* variables_ = nullptr;
    std::optional<NewStates> from_outside_;
    std::vector<double> new_values_;  // scratch of `act`
};

}  // namespace mbproj
