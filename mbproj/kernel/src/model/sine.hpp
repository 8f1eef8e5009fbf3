// Sine and cosine, of one double or of four at once, from one text without branches, so that four have the bits of one.
// The argument is reduced by multiples of π/2 in three parts (Cody & Waite 1980); the polynomials are those of fdlibm.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "model/four_at_once.hpp"

namespace mbproj {

template <class S> struct SineAndCosine {
    S sine, cosine;
};

// The integer with the bits of a number.
template <class S> struct BitsOf {
    using Type = std::conditional_t<std::is_same_v<S, FourAtOnce>, FourBits, std::uint64_t>;
};
template <class S> [[gnu::always_inline]] inline typename BitsOf<S>::Type bits_of(const S& x) {
    typename BitsOf<S>::Type bits;
    static_assert(sizeof bits == sizeof x);
    std::memcpy(&bits, &x, sizeof bits);
    return bits;
}
template <class S> [[gnu::always_inline]] inline S from_bits(const typename BitsOf<S>::Type& bits) {
    S x;
    std::memcpy(&x, &bits, sizeof x);
    return x;
}

// Up to here n times a part of π/2 has no more than 53 digits, so that the product is exact.
constexpr double largest_reduced = 0x1p19;

// x = n π/2 + high + low for |x| <= `largest_reduced`; `quadrant` is n modulo 4.
template <class S> struct Reduced {
    S high, low;
    typename BitsOf<S>::Type quadrant;

    [[gnu::always_inline]] explicit Reduced(const S& x) {
        constexpr double to_whole = 0x1.8p52;  // numbers near it are whole, and their last bits are those of n
        constexpr double first = 1.57079632673412561417e+00, second = 6.07710050630396597660e-11,
                         rest = 2.02226624879595063154e-21;
        const S shifted = x * 6.36619772367581382433e-01 + to_whole;
        const S n = shifted - to_whole;
        quadrant = bits_of(shifted) & 3;
        const S left = x - n * first, taken = n * second, all = left - taken;
        const S more = n * rest - ((left - all) - taken);
        high = all - more;
        low = (all - high) - more;
    }
};

// The sine of high + low, for |high| <= π/4.
template <class S> [[gnu::always_inline]] inline S sine_near_zero(const S& high, const S& low) {
    const S z = high * high, v = z * high;
    const S r =
        8.33333333332248946124e-03 +
        z * (-1.98412698298579493134e-04 +
             z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
    return high - ((z * (0.5 * low - v * r) - low) - v * -1.66666666666666324348e-01);
}
template <class S> [[gnu::always_inline]] inline S cosine_near_zero(const S& high, const S& low) {
    const S z = high * high, half = 0.5 * z, most = 1.0 - half;
    const S r = z * (4.16666666666666019037e-02 +
                     z * (-1.38888888888741095749e-03 +
                          z * (2.48015872894767294178e-05 +
                               z * (-2.75573143513906633035e-07 +
                                    z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
    return most + (((1.0 - most) - half) + (z * r - high * low));
}

template <class S> [[gnu::always_inline]] inline SineAndCosine<S> reduced_sine_and_cosine(const S& x) {
    const Reduced<S> part(x);
    const auto sine = bits_of(sine_near_zero(part.high, part.low));
    const auto cosine = bits_of(cosine_near_zero(part.high, part.low));
    const auto swapped = -(part.quadrant & 1);  // all bits, or none
    const auto of_sine = (part.quadrant & 2) << 62, of_cosine = ((part.quadrant + 1) & 2) << 62;
    return {from_bits<S>(((cosine & swapped) | (sine & ~swapped)) ^ of_sine),
            from_bits<S>(((sine & swapped) | (cosine & ~swapped)) ^ of_cosine)};
}

// For larger arguments and NaN. One function for all: in the standard library, sine and cosine computed at once may
// differ in their last digits from each computed alone.
[[gnu::noinline, gnu::cold]] inline SineAndCosine<double> far_sine_and_cosine(double x) {
    return {std::sin(x), std::cos(x)};
}

inline SineAndCosine<double> sine_and_cosine(double x) {
    if (!(std::fabs(x) <= largest_reduced)) return far_sine_and_cosine(x);
    return reduced_sine_and_cosine(x);
}
// For `at_once` numbers; each result has the bits that it would have alone.
inline void sines_and_cosines(const double* x, double* sine, double* cosine) {
    FourAtOnce all;
    std::memcpy(&all, x, sizeof all);
    const auto found = reduced_sine_and_cosine(all);
    std::memcpy(sine, &found.sine, sizeof all);
    std::memcpy(cosine, &found.cosine, sizeof all);
    const auto reduced = (all <= largest_reduced) & (all >= -largest_reduced);
    std::int64_t is_reduced[at_once];
    std::memcpy(is_reduced, &reduced, sizeof is_reduced);
    for (int k = 0; k < at_once; ++k)
        if (!is_reduced[k]) {
            const auto far = far_sine_and_cosine(x[k]);
            sine[k] = far.sine, cosine[k] = far.cosine;
        }
}
inline double sin(double x) { return sine_and_cosine(x).sine; }
inline double cos(double x) { return sine_and_cosine(x).cosine; }

}  // namespace mbproj
