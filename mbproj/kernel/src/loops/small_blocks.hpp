// Products and quotients of the blocks of a factor, row-major, of one to six rows and columns.
#pragma once

#include <type_traits>

namespace mbproj {

namespace blocks {

// X := X L⁻ᵀ for X of `rows` rows and the lower triangle L, both R wide; `reciprocal` holds 1 / L_kk.
template <int R, class Scalar> void divide(Scalar* X, int rows, const Scalar* L, const Scalar* reciprocal) {
    for (int r = 0; r < rows; ++r, X += R) {
        Scalar x[R];
        for (int c = 0; c < R; ++c) {
            Scalar sum = X[c];
            for (int k = 0; k < c; ++k) sum -= x[k] * L[c * R + k];
            X[c] = x[c] = sum * reciprocal[c];
        }
    }
}

// Eight numbers, or as many of them as a row has: two vectors of the processor.
constexpr int eight = 8;
using Four = double __attribute__((vector_size(32), aligned(8), may_alias));

// Yᵀ, rows of eight numbers, of an R wide Y.
template <int R, class Scalar> void transpose(const Scalar* Y, int columns, Scalar* transposed) {
    for (int c = 0; c < columns; ++c, Y += R)
        for (int k = 0; k < R; ++k) transposed[eight * k + c] = Y[k];
}

// T -= X Yᵀ for an R wide X; of a diagonal block all of it.
template <int R, class Scalar>
void subtract(Scalar* T, const Scalar* X, int rows, const Scalar* transposed, int columns) {
    for (int r = 0; r < rows; ++r, X += R, T += columns)
        for (int c = 0; c < columns; ++c)
            for (int k = 0; k < R; ++k) T[c] -= X[k] * transposed[eight * k + c];
}
template <int R> void subtract(double* T, const double* X, int rows, const double* transposed, int columns) {
    for (int r = 0; r < rows; ++r, X += R, T += columns) {
        Four first = {}, second = {};
        for (int k = 0; k < R; ++k) {
            const Four* y = reinterpret_cast<const Four*>(transposed + eight * k);
            first += X[k] * y[0];
            second += X[k] * y[1];
        }
        double sums[eight];
        reinterpret_cast<Four*>(sums)[0] = first;
        reinterpret_cast<Four*>(sums)[1] = second;
        for (int c = 0; c < columns; ++c) T[c] -= sums[c];
    }
}

// Calls visit with the width as a constant.
template <class Visit> void with_width(int width, Visit&& visit) {
    switch (width) {
        case 1: visit(std::integral_constant<int, 1>{}); break;
        case 2: visit(std::integral_constant<int, 2>{}); break;
        case 3: visit(std::integral_constant<int, 3>{}); break;
        case 4: visit(std::integral_constant<int, 4>{}); break;
        case 5: visit(std::integral_constant<int, 5>{}); break;
        default: visit(std::integral_constant<int, 6>{}); break;
    }
}

}  // namespace blocks

}  // namespace mbproj
