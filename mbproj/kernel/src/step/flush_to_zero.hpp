// Numbers below 1e-308 become zero while this is in scope: decaying quantities (motion out of a plane, say) would
// otherwise be computed a hundred times slower, and no digit of a result depends on them.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace mbproj {

class FlushToZero {
public:
#if defined(__SSE2__)
    FlushToZero() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040u); }
    ~FlushToZero() { _mm_setcsr(before_); }
#else
    FlushToZero() = default;
#endif
    FlushToZero(const FlushToZero&) = delete;
    FlushToZero& operator=(const FlushToZero&) = delete;

protected:
#if defined(__SSE2__)
    explicit FlushToZero(unsigned clears) : before_(_mm_getcsr()) { _mm_setcsr(before_ & ~clears); }
#else
    explicit FlushToZero(unsigned) {}
#endif

private:
#if defined(__SSE2__)
    unsigned before_;
#endif
};

// Keeps these numbers, inside the scope of a FlushToZero.
class KeepDenormals : FlushToZero {
public:
    KeepDenormals() : FlushToZero(0x8040u) {}
};

}  // namespace mbproj
