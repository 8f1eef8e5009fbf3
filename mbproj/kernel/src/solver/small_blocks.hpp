// Products and quotients of the blocks of a factor, row-major, of one to six rows and columns.
#pragma once

#include <cstring>
#include <type_traits>

#include "model/four_at_once.hpp"
#include "model/scalar.hpp"

namespace mbproj {

namespace blocks {

// X := X L⁻ᵀ for X of `rows` rows and the lower triangle L, both R wide; `reciprocal` holds 1 / L_kk.
template <int R> void divide(double* X, int rows, const double* L, const double* reciprocal) {
    for (int r = 0; r < rows; ++r, X += R) {
        double x[R];
        for (int c = 0; c < R; ++c) {
            double sum = X[c];
            for (int k = 0; k < c; ++k) sum = multiply_add(-x[k], L[c * R + k], sum);
            X[c] = x[c] = sum * reciprocal[c];
        }
    }
}

// Eight numbers, or fewer at the end of a row: two vectors of the processor.
constexpr int eight = 8;
inline FourAtOnce four_at(const double* numbers) {
    FourAtOnce found;
    std::memcpy(&found, numbers, sizeof found);
    return found;
}

// Yᵀ of an R wide Y, in rows of eight numbers.
template <int R> void transpose(const double* Y, int columns, double* transposed) {
    for (int c = 0; c < columns; ++c, Y += R)
        for (int k = 0; k < R; ++k) transposed[eight * k + c] = Y[k];
}

// T -= X Yᵀ for X with R columns; both halves of a diagonal block.
template <int R> void subtract(double* T, const double* X, int rows, const double* transposed, int columns) {
    for (int r = 0; r < rows; ++r, X += R, T += columns) {
        FourAtOnce first{}, second{};
        for (int k = 0; k < R; ++k) {
            first = multiply_add(X[k], four_at(transposed + eight * k), first);
            second = multiply_add(X[k], four_at(transposed + eight * k + 4), second);
        }
        double sums[eight];
        std::memcpy(sums, &first, sizeof first);
        std::memcpy(sums + 4, &second, sizeof second);
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
