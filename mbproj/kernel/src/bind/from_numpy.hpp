// Arguments of functions from Python, and arrays back. Wrong shapes, indices out of range and numbers that are not finite are refused
// with the name of the argument.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "model/model.hpp"
#include "model/settings.hpp"

namespace mbproj {

namespace nb = nanobind;
using Numbers1 = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Numbers2 = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Numbers3 = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Integers1 = nb::ndarray<const int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

[[noreturn]] inline void refuse(const std::string& name, const std::string& why) {
    throw std::invalid_argument(name + " " + why);
}

// In a shape: as many as there are.
constexpr auto any_length = static_cast<std::size_t>(-1);

// Checks a shape, and that numbers are finite.
template <class Array> void require(const Array& array, std::initializer_list<std::size_t> shape, const char* name) {
    std::size_t axis = 0;
    for (const std::size_t length : shape)
        if (const std::size_t own = array.shape(axis++); length != any_length && own != length)
            refuse(name, "has a wrong shape");
    if constexpr (std::is_same_v<typename Array::Scalar, const double>)
        for (std::size_t i = 0; i < array.size(); ++i)
            if (!std::isfinite(array.data()[i])) refuse(name, "holds a number that is not finite");
}

inline int index_below(int64_t index, std::size_t count, const char* name) {
    if (index < 0 || static_cast<std::size_t>(index) >= count) refuse(name, "holds an index out of range");
    return static_cast<int>(index);
}

// An array of Python's own from a vector, with `columns` per row; without columns it is flat.
template <class Number, class... Sizes> nb::object array_of(std::vector<Number> values, Sizes... sizes) {
    auto* kept = new std::vector<Number>(std::move(values));
    nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<Number>*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, Number>(kept->data(), {static_cast<std::size_t>(sizes)...}, owner));
}

inline void require_positive(double value, const char* name) {
    if (!(value > 0.0 && std::isfinite(value))) refuse(name, "is not positive");
}

// An index, or -1 for none.
inline int optional_index(int64_t index, std::size_t below, const char* name) {
    return index == -1 ? -1 : index_below(index, below, name);
}

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
