// Arrays from Python and back, and records: values by name. A reader takes each value where it needs it, so that a field is listed once
// in each language. Wrong shapes, indices out of range and numbers that are not finite are refused with the name of the field.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "model/settings.hpp"

namespace mbproj {

namespace nb = nanobind;
using Numbers1 = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Numbers2 = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Numbers3 = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Integers1 = nb::ndarray<const int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Integers2 = nb::ndarray<const int64_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

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

inline std::vector<double> numbers(const Numbers1& array, const char* name) {
    require(array, {any_length}, name);
    return {array.data(), array.data() + array.size()};
}
inline RowMajor matrix(const Numbers2& array, const char* name) {
    require(array, {any_length, any_length}, name);
    return Eigen::Map<const RowMajor>(array.data(), static_cast<Eigen::Index>(array.shape(0)),
                                      static_cast<Eigen::Index>(array.shape(1)));
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

class Record {
public:
    explicit Record(const nb::dict& values) : values_(values) {}

    bool has(const char* name) const { return values_.contains(name); }

    template <class T> T take(const char* name) {
        const nb::handle given = PyDict_GetItemString(values_.ptr(), name);
        if (!given) refuse(name, "is missing");
        taken_.push_back(name);
        T value;
        if (!nb::try_cast(given, value)) throw nb::type_error((std::string(name) + " has a wrong type").c_str());
        return value;
    }
    template <class T> T take(const char* name, T otherwise) { return has(name) ? take<T>(name) : otherwise; }

    template <class Array> Array array(const char* name, std::initializer_list<std::size_t> shape) {
        auto values = take<Array>(name);
        require(values, shape, name);
        return values;
    }
    std::vector<double> numbers(const char* name, std::size_t size = any_length) {
        return mbproj::numbers(array<Numbers1>(name, {size}), name);
    }
    // An object of a class of the kernel.
    template <class T> const T& object(const char* name) {
        const auto* held = take<const T*>(name);
        if (!held) throw nb::type_error((std::string(name) + " is none").c_str());
        return *held;
    }

    // Refuses names that nobody took.
    void close() const {
        if (taken_.size() == values_.size()) return;
        for (const auto& [name, value] : values_)
            if (const auto own = nb::cast<std::string>(name);
                std::find(taken_.begin(), taken_.end(), own) == taken_.end())
                refuse(own, "is not known to the kernel");
    }

private:
    nb::dict values_;
    std::vector<const char*> taken_;
};

// A class that Python makes from a record.
template <class T> nb::class_<T> record_class(nb::module_& m, const char* name, T (*made_of)(Record&)) {
    return nb::class_<T>(m, name).def("__init__", [made_of](T* self, const nb::kwargs& values) {
        Record record(values);
        T made = made_of(record);
        record.close();
        new (self) T(std::move(made));
    });
}

}  // namespace mbproj
