// The kinds of constraint primitives in the kernel, their names, and their properties.
#pragma once

#include <algorithm>

#include "model/rope_path.hpp"

namespace mbproj {

// The primitives of the kernel: their names in mbproj.joints.primitives.table, and the number of points and vectors and of parameters of
// each. Couplings are sums of instances of these.
enum class Kind : int {
    coincident,
    perpendicular,
    along,
    distance,
    angle,
    wheel_height,
    ellipsoid_height,
    profile,
    arc,
    lap,
    face,
    face_place,
    face_slip,
    two_curves,
    place_on_first,
    place_on_second,
    slip_of_two,
    beside_first,
    beside_second,
    space_arc,
    rope,
    wheel_slip_along,
    wheel_slip_across,
    ball_slip,
    ellipsoid_slip,
    edge_slip,
};
struct Form {
    const char* name;
    int slots, parameters;
};
constexpr Form forms[] = {{"coincident", 2, 0},
                          {"perpendicular", 2, 0},
                          {"along", 3, 0},
                          {"distance", 2, 0},
                          {"angle", 3, 0},
                          {"wheel_height", 4, 1},
                          {"ellipsoid_height", 6, 3},
                          {"profile", 4, 2},
                          {"arc", 4, 0},
                          {"lap", 4, 2},
                          {"face", 5, 0},
                          {"face_place", 5, 0},
                          {"face_slip", 5, 0},
                          {"two_curves", 5, 3},
                          {"place_on_first", 5, 2},
                          {"place_on_second", 5, 2},
                          {"slip_of_two", 5, 2},
                          {"beside_first", 5, 0},
                          {"beside_second", 5, 0},
                          {"space_arc", 5, 0},
                          {"rope", most_rope_slots, 0},
                          {"wheel_slip_along", 8, 1},
                          {"wheel_slip_across", 8, 1},
                          {"ball_slip", 8, 1},
                          {"ellipsoid_slip", 8, 3},
                          {"edge_slip", 8, 0}};
constexpr const Form& form_of(Kind kind) { return forms[static_cast<int>(kind)]; }
constexpr int most(int Form::* of) {
    int found = 1;  // no array is empty
    for (const Form& form : forms) found = std::max(found, form.*of);
    return found;
}
constexpr int most_slots = most(&Form::slots), most_parameters = most(&Form::parameters);
// Whether the row is at velocity level: then its value is 0, and its gradient is not the gradient of a function.
constexpr bool is_slip(Kind kind) { return kind >= Kind::wheel_slip_along; }
// Whether the value is known only up to whole turns, which are counted.
constexpr bool is_angle(Kind kind) { return kind == Kind::angle || kind == Kind::lap; }
// Whether it is a distance from a curve, whose foot stays on one piece of the curve.
constexpr bool is_held(Kind kind) {
    return kind == Kind::profile || kind == Kind::face || kind == Kind::two_curves || kind == Kind::beside_first;
}
// Whether it concerns two curves that touch.
constexpr bool is_of_two(Kind kind) { return kind >= Kind::two_curves && kind <= Kind::slip_of_two; }
// Whether its curve is a space curve.
constexpr bool is_in_space(Kind kind) { return kind >= Kind::beside_first && kind <= Kind::space_arc; }

}  // namespace mbproj
