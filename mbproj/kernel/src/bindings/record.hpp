// Records of Python: values by name, checked. A record is a dict, or an object whose attributes are the values. A reader names each
// field once, with the member that it fills and the check that it must pass. What does not pass is refused with the name.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <nanobind/nanobind.h>

#include "algebra/matrix.hpp"
#include "model/settings.hpp"

namespace mbproj {

namespace nb = nanobind;
using Shape = std::vector<std::size_t>;

// Numbers in the order of an array's rows.
template <class Number> struct Array {
    std::vector<Number> values;
    Shape shape;
    std::size_t size() const { return shape[0]; }
    const Number* row(std::size_t i) const { return values.data() + values.size() / size() * i; }
};

class Record {
public:
    static constexpr auto any = static_cast<std::size_t>(-1);  // in a shape: as many as there are

    explicit Record(nb::object values, std::string path = {}) : values_(std::move(values)), path_(std::move(path)) {}

    // Whether the name is there and is not None.
    bool has(const char* name) const;
    nb::object take(const char* name);
    Record part(const char* name) { return Record(take(name), path_ + name + "."); }
    std::vector<nb::object> list(const char* name, std::size_t size = any);
    double number(const char* name, bool positive = false);
    double positive(const char* name) { return number(name, true); }
    int index(const char* name, std::size_t below, int least = 0);
    bool flag(const char* name) { return index(name, 2) != 0; }
    Array<double> array(const char* name, const Shape& shape, bool finite = true);
    std::vector<double> numbers(const char* name, std::size_t size = any) { return array(name, {size}).values; }
    Array<int> indices(const char* name, const Shape& shape, std::size_t below, int least = 0);
    RowMajor matrix(const char* name, std::size_t rows, std::size_t columns);
    // A copy of an object of a class of the kernel.
    template <class T> T object(const char* name) {
        const T* held = nullptr;
        if (!nb::try_cast(take(name), held) || !held) wrong_type(name);
        return *held;
    }

    [[noreturn]] void refuse(const char* name, const char* why) const;
    [[noreturn]] void wrong_type(const char* name) const;
    // Refuses names of a dict that nobody took.
    void close() const;

private:
    nb::object find(const char* name) const;
    int in_range(const char* name, int64_t value, std::size_t below, int least) const;
    template <class Number> Array<Number> of_shape(const char* name, const Shape& shape);

    nb::object values_;
    std::string path_;
    std::shared_ptr<std::vector<const char*>> taken_ = std::make_shared<std::vector<const char*>>();  // also by copies
};

// The axes of a member of a struct behind the first of an array, and the member's numbers from a row.
inline void add_axes(const double*, Shape&) {}
inline void add_axes(const bool*, Shape&) {}
template <int R, int C> void add_axes(const Matrix<R, C>*, Shape& shape) {
    if (R * C > 1) shape.push_back(R);
    if (C > 1) shape.push_back(C);
}
template <class T, std::size_t N> void add_axes(const T (*)[N], Shape& shape) {
    shape.push_back(N);
    add_axes(static_cast<const T*>(nullptr), shape);
}
inline void fill(double& to, const double*& from) { to = *from++; }
inline void fill(bool& to, const double*& from) { to = *from++ != 0.0; }
template <int R, int C> void fill(Matrix<R, C>& to, const double*& from) {
    for (int r = 0; r < R; ++r)
        for (int c = 0; c < C; ++c) to(r, c) = *from++;
}
template <class T, std::size_t N> void fill(T (&to)[N], const double*& from) {
    for (T& each : to) fill(each, from);
}

// Structs from arrays: entry i of each array belongs to struct i. The first array says how many there are.
template <class Item> class Columns {
public:
    std::vector<Item> items;

    explicit Columns(Record given) : given_(std::move(given)) {}

    // Numbers, flags, vectors and matrices.
    template <class Field> Columns& operator()(const char* name, Field Item::* member, bool finite = true) {
        Shape shape{count_};
        add_axes(static_cast<const Field*>(nullptr), shape);
        return each(name, shape, [member](Item& to, const double* from) { fill(to.*member, from); }, finite);
    }
    // Indices from `least` to below `below`: one each, or several.
    template <class Index> Columns& index(const char* name, Index Item::* member, std::size_t below, int least = 0) {
        return hand_out(given_.indices(name, {count_}, below, least),
                        [member](Item& to, const int* from) { to.*member = static_cast<Index>(*from); });
    }
    template <int N> Columns& index(const char* name, int (Item::*member)[N], std::size_t below) {
        return hand_out(given_.indices(name, {count_, N}, below),
                        [member](Item& to, const int* from) { std::copy_n(from, N, to.*member); });
    }
    // What `take` makes of each row of an array.
    template <class Take> Columns& each(const char* name, const Shape& shape, const Take& take, bool finite = true) {
        return hand_out(given_.array(name, shape, finite), take);
    }
    Record& given() { return given_; }
    std::size_t count() const { return count_; }

private:
    template <class Number, class Take> Columns& hand_out(const Array<Number>& own, const Take& take) {
        if (count_ == Record::any) items.resize(count_ = own.size());
        for (std::size_t i = 0; i < count_; ++i) take(items[i], own.row(i));
        return *this;
    }

    Record given_;
    std::size_t count_ = Record::any;
};

// What `made_of` makes of the values that Python names.
template <class T> T from_names(T (*made_of)(Record&), const nb::kwargs& values) {
    Record record(values);
    T made = made_of(record);
    record.close();
    return made;
}

// A class that Python makes from a record, and a function of one.
template <class T> nb::class_<T> record_class(nb::module_& m, const char* name, T (*made_of)(Record&)) {
    return nb::class_<T>(m, name).def(
        "__init__", [made_of](T* self, const nb::kwargs& values) { new (self) T(from_names(made_of, values)); });
}
inline void record_function(nb::module_& m, const char* name, nb::object (*made_of)(Record&), const char* what) {
    m.def(name, [made_of](const nb::kwargs& values) { return from_names(made_of, values); }, what);
}

}  // namespace mbproj
