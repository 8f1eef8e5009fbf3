// Changes of elements' states at instants, by controllers and from outside, as in
// mbproj.motion.point.
#pragma once

#include <optional>
#include <utility>

#include "solver/equations.hpp"

namespace mbproj {

class Instants final {
public:
    using Given = std::vector<std::pair<int, double>>;  // numbers of states, and their new values

    explicit Instants(Equations& equations) : model_(equations.mechanism()), equations_(equations) {}

    bool any_given() const { return given_.has_value(); }
    void give(Given states) { given_ = std::move(states); }
    void take_given(double* y);
    // Sets the variables of controllers for y at t, before the first controller acts there.
    void set_channels(double t, const double* y);
    // The action of a controller at y, for which the variables are set. False where a program has no finite value.
    bool act(int number, double* y);
    // The values of programs of the time and channels for y at t.
    std::vector<double> values(const Programs& programs, double t, const double* y);

private:
    const Mechanism& model_;
    Equations& equations_;
    const Series<double>* variables_ = nullptr;
    std::optional<Given> given_;
    std::vector<double> found_;  // the values that an action sets
};

}  // namespace mbproj
