// Packs: doubles that are computed at once, each of another case of an ensemble. With them, code for doubles computes
// several cases. Each lane has the bits that a double would have. There are eight lanes where this is compiled for
// AVX-512, else four, for AVX2.
//
// Code branches for all lanes alike. Where lanes do not agree, the majority decides, and the others leave: what they
// compute from there on has no meaning. `Lanes` tells which are in.
#pragma once

#include <immintrin.h>

#include "algebra/scalar.hpp"

namespace mbproj {

#if defined(__AVX512F__) && defined(__AVX512DQ__)
constexpr int pack_width = 8;
#else
constexpr int pack_width = 4;
#endif
using LaneBits = long long __attribute__((vector_size(8 * pack_width)));

// For each lane all bits, or none.
struct Mask {
    LaneBits lanes;

    Mask() = default;
    Mask(const LaneBits& bits) : lanes(bits) {}
    Mask(bool all) : lanes(LaneBits{} - static_cast<long long>(all)) {}
    bool operator[](int lane) const { return lanes[lane] != 0; }
    void set(int lane, bool on) { lanes[lane] = -static_cast<long long>(on); }
    // Bit k is that of lane k.
    int bits() const {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
        return _mm512_movepi64_mask(reinterpret_cast<__m512i>(lanes));
#else
        return _mm256_movemask_pd(reinterpret_cast<__m256d>(lanes));
#endif
    }
    bool any() const { return bits() != 0; }
    bool none() const { return bits() == 0; }
    Mask operator~() const { return ~lanes; }
    Mask& operator&=(const Mask& b) { return *this = lanes & b.lanes; }
    Mask& operator|=(const Mask& b) { return *this = lanes | b.lanes; }
    friend Mask operator&(const Mask& a, const Mask& b) { return a.lanes & b.lanes; }
    friend Mask operator|(const Mask& a, const Mask& b) { return a.lanes | b.lanes; }

    // Whether most of the lanes that are in are set; the others leave.
    operator bool() const;
    bool operator!() const { return !static_cast<bool>(*this); }
};

// The lanes that are in, in the current thread.
class Lanes {
public:
    static Mask in() { return here(); }
    static void set(const Mask& lanes) { here() = lanes.lanes; }
    // All other lanes leave.
    static void keep(const Mask& those) { here() &= those.lanes; }
    static void leave(int lane) { here()[lane] = 0; }
    static bool decide(const Mask& each) {
        const Mask yes = each & in(), no = ~each & in();
        if (no.none()) return yes.any();
        if (yes.none()) return false;
        const bool most = __builtin_popcount(yes.bits()) >= __builtin_popcount(no.bits());
        set(most ? yes : no);
        return most;
    }

private:
    static LaneBits& here() {
        static thread_local LaneBits own __attribute__((tls_model("initial-exec")));
        return own;
    }
};

// While this is in scope, only these lanes are in. Lanes that leave meanwhile stay out afterwards.
class OnlyLanes {
public:
    explicit OnlyLanes(const Mask& those) : before_(Lanes::in()), those_(those) { Lanes::keep(those); }
    ~OnlyLanes() { Lanes::set(before_ & (Lanes::in() | ~those_)); }
    OnlyLanes(const OnlyLanes&) = delete;
    OnlyLanes& operator=(const OnlyLanes&) = delete;

private:
    const Mask before_, those_;
};

inline Mask::operator bool() const { return Lanes::decide(*this); }

struct Pack {
    using Numbers = double __attribute__((vector_size(8 * pack_width)));
    Numbers lanes;

    Pack() = default;
    Pack(double all) : lanes(all - Numbers{}) {}  // which keeps the sign of a zero
    Pack(const Numbers& numbers) : lanes(numbers) {}
    double operator[](int lane) const { return lanes[lane]; }
    void set(int lane, double number) { lanes[lane] = number; }

    Pack& operator+=(const Pack& b) { return *this = lanes + b.lanes; }
    Pack& operator-=(const Pack& b) { return *this = lanes - b.lanes; }
    Pack& operator*=(const Pack& b) { return *this = lanes * b.lanes; }
    Pack& operator/=(const Pack& b) { return *this = lanes / b.lanes; }

    friend Pack operator-(const Pack& a) { return -a.lanes; }
    friend Pack operator+(const Pack& a, const Pack& b) { return a.lanes + b.lanes; }
    friend Pack operator-(const Pack& a, const Pack& b) { return a.lanes - b.lanes; }
    friend Pack operator*(const Pack& a, const Pack& b) { return a.lanes * b.lanes; }
    friend Pack operator/(const Pack& a, const Pack& b) { return a.lanes / b.lanes; }

