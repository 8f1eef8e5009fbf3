// Records of Python: values by name, checked. A record is a dict, or an object whose attributes are the values. A reader names each
// field once, with the member that it fills and the check that it must pass. What does not pass is refused with the name.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include <nanobind/nanobind.h>

#include "model/matrix.hpp"
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

struct Field;

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
    Array<double> array(const char* name, std::size_t count, const Field& field, bool finite);
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

// How the numbers of a member lie in a struct: `blocks` matrices, one after the other, each column by column; and the axes of an
// array of such members, behind its first.
struct Field {
    std::size_t axes[3], depth, blocks, rows, columns;
    bool is_flag;
};
constexpr Field field_of(const double*) { return {{}, 0, 1, 1, 1, false}; }
constexpr Field field_of(const bool*) { return {{}, 0, 1, 1, 1, true}; }
template <int R, int C> constexpr Field field_of(const Matrix<R, C>*) {
    static_assert(sizeof(Matrix<R, C>) == R * C * sizeof(double));
    return {{R, C}, R * C == 1 ? 0 : C == 1 ? 1 : 2, 1, R, C, false};
}
template <class T, std::size_t N> constexpr Field field_of(const T (*)[N]) {
    const Field one = field_of(static_cast<const T*>(nullptr));
    return {{N, one.axes[0], one.axes[1]}, one.depth + 1, N * one.blocks, one.rows, one.columns, one.is_flag};
}
// Gives each of the structs, which are `stride` bytes apart, its entry of an array; `first` is the member of the first struct.
void hand_out(const Array<double>& from, const Field& field, std::size_t stride, void* first);
void hand_out(const Array<int>& from, std::size_t stride, void* first);

// Structs from arrays: entry i of each array belongs to struct i. The first array says how many there are.
template <class Item> class Columns {
public:
    std::vector<Item> items;

    explicit Columns(Record given) : given_(std::move(given)) {}

    // Numbers, flags, vectors and matrices.
    template <class Member> Columns& operator()(const char* name, Member Item::* member, bool finite = true) {
        constexpr Field field = field_of(static_cast<const Member*>(nullptr));
        const Array<double> own = given_.array(name, count_, field, finite);
        if (resize(own.size())) hand_out(own, field, sizeof(Item), &(items.front().*member));
        return *this;
    }
    // Indices from `least` to below `below`: one each, or several.
    template <class Index> Columns& index(const char* name, Index Item::* member, std::size_t below, int least = 0) {
        static_assert(sizeof(Index) % sizeof(int) == 0);
        const Shape shape = std::is_array_v<Index> ? Shape{count_, std::extent_v<Index>} : Shape{count_};
        const Array<int> own = given_.indices(name, shape, below, least);
        if (resize(own.size())) hand_out(own, sizeof(Item), &(items.front().*member));
        return *this;
    }
    // What `take` makes of each row of an array.
    template <class Take> Columns& each(const char* name, const Shape& shape, const Take& take) {
        const Array<double> own = given_.array(name, shape);
        for (std::size_t i = 0; i < count_; ++i) take(items[i], own.row(i));
        return *this;
    }
    Record& given() { return given_; }
    std::size_t count() const { return count_; }

private:
    // Whether there are any.
    bool resize(std::size_t count) {
        if (count_ == Record::any) items.resize(count_ = count);
        return count_ > 0;
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
