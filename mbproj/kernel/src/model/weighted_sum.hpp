// A vector plus a weighted sum of others, as a step computes from its stages.
#pragma once

#include <cstring>

#include "model/four_at_once.hpp"

namespace mbproj {

// Adds from place i on, as many numbers at once as a Number has. Returns the place where fewer are left.
template <class Number> long add_weighted(const double* from, const double* const* terms, const double* factors,
                                          int count, long i, long size, double* to) {
    constexpr long at_a_time = sizeof(Number) / sizeof(double);
    for (; i + at_a_time <= size; i += at_a_time) {
        Number sum{}, term;
        for (int s = 0; s < count; ++s) {
            std::memcpy(&term, terms[s] + i, sizeof term);
            sum += factors[s] * term;
        }
        std::memcpy(&term, from + i, sizeof term);
        sum += term;
        std::memcpy(to + i, &sum, sizeof sum);
    }
    return i;
}

// to = from + Σ factors[s] terms[s].
inline void add_weighted(const double* from, const double* const* terms, const double* factors, int count, long size,
                         double* to) {
    const long left = add_weighted<FourAtOnce>(from, terms, factors, count, 0, size, to);
    add_weighted<double>(from, terms, factors, count, left, size, to);
}

}  // namespace mbproj
