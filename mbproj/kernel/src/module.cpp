// The Python module, `_core` or `_core_v3`: names and types at the border; the work is in the headers.
#include "build_info.hpp"

NB_MODULE(MBPROJ_MODULE, module) {
    module.def("build_info", &mbproj::build_info, "How this extension was compiled.");
    module.def("runs_v3", &mbproj::runs_v3, "Whether the build for AVX2 and FMA exists and this processor runs it.");
}
