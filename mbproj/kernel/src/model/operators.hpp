// Sums, multiples and products of matrices of few numbers.
#pragma once

#include "model/matrix.hpp"

namespace mbproj {

namespace by_number {

template <class A, class B, class Result, int... I>
[[gnu::always_inline]] inline void sum(const A& a, const B& b, Result& to, std::integer_sequence<int, I...>) {
    (void(to[I] = a[I] + b[I]), ...);
}
template <class A, class B, class Result, int... I>
[[gnu::always_inline]] inline void difference(const A& a, const B& b, Result& to, std::integer_sequence<int, I...>) {
    (void(to[I] = a[I] - b[I]), ...);
}
template <class Scalar, class A, class Result, int... I>
[[gnu::always_inline]] inline void multiple(const Scalar& s, const A& a, Result& to, std::integer_sequence<int, I...>) {
    (void(to[I] = s * a[I]), ...);
}
template <class Scalar, class A, class Result, int... I>
[[gnu::always_inline]] inline void quotient(const A& a, const Scalar& s, Result& to, std::integer_sequence<int, I...>) {
    (void(to[I] = a[I] / s), ...);
}
template <class A, class Result, int... I>
[[gnu::always_inline]] inline void negative(const A& a, Result& to, std::integer_sequence<int, I...>) {
    (void(to[I] = -a[I]), ...);
}
template <int R, int C, class A, class B, int... K> [[gnu::always_inline]] inline typename A::Scalar
inner(const A& a, const B& b, int r, int c, std::integer_sequence<int, K...>) {
    const typename A::Scalar row[] = {a(r, K)...}, column[] = {b(K, c)...};
    return sum_of_products<sizeof...(K)>(row, column);
}
template <int Inner, class A, class B, class Result, int... I>
[[gnu::always_inline]] inline void product(const A& a, const B& b, Result& to, std::integer_sequence<int, I...>) {
    constexpr int R = Result::rows(), C = Result::cols();
    (void(to[I] = inner<R, C>(a, b, I % R, I / R, std::make_integer_sequence<int, Inner>())), ...);
}

}  // namespace by_number

template <class A, class B, int R, int C, int S, int T, int U, int V>
[[gnu::always_inline]] inline Matrix<R, C, ScalarOf<A>> operator+(const Dense<A, R, C, S, T>& a,
                                                                  const Dense<B, R, C, U, V>& b) {
    Matrix<R, C, ScalarOf<A>> found;
    by_number::sum(a, b, found, std::make_integer_sequence<int, R * C>());
    return found;
}
template <class A, class B, int R, int C, int S, int T, int U, int V>
[[gnu::always_inline]] inline Matrix<R, C, ScalarOf<A>> operator-(const Dense<A, R, C, S, T>& a,
                                                                  const Dense<B, R, C, U, V>& b) {
    Matrix<R, C, ScalarOf<A>> found;
    by_number::difference(a, b, found, std::make_integer_sequence<int, R * C>());
    return found;
}
template <class A, int R, int C, int S, int T>
[[gnu::always_inline]] inline Matrix<R, C, ScalarOf<A>> operator-(const Dense<A, R, C, S, T>& a) {
    Matrix<R, C, ScalarOf<A>> found;
    by_number::negative(a, found, std::make_integer_sequence<int, R * C>());
    return found;
}
template <class A, int R, int C, int S, int T>
[[gnu::always_inline]] inline Matrix<R, C, ScalarOf<A>> operator*(const ScalarOf<A>& s, const Dense<A, R, C, S, T>& a) {
    Matrix<R, C, ScalarOf<A>> found;
    by_number::multiple(s, a, found, std::make_integer_sequence<int, R * C>());
    return found;
}
template <class A, int R, int C, int S, int T>
[[gnu::always_inline]] inline Matrix<R, C, ScalarOf<A>> operator*(const Dense<A, R, C, S, T>& a, const ScalarOf<A>& s) {
    return s * a;
}
template <class A, int R, int C, int S, int T>
[[gnu::always_inline]] inline Matrix<R, C, ScalarOf<A>> operator/(const Dense<A, R, C, S, T>& a, const ScalarOf<A>& s) {
    Matrix<R, C, ScalarOf<A>> found;
    by_number::quotient(a, s, found, std::make_integer_sequence<int, R * C>());
    return found;
}
template <class A, class B, int R, int K, int C, int S, int T, int U, int V>
[[gnu::always_inline]] inline Matrix<R, C, ScalarOf<A>> operator*(const Dense<A, R, K, S, T>& a,
                                                                  const Dense<B, K, C, U, V>& b) {
    Matrix<R, C, ScalarOf<A>> found;
    by_number::product<K>(a, b, found, std::make_integer_sequence<int, R * C>());
    return found;
}

// Number by number.
template <class A, class B, int R, int C, int S, int T, int U, int V>
Matrix<R, C, ScalarOf<A>> scaled(const Dense<A, R, C, S, T>& by, const Dense<B, R, C, U, V>& a) {
    Matrix<R, C, ScalarOf<A>> found;
    for (int i = 0; i < R * C; ++i) found[i] = by[i] * a[i];
    return found;
}

}  // namespace mbproj
