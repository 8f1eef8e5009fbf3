#include "bind/record.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include <nanobind/stl/vector.h>

namespace mbproj {

namespace {

template <class From, class To> void append(const Py_buffer& view, int axis, const char* at, std::vector<To>& to) {
    if (axis == view.ndim) {
        From value;
        std::memcpy(&value, at, sizeof value);
        to.push_back(static_cast<To>(value));
        return;
    }
    for (Py_ssize_t i = 0; i < view.shape[axis]; ++i) append<From>(view, axis + 1, at + i * view.strides[axis], to);
}

// The numbers of an array, whatever its strides; false where it has others than doubles, integers and flags, or where they are
// doubles and indices are wanted.
template <class Number> bool read(const Py_buffer& view, Array<Number>& to) {
    const auto read_as = [&](auto from) {
        append<decltype(from)>(view, 0, static_cast<const char*>(view.buf), to.values);
        return true;
    };
    const std::string kind = view.format ? view.format : "";
    to.shape.assign(view.shape, view.shape + view.ndim);
    if (kind == "d" && std::is_same_v<Number, double>) return read_as(double());
    if (kind == "?") return read_as(bool());
    if (kind != "i" && kind != "l" && kind != "q") return false;
    return view.itemsize == sizeof(int64_t) ? read_as(int64_t()) : read_as(int32_t());
}

bool is_list(nb::handle from) { return PyList_Check(from.ptr()) || PyTuple_Check(from.ptr()); }

// The numbers of an array, or of a list or tuple.
template <class Number> bool is_array(nb::handle from, Array<Number>& to) {
    if (is_list(from)) return nb::try_cast(from, to.values) && (to.shape = {to.values.size()}, true);
    Py_buffer view;
    if (PyObject_GetBuffer(from.ptr(), &view, PyBUF_RECORDS_RO) != 0) return PyErr_Clear(), false;
    const bool is_read = read(view, to);
    PyBuffer_Release(&view);
    return is_read;
}

}  // namespace

nb::object Record::find(const char* name) const {
    if (PyDict_Check(values_.ptr())) return nb::borrow(PyDict_GetItemString(values_.ptr(), name));
    nb::object found = nb::steal(PyObject_GetAttrString(values_.ptr(), name));
    if (!found.is_valid()) PyErr_Clear();
    return found;
}

bool Record::has(const char* name) const {
    const nb::object found = find(name);
    if (found.is_valid()) taken_->push_back(name);
    return found.is_valid() && !found.is_none();
}

nb::object Record::take(const char* name) {
    nb::object found = find(name);
    if (!found.is_valid()) refuse(name, "is missing");
    taken_->push_back(name);
    return found;
}

std::vector<nb::object> Record::list(const char* name, std::size_t size) {
    std::vector<nb::object> found;
    const nb::object own = take(name);
    if (!is_list(own) || !nb::try_cast(own, found)) wrong_type(name);
    if (size != any && found.size() != size) refuse(name, "has a wrong shape");
    return found;
}

double Record::number(const char* name, bool positive) {
    double found = 0.0;
    if (!nb::try_cast(take(name), found)) wrong_type(name);
    if (positive && !(found > 0.0 && std::isfinite(found))) refuse(name, "is not positive");
    if (!std::isfinite(found)) refuse(name, "is not finite");
    return found;
}

int Record::in_range(const char* name, int64_t value, std::size_t below, int least) const {
    if (value < least || (value >= 0 && static_cast<std::size_t>(value) >= below))
        refuse(name, "holds an index out of range");
    return static_cast<int>(value);
}

int Record::index(const char* name, std::size_t below, int least) {
    int64_t found = 0;
    if (!nb::try_cast(take(name), found)) wrong_type(name);
    return in_range(name, found, below, least);
}

template <class Number> Array<Number> Record::of_shape(const char* name, const Shape& shape) {
    Array<Number> found;
    if (!is_array(take(name), found) || found.shape.size() != shape.size()) wrong_type(name);
    for (std::size_t axis = 0; axis < shape.size(); ++axis)
        if (shape[axis] != any && shape[axis] != found.shape[axis]) refuse(name, "has a wrong shape");
    return found;
}

Array<double> Record::array(const char* name, const Shape& shape, bool finite) {
    Array<double> found = of_shape<double>(name, shape);
    for (const double value : found.values)
        if (finite ? !std::isfinite(value) : std::isnan(value)) refuse(name, "holds a number that is not finite");
    return found;
}

Array<double> Record::array(const char* name, std::size_t count, const Field& field, bool finite) {
    Shape shape{count};
    shape.insert(shape.end(), field.axes, field.axes + field.depth);
    return array(name, shape, finite);
}

Array<int> Record::indices(const char* name, const Shape& shape, std::size_t below, int least) {
    const Array<int64_t> found = of_shape<int64_t>(name, shape);
    Array<int> checked{{}, found.shape};
    for (const int64_t value : found.values) checked.values.push_back(in_range(name, value, below, least));
    return checked;
}

RowMajor Record::matrix(const char* name, std::size_t rows, std::size_t columns) {
    const Array<double> found = array(name, {rows, columns});
    return Eigen::Map<const RowMajor>(found.values.data(), static_cast<Eigen::Index>(found.shape[0]),
                                      static_cast<Eigen::Index>(found.shape[1]));
}

void Record::refuse(const char* name, const char* why) const { throw std::invalid_argument(path_ + name + " " + why); }
void Record::wrong_type(const char* name) const { throw nb::type_error((path_ + name + " has a wrong type").c_str()); }

void hand_out(const Array<double>& from, const Field& field, std::size_t stride, void* first) {
    const double* next = from.values.data();
    for (std::size_t i = 0; i < from.size(); ++i) {
        char* const at = static_cast<char*>(first) + i * stride;
        if (field.is_flag) {
            *reinterpret_cast<bool*>(at) = *next++ != 0.0;
            continue;
        }
        auto* block = reinterpret_cast<double*>(at);
        for (std::size_t b = 0; b < field.blocks; ++b, block += field.rows * field.columns)
            for (std::size_t r = 0; r < field.rows; ++r)
                for (std::size_t c = 0; c < field.columns; ++c) block[field.rows * c + r] = *next++;
    }
}
void hand_out(const Array<int>& from, std::size_t stride, void* first) {
    const std::size_t each = from.values.size() / from.size();
    for (std::size_t i = 0; i < from.size(); ++i)
        std::memcpy(static_cast<char*>(first) + i * stride, from.row(i), each * sizeof(int));
}

void Record::close() const {
    for (const auto& [name, value] : nb::borrow<nb::dict>(values_)) {
        const char* own = nb::cast<const char*>(name);
        if (std::none_of(taken_->begin(), taken_->end(), [own](const char* each) { return !std::strcmp(each, own); }))
            refuse(own, "is not known to the kernel");
    }
}

}  // namespace mbproj
