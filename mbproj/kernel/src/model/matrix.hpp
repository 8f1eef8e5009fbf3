// Matrices of few numbers, stored column by column, and parts of them that can be written.
#pragma once

#include "model/dense.hpp"

namespace mbproj {

// Fills a matrix row by row with numbers, or a column with numbers and columns: A << a, b, c;
template <class Filled> class Filling {
public:
    explicit Filling(Filled& filled) : filled_(filled) {}
    [[gnu::always_inline]] Filling& operator,(const ScalarOf<Filled>& next) {
        const int at = at_++;
        filled_(at / Filled::cols(), at % Filled::cols()) = next;
        return *this;
    }
    template <class Other, int R, int S, int T>
    [[gnu::always_inline]] Filling& operator,(const Dense<Other, R, 1, S, T>& next) {
        filled_.template segment<R>(at_) = next;
        at_ += R;
        return *this;
    }

private:
    Filled& filled_;
    int at_ = 0;
};

// A matrix or part that can be written. What is assigned is evaluated first, unless it is a part of another matrix.
template <class Derived, int Rows, int Columns, int RowStep, int ColumnStep> class Writable
    : public Dense<Derived, Rows, Columns, RowStep, ColumnStep> {
public:
    using Base = Dense<Derived, Rows, Columns, RowStep, ColumnStep>;
    using typename Base::Indices;
    using typename Base::Scalar;

    template <class Other, int S, int T>
    [[gnu::always_inline]] Derived& operator+=(const Dense<Other, Rows, Columns, S, T>& other) {
        return add(other, Indices());
    }
    template <class Other, int S, int T>
    [[gnu::always_inline]] Derived& operator-=(const Dense<Other, Rows, Columns, S, T>& other) {
        return subtract(other, Indices());
    }
    // Adds s times another matrix. Each product and sum is rounded once where the processor can do that.
    template <class Other, int S, int T>
    [[gnu::always_inline]] Derived& add_multiple(const Scalar& s, const Dense<Other, Rows, Columns, S, T>& other) {
        return add_multiple(s, other, Indices());
    }
    [[gnu::always_inline]] Derived& operator+=(Scalar number) {
        return each([=](Scalar& own) { own += number; });
    }
    [[gnu::always_inline]] Derived& operator*=(Scalar factor) {
        return each([=](Scalar& own) { own *= factor; });
    }
    [[gnu::always_inline]] Derived& operator/=(Scalar by) {
        return each([=](Scalar& own) { own /= by; });
    }
    [[gnu::always_inline]] void setConstant(Scalar number) {
        each([=](Scalar& own) { own = number; });
    }
    [[gnu::always_inline]] void setZero() { setConstant(0.0); }
    [[gnu::always_inline]] void setIdentity() {
        setZero();
        this->diagonal().setConstant(1.0);
    }
    template <class First> [[gnu::always_inline]] auto operator<<(const First& first) {
        Filling<Derived> filling(own());
        filling, first;
        return filling;
    }

protected:
    template <class Other, int... I>
    [[gnu::always_inline]] void copy(const Other& other, std::integer_sequence<int, I...>) {
        (void((*this)[I] = other[I]), ...);
    }

private:
    Derived& own() { return static_cast<Derived&>(*this); }
    template <class Other, int... I>
    [[gnu::always_inline]] Derived& add(const Other& other, std::integer_sequence<int, I...>) {
        (void((*this)[I] += other[I]), ...);
        return own();
    }
    template <class Other, int... I>
    [[gnu::always_inline]] Derived& subtract(const Other& other, std::integer_sequence<int, I...>) {
        (void((*this)[I] -= other[I]), ...);
        return own();
    }
    template <class Other, int... I> [[gnu::always_inline]] Derived& add_multiple(const Scalar& s, const Other& other,
                                                                                  std::integer_sequence<int, I...>) {
        (void((*this)[I] = multiply_add(s, other[I], static_cast<const Writable&>(*this)[I])), ...);
        return own();
    }
    template <class Change> [[gnu::always_inline]] Derived& each(const Change& change) {
        return each(change, Indices());
    }
    template <class Change, int... I>
    [[gnu::always_inline]] Derived& each(const Change& change, std::integer_sequence<int, I...>) {
        (void(change((*this)[I])), ...);
        return own();
    }
};

// A view of numbers that are stored elsewhere: a part of a matrix, or of a state vector.
template <class Number, int Rows, int Columns, int RowStep, int ColumnStep> class View
    : public Writable<View<Number, Rows, Columns, RowStep, ColumnStep>, Rows, Columns, RowStep, ColumnStep> {
public:
    using Base = Writable<View, Rows, Columns, RowStep, ColumnStep>;
    [[gnu::always_inline]] explicit View(Number* at) : at_(at) {}
    View(const View&) = default;
    [[gnu::always_inline]] Number* data() const { return at_; }

    [[gnu::always_inline]] View& operator=(const View& other) {
        this->copy(other, typename Base::Indices());
        return *this;
    }
    template <class Other, int S, int T>
    [[gnu::always_inline]] View& operator=(const Dense<Other, Rows, Columns, S, T>& other) {
        this->copy(other, typename Base::Indices());
        return *this;
    }

private:
    Number* at_;
};

template <int Rows, int Columns, class Scalar> class Matrix
    : public Writable<Matrix<Rows, Columns, Scalar>, Rows, Columns, 1, Rows> {
public:
    using Base = Writable<Matrix, Rows, Columns, 1, Rows>;
    Matrix() = default;
    // A vector from its numbers.
    explicit Matrix(Scalar only) : own_{only} { static_assert(Base::count == 1); }
    Matrix(Scalar x, Scalar y) : own_{x, y} { static_assert(Base::count == 2); }
    Matrix(Scalar x, Scalar y, Scalar z) : own_{x, y, z} { static_assert(Base::count == 3); }
    template <class Other, int S, int T> [[gnu::always_inline]] Matrix(const Dense<Other, Rows, Columns, S, T>& other) {
        this->copy(other, typename Base::Indices());
    }
    [[gnu::always_inline]] Scalar* data() { return own_; }
    [[gnu::always_inline]] const Scalar* data() const { return own_; }
    Scalar* begin() { return own_; }
    Scalar* end() { return own_ + Base::count; }
    const Scalar* begin() const { return own_; }
    const Scalar* end() const { return own_ + Base::count; }

    static Matrix Zero() {
        Matrix found;
        found.setZero();
        return found;
    }
    static Matrix Identity() {
        Matrix found;
        found.setIdentity();
        return found;
    }
    static Matrix Unit(int i) {
        Matrix found = Zero();
        found[i] = 1.0;
        return found;
    }
    bool operator==(const Matrix& other) const {
        for (int i = 0; i < Base::count; ++i)
            if (own_[i] != other.own_[i]) return false;
        return true;
    }

private:
    Scalar own_[Base::count];
};

// A view of the matrix that begins at a number, stored column by column, or row by row.
template <int Rows, int Columns = 1, class Number> [[gnu::always_inline]] inline auto matrix_at(Number* at) {
    return View<Number, Rows, Columns, 1, Rows>(at);
}
template <int Rows, int Columns, class Number> auto matrix_by_rows(const Number* at) {
    return View<const Number, Rows, Columns, Columns, 1>(at);
}

// The values of a matrix, without the derivatives of dual numbers.
template <int Rows, int Columns, class Scalar>
Matrix<Rows, Columns, double> values_of(const Matrix<Rows, Columns, Scalar>& from) {
    Matrix<Rows, Columns, double> found;
    for (int i = 0; i < Rows * Columns; ++i) found[i] = value_of(from[i]);
    return found;
}

}  // namespace mbproj
