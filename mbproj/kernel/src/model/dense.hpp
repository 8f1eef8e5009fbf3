// The base of small vectors and matrices and of their parts: sizes and strides that the compiler knows, and all
// functions that only read. Eigen's expressions would do the same; they took half of the time and the memory of a
// compilation.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "model/scalar.hpp"

namespace mbproj {

template <int Rows, int Columns, class Scalar = double> class Matrix;
template <int Rows, class Scalar = double> using Column = Matrix<Rows, 1, Scalar>;
template <class Number, int Rows, int Columns, int RowStep, int ColumnStep> class View;

// The type of the numbers of a matrix or of a part of a matrix.
template <class Derived> struct NumbersOf;
template <int Rows, int Columns, class Scalar> struct NumbersOf<Matrix<Rows, Columns, Scalar>> {
    using Type = Scalar;
};
template <class Number, int Rows, int Columns, int RowStep, int ColumnStep>
struct NumbersOf<View<Number, Rows, Columns, RowStep, ColumnStep>> {
    using Type = std::remove_const_t<Number>;
};
template <class Derived> using ScalarOf = typename NumbersOf<Derived>::Type;

// p0 + p1 + ..., by halves: the sums are independent, and their round-off grows with the logarithm of their number.
template <int Count, class Scalar> [[gnu::always_inline]] inline Scalar sum_by_halves(const Scalar* p) {
    if constexpr (Count == 1)
        return p[0];
    else
        return sum_by_halves<Count / 2>(p) + sum_by_halves<Count - Count / 2>(p + Count / 2);
}

// a0 b0 + a1 b1 + ..., by halves, too.
template <int Count, class Scalar>
[[gnu::always_inline]] inline Scalar sum_of_products(const Scalar* a, const Scalar* b) {
    constexpr int half = Count / 2;
    if constexpr (Count == 1)
        return a[0] * b[0];
    else if constexpr (half == 1)
        return multiply_add(a[0], b[0], sum_of_products<Count - 1>(a + 1, b + 1));
    else
        return sum_of_products<half>(a, b) + sum_of_products<Count - half>(a + half, b + half);
}

// Whether all numbers are finite: 0 x is NaN for all others. Eight at a time, so that the sums stay in registers.
inline bool all_finite(const double* x, std::ptrdiff_t size) {
    constexpr std::ptrdiff_t width = 8;
    double none[width] = {};
    std::ptrdiff_t i = 0;
    for (; i + width <= size; i += width)
        for (std::ptrdiff_t k = 0; k < width; ++k) none[k] += 0.0 * x[i + k];
    for (; i < size; ++i) none[0] += 0.0 * x[i];
    return sum_by_halves<width>(none) == 0.0;
}

// `Derived` has data(), where it begins. RowStep leads to the next number of a column, ColumnStep to that of a row.
template <class Derived, int Rows, int Columns, int RowStep, int ColumnStep> class Dense {
public:
    static constexpr int count = Rows * Columns;
    using Indices = std::make_integer_sequence<int, count>;
    using Scalar = ScalarOf<Derived>;
    using Value = Matrix<Rows, Columns, Scalar>;

    // The place of number i, counted column by column.
    [[gnu::always_inline]] static constexpr int place(int i) { return i % Rows * RowStep + i / Rows * ColumnStep; }
    [[gnu::always_inline]] decltype(auto) operator[](int i) { return own().data()[place(i)]; }
    [[gnu::always_inline]] Scalar operator[](int i) const { return own().data()[place(i)]; }
    [[gnu::always_inline]] decltype(auto) operator()(int r, int c) {
        return own().data()[r * RowStep + c * ColumnStep];
    }
    [[gnu::always_inline]] Scalar operator()(int r, int c) const { return own().data()[r * RowStep + c * ColumnStep]; }
    Scalar x() const { return (*this)[0]; }
    Scalar y() const { return (*this)[1]; }
    Scalar z() const { return (*this)[2]; }
    static constexpr int size() { return count; }
    static constexpr int rows() { return Rows; }
    static constexpr int cols() { return Columns; }

    // Parts: to read, and to write where the matrix can be written.
    template <int N> [[gnu::always_inline]] auto segment(int at) { return part<N, 1>(own().data() + at * RowStep); }
    template <int N> [[gnu::always_inline]] auto segment(int at) const {
        return part<N, 1>(own().data() + at * RowStep);
    }
    template <int N> [[gnu::always_inline]] auto head() { return segment<N>(0); }
    template <int N> [[gnu::always_inline]] auto head() const { return segment<N>(0); }
    template <int N> [[gnu::always_inline]] auto tail() { return segment<N>(Rows - N); }
    template <int N> [[gnu::always_inline]] auto tail() const { return segment<N>(Rows - N); }
    template <int R, int C> [[gnu::always_inline]] auto block(int r, int c) {
        return part<R, C>(own().data() + r * RowStep + c * ColumnStep);
    }
    template <int R, int C> [[gnu::always_inline]] auto block(int r, int c) const {
        return part<R, C>(own().data() + r * RowStep + c * ColumnStep);
    }
    [[gnu::always_inline]] auto col(int c) { return block<Rows, 1>(0, c); }
    [[gnu::always_inline]] auto col(int c) const { return block<Rows, 1>(0, c); }
    [[gnu::always_inline]] auto row(int r) { return block<1, Columns>(r, 0); }
    [[gnu::always_inline]] auto row(int r) const { return block<1, Columns>(r, 0); }
    [[gnu::always_inline]] auto diagonal() { return diagonal_of(own().data()); }
    [[gnu::always_inline]] auto diagonal() const { return diagonal_of(own().data()); }
    [[gnu::always_inline]] auto transpose() { return transposed(own().data()); }
    [[gnu::always_inline]] auto transpose() const { return transposed(own().data()); }

    Value eval() const { return *this; }
    [[gnu::always_inline]] Scalar sum() const { return sum_of(Indices()); }
    [[gnu::always_inline]] Scalar trace() const { return diagonal().sum(); }
    template <class Other, int R, int C, int S, int T>
    [[gnu::always_inline]] Scalar dot(const Dense<Other, R, C, S, T>& other) const {
        static_assert((Rows == 1 || Columns == 1) && (R == 1 || C == 1) && R * C == count);
        return dot_with(other, Indices());
    }
    template <class Other, int S, int T> [[gnu::always_inline]] Value cross(const Dense<Other, 3, 1, S, T>& b) const {
        const Dense& a = *this;
        return {multiply_add(a[1], b[2], -(a[2] * b[1])), multiply_add(a[2], b[0], -(a[0] * b[2])),
                multiply_add(a[0], b[1], -(a[1] * b[0]))};
    }
    [[gnu::always_inline]] Scalar squaredNorm() const { return square(Indices()); }
    Scalar norm() const { return sqrt(squaredNorm()); }
    [[gnu::always_inline]] Value normalized() const {
        const Scalar square = squaredNorm();
        return square > 0.0 ? Value(own() / sqrt(square)) : eval();
    }
    // The largest absolute value.
    Scalar largest() const {
        Scalar most = abs((*this)[0]);
        for (int i = 1; i < count; ++i) most = max(most, abs((*this)[i]));
        return most;
    }
    bool allFinite() const {
        for (int i = 0; i < count; ++i)
            if (!isfinite((*this)[i])) return false;
        return true;
    }

private:
    const Derived& own() const { return static_cast<const Derived&>(*this); }
    Derived& own() { return static_cast<Derived&>(*this); }

    template <int R, int C, class Number> static auto part(Number* at) {
        return View<Number, R, C, RowStep, ColumnStep>(at);
    }
    template <class Number> static auto diagonal_of(Number* at) {
        return View<Number, Rows, 1, RowStep + ColumnStep, 0>(at);
    }
    template <class Number> static auto transposed(Number* at) {
        return View<Number, Columns, Rows, ColumnStep, RowStep>(at);
    }
    template <int... I> [[gnu::always_inline]] Scalar sum_of(std::integer_sequence<int, I...>) const {
        const Scalar terms[] = {(*this)[I]...};
        return sum_by_halves<count>(terms);
    }
    template <int... I> [[gnu::always_inline]] Scalar square(std::integer_sequence<int, I...>) const {
        const Scalar own[] = {(*this)[I]...};
        return sum_of_products<count>(own, own);
    }
    template <class Other, int... I>
    [[gnu::always_inline]] Scalar dot_with(const Other& other, std::integer_sequence<int, I...>) const {
        const Scalar own[] = {(*this)[I]...}, others[] = {other[I]...};
        return sum_of_products<count>(own, others);
    }
};

}  // namespace mbproj
