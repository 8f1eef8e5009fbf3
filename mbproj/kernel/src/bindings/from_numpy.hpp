// Arguments of runs and of equations at single states, checked.
#pragma once

#include <optional>
#include <tuple>

#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings/arrays.hpp"
#include "model/model.hpp"
#include "model/settings.hpp"

namespace mbproj {

// Times at which steps end: (time, left, right, actions, asks) of each.
using BreakNumbers = std::vector<std::tuple<double, double, double, std::vector<int>, bool>>;

inline std::vector<Break> breaks_of(const BreakNumbers& given) {
    std::vector<Break> breaks;
    for (const auto& [time, left, right, actions, asks] : given) {
        const bool after_last = breaks.empty() || left >= breaks.back().right;
        if (!(std::isfinite(time) && left < right && after_last)) refuse("breaks", "do not increase");
        breaks.push_back({time, left, right, actions, asks});
    }
    return breaks;
}

// Checks that the settings fit each other.
inline void check_settings(const Tableau& tableau, const ProjectionSettings& projection, const Steps& steps) {
    if (projection.every < 1 || projection.max_iterations < 1) refuse("every or max_iterations", "is not positive");
    for (const double number : {projection.alpha, projection.beta, projection.tolerance, projection.threshold})
        if (!std::isfinite(number)) refuse("projection", "holds a number that is not finite");
    if (!steps.fixed() && tableau.error.rows() == 0) refuse("tableau", "estimates no error");
}

// Checks that programs name only variables that exist.
inline void require_variables(const Programs& programs, int variables, const char* name) {
    if (programs.variables > variables) refuse(name, "have variables that are not there");
}

// Checks rows of a model that may be left out.
template <class D>
std::optional<std::vector<int>> rows_from(const Model<D>& model, std::optional<std::vector<int>> rows) {
    if (!rows) return rows;
    for (std::size_t i = 0; i < rows->size(); ++i)
        if ((*rows)[i] < (i ? (*rows)[i - 1] + 1 : 0) || (*rows)[i] >= model.constraints.rows)
            refuse("left_out", "holds an index out of range");
    return rows;
}

}  // namespace mbproj
