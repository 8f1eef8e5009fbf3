// How this extension was compiled, and whether this processor runs it.
#pragma once

#include <Eigen/Core>
#include <nanobind/nanobind.h>

#include <string>

namespace mbproj {

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
    info["instruction_set"] = MBPROJ_INSTRUCTION_SET;
    return info;
}

/// Whether this processor and its operating system run what was compiled.
inline bool runs_here() {
#if defined(MBPROJ_NEEDS_V3)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return true;
#endif
}

}  // namespace mbproj
