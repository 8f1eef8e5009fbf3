// Finds the library of packs, in the folder beside the module, by what this processor runs.
#include "ensembles/ensemble.hpp"

#if defined(__x86_64__) && !defined(_WIN32)
#include <dlfcn.h>

#include <string>
#endif

namespace mbproj {

#if defined(__x86_64__) && !defined(_WIN32)

namespace {

const PackLibrary* loaded(const std::string& path) {
    void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return nullptr;
    const auto* found = static_cast<const PackLibrary*>(dlsym(library, "mbproj_packs"));
    const PackLibrary own{};
    const bool fits = found != nullptr && found->plane_case == own.plane_case && found->space_case == own.space_case;
    return fits ? found : nullptr;
}

const PackLibrary* widest() {
    Dl_info module{};
    if (dladdr(reinterpret_cast<void*>(&widest), &module) == 0) return nullptr;
    const std::string file = module.dli_fname, folder = file.substr(0, file.rfind('/') + 1) + "packs/";
    const PackLibrary* found = nullptr;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) found = loaded(folder + "avx512.so");
    if (found == nullptr && __builtin_cpu_supports("avx2")) found = loaded(folder + "avx2.so");
    return found;
}

}  // namespace

const PackLibrary* packs() {
    static const PackLibrary* const found = widest();
    return found;
}

#else

const PackLibrary* packs() { return nullptr; }

#endif

}  // namespace mbproj
