// How this extension was compiled, and whether the processor it runs on can do better.
#pragma once

#include <Eigen/Core>
#include <nanobind/nanobind.h>

#include <string>

namespace mbproj {

/// What the compiler was allowed to use: the processor's family, and its extensions that matter here.
inline std::string instruction_set() {
    std::string family = MBPROJ_PROCESSOR;
#if defined(__AVX512F__)
    return family + " with AVX-512";
#elif defined(__AVX2__) && defined(__FMA__)
    return family + " with AVX2 and FMA";
#else
    return family;
#endif
}

inline std::string eigen_version() {
    return std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
           std::to_string(EIGEN_MINOR_VERSION);
}

/// For `mbproj info --build`: names and values as text.
inline nanobind::dict build_info() {
    nanobind::dict info;
    info["compiler"] = MBPROJ_COMPILER;
    info["flags"] = MBPROJ_FLAGS;
    info["build_type"] = MBPROJ_BUILD_TYPE;
    info["eigen"] = eigen_version().c_str();
    info["instruction_set"] = instruction_set().c_str();
    return info;
}

/// Whether there is a second build, for AVX2 and FMA, and this processor and its operating system can run it.
inline bool runs_v3() {
#if defined(MBPROJ_HAS_V3)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return false;
#endif
}

}  // namespace mbproj
