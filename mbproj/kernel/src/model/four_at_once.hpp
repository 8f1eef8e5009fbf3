// Four doubles that are computed at once; each has the bits that it would have alone.
#pragma once

#include <cstdint>

#ifdef __FMA__
#include <immintrin.h>
#endif

namespace mbproj {

// A single double where the compiler has no vectors.
#ifdef __GNUC__
using FourAtOnce = double __attribute__((vector_size(32)));
using FourBits = std::uint64_t __attribute__((vector_size(32)));
#else
using FourAtOnce = double;
using FourBits = std::uint64_t;
#endif
constexpr int at_once = sizeof(FourAtOnce) / sizeof(double);

[[gnu::always_inline]] inline FourAtOnce multiply_add(double a, const FourAtOnce& b, const FourAtOnce& c) {
#ifdef __FMA__
    return static_cast<FourAtOnce>(_mm256_fmadd_pd(_mm256_set1_pd(a), b, c));
#else
    return a * b + c;
#endif
}

}  // namespace mbproj