    friend Mask operator<(const Pack& a, const Pack& b) { return a.lanes < b.lanes; }
    friend Mask operator>(const Pack& a, const Pack& b) { return a.lanes > b.lanes; }
    friend Mask operator<=(const Pack& a, const Pack& b) { return a.lanes <= b.lanes; }
    friend Mask operator>=(const Pack& a, const Pack& b) { return a.lanes >= b.lanes; }
    friend Mask operator==(const Pack& a, const Pack& b) { return a.lanes == b.lanes; }
    friend Mask operator!=(const Pack& a, const Pack& b) { return a.lanes != b.lanes; }
};

// a b + c, rounded once where the module does that for doubles.
[[gnu::always_inline]] inline Pack multiply_add(const Pack& a, const Pack& b, const Pack& c) {
#ifndef __FMA__
    return a * b + c;
#elif defined(__AVX512F__) && defined(__AVX512DQ__)
    return static_cast<Pack::Numbers>(_mm512_fmadd_pd(a.lanes, b.lanes, c.lanes));
#else
    return static_cast<Pack::Numbers>(_mm256_fmadd_pd(a.lanes, b.lanes, c.lanes));
#endif
}

// A pack is its own value: each lane has one.
inline const Pack& value_of(const Pack& x) { return x; }

// a in the lanes of the mask, b in the others.
inline Pack where(const Mask& mask, const Pack& a, const Pack& b) { return mask.lanes ? a.lanes : b.lanes; }

inline bool any(const Mask& mask) { return mask.any(); }

template <class Function> Pack lane_by_lane(const Pack& x, Function&& function) {
    Pack found;
    for (int k = 0; k < pack_width; ++k) found.lanes[k] = function(x.lanes[k]);
    return found;
}
template <class Function> Pack lane_by_lane(const Pack& x, const Pack& y, Function&& function) {
    Pack found;
    for (int k = 0; k < pack_width; ++k) found.lanes[k] = function(x.lanes[k], y.lanes[k]);
    return found;
}

inline Pack sqrt(const Pack& x) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
    return static_cast<Pack::Numbers>(_mm512_maskz_sqrt_pd(0xff, x.lanes));  // GCC 12 warns of the plain one
#else
    return static_cast<Pack::Numbers>(_mm256_sqrt_pd(x.lanes));
#endif
}
// A function of the standard library, lane by lane, with its bits.
template <double (*function)(double)> Pack lane_by_lane(const Pack& x) { return lane_by_lane(x, *function); }
inline Pack tan(const Pack& x) { return lane_by_lane<std::tan>(x); }
inline Pack asin(const Pack& x) { return lane_by_lane<std::asin>(x); }
inline Pack acos(const Pack& x) { return lane_by_lane<std::acos>(x); }
inline Pack atan(const Pack& x) { return lane_by_lane<std::atan>(x); }
inline Pack sinh(const Pack& x) { return lane_by_lane<std::sinh>(x); }
inline Pack cosh(const Pack& x) { return lane_by_lane<std::cosh>(x); }
inline Pack tanh(const Pack& x) { return lane_by_lane<std::tanh>(x); }
inline Pack exp(const Pack& x) { return lane_by_lane<std::exp>(x); }
inline Pack log(const Pack& x) { return lane_by_lane<std::log>(x); }
inline Pack floor(const Pack& x) { return lane_by_lane<std::floor>(x); }
inline Pack ceil(const Pack& x) { return lane_by_lane<std::ceil>(x); }
inline Pack nearbyint(const Pack& x) { return lane_by_lane<std::nearbyint>(x); }
inline Pack remainder(const Pack& x, double period) {
    return lane_by_lane(x, [=](double own) { return std::remainder(own, period); });
}
inline Pack pow(const Pack& x, double exponent) {
    return lane_by_lane(x, [=](double own) { return std::pow(own, exponent); });
}
inline Pack pow(const Pack& x, const Pack& y) {
    return lane_by_lane(x, y, [](double a, double b) { return std::pow(a, b); });
}
inline Pack atan2(const Pack& y, const Pack& x) {
    return lane_by_lane(y, x, [](double a, double b) { return std::atan2(a, b); });
}
inline Pack hypot(const Pack& x, const Pack& y) {
    return lane_by_lane(x, y, [](double a, double b) { return std::hypot(a, b); });
}
// As std::max and std::min: the first number where one is NaN.
inline Pack max(const Pack& a, const Pack& b) { return where(a < b, b, a); }
inline Pack min(const Pack& a, const Pack& b) { return where(b < a, b, a); }
inline Pack abs(const Pack& x) {
    return reinterpret_cast<Pack::Numbers>(reinterpret_cast<LaneBits>(x.lanes) &
                                           ~reinterpret_cast<LaneBits>(Pack(-0.0).lanes));
}
// The larger of two numbers; NaN where one is NaN.
inline Pack larger(const Pack& most, const Pack& value) { return where((most >= value) | (most != most), most, value); }
inline Mask isnan(const Pack& x) { return x != x; }
inline Mask isfinite(const Pack& x) { return 0.0 * x == 0.0; }

template <> constexpr bool is_pack<Pack> = true;

template <> struct BitsOf<Pack> { using Type = std::uint64_t __attribute__((vector_size(8 * pack_width))); };
inline SineAndCosine<Pack> sine_and_cosine(const Pack& x) {
    SineAndCosine<Pack> found = reduced_sine_and_cosine(x);
    if (const Mask far = ~(abs(x) <= largest_reduced); far.any())
        for (int k = 0; k < pack_width; ++k)
            if (far[k]) {
                const auto [sine, cosine] = far_sine_and_cosine(x[k]);
                found.sine.set(k, sine), found.cosine.set(k, cosine);
            }
    return found;
}

inline Pack cos(const Pack& x) { return sine_and_cosine(x).cosine; }

// x, less whole periods where |x| exceeds `most`.
inline Pack wrapped(const Pack& x, double most, double period) {
    const Mask beyond = ~(abs(x) <= most);
    if (beyond.none()) return x;
    return where(beyond, remainder(x, period), x);
}

inline Pack pick(const std::vector<Pack>& numbers, const LaneBits& at) {
    Pack found;
    for (int k = 0; k < pack_width; ++k) found.lanes[k] = numbers[at[k]].lanes[k];
    return found;
}
inline LaneBits rank(const double* first, const double* last, const Pack& value) {
    LaneBits found{};
    for (int k = 0; k < pack_width; ++k) found[k] = rank(first, last, value.lanes[k]);
    return found;
}

}  // namespace mbproj
