// L Lᵀ of a symmetric positive definite matrix of few numbers.
#pragma once

#include "model/operators.hpp"

namespace mbproj {

template <int N, class Scalar = double> class Cholesky final {
public:
    // From the lower half; false where the matrix is not positive definite.
    bool factor(const Matrix<N, N, Scalar>& A) {
        L_ = A;
        for (int k = 0; k < N; ++k) {
            const Scalar rest = L_(k, k) - inner(k, k, k);
            if (rest <= 0.0) return false;
            const Scalar pivot = L_(k, k) = sqrt(rest);
            for (int r = k + 1; r < N; ++r) L_(r, k) = (L_(r, k) - inner(r, k, k)) / pivot;
        }
        return true;
    }
    // x = L⁻¹ x.
    void forward(Column<N, Scalar>& x) const { forward(x, std::make_integer_sequence<int, N>()); }
    // x = L⁻ᵀ x.
    void backward(Column<N, Scalar>& x) const { backward(x, std::make_integer_sequence<int, N>()); }

private:
    // The inner product of the first `count` numbers of two rows.
    Scalar inner(int r, int s, int count) const {
        Scalar sum = 0.0;
        for (int c = 0; c < count; ++c) sum = multiply_add(L_(r, c), L_(s, c), sum);
        return sum;
    }
    template <int... K> void forward(Column<N, Scalar>& x, std::integer_sequence<int, K...>) const {
        (void(divide<K, 0, K>(L_.row(K), x)), ...);
    }
    template <int... K> void backward(Column<N, Scalar>& x, std::integer_sequence<int, K...>) const {
        (void(divide<N - 1 - K, N - K, K>(L_.col(N - 1 - K), x)), ...);
    }
    // x_k = (x_k - Σ line_i x_i) / line_k, over the `Known` numbers i from `From` on.
    template <int K, int From, int Known, class Line>
    [[gnu::always_inline]] static void divide(const Line& line, Column<N, Scalar>& x) {
        if constexpr (Known > 0) x[K] -= less<From>(line, x, std::make_integer_sequence<int, Known>());
        x[K] /= line[K];
    }
    template <int From, class Line, int... I> [[gnu::always_inline]] static Scalar
    less(const Line& line, const Column<N, Scalar>& x, std::integer_sequence<int, I...>) {
        const Scalar own[] = {line[From + I]...}, known[] = {x[From + I]...};
        return sum_of_products<sizeof...(I)>(own, known);
    }

    Matrix<N, N, Scalar> L_;
};

}  // namespace mbproj
