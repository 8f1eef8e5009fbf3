// Functions and curves of a scene from records.
#pragma once

#include "bind/record.hpp"
#include "model/plane_curve.hpp"
#include "model/programs.hpp"
#include "model/rope_path.hpp"
#include "model/space_curve.hpp"

namespace mbproj {

Programs programs_of(Record& given);
RopePath rope_path_of(Record& given);

}  // namespace mbproj
