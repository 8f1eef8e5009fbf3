// The kinds of constraint primitives in the kernel, their names, and their properties. What each of them is says its
// class in Python, which mbproj.joints.primitives.table names.
#pragma once

#include <algorithm>

#include "model/rope_path.hpp"

namespace mbproj {

// A coupling is none of them: it is a sum of instances of these. The order counts: tests of a kind below are ranges of
// it, and `forms` has the same order.
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
    const char* name;  // in the table of Python
    int slots;         // the number of points and vectors of bodies on which the primitive acts
    int parameters;    // the number of its constants, such as a radius
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
// The sizes of arrays that serve all kinds; at least 1, because no array is empty.
constexpr int most(int Form::* number) {
    int largest = 1;
    for (const Form& form : forms) largest = std::max(largest, form.*number);
    return largest;
}
constexpr int most_slots = most(&Form::slots), most_parameters = most(&Form::parameters);
// Whether the row is at velocity level, G v = 0 without a C: its value is 0, and its gradient is that of no function.
constexpr bool is_slip(Kind kind) { return kind >= Kind::wheel_slip_along; }
// Whether a pose gives the value only up to whole turns, which the run counts.
constexpr bool is_angle(Kind kind) { return kind == Kind::angle || kind == Kind::lap; }
// Whether it is a distance from a curve. Its foot, the nearest point, stays on one piece of the curve during a step.
constexpr bool is_held(Kind kind) {
    return kind == Kind::profile || kind == Kind::face || kind == Kind::two_curves || kind == Kind::beside_first;
}
// Whether it is of two curves that touch.
constexpr bool is_of_two(Kind kind) { return kind >= Kind::two_curves && kind <= Kind::slip_of_two; }
// Whether its curve is a space curve.
constexpr bool is_in_space(Kind kind) { return kind >= Kind::beside_first && kind <= Kind::space_arc; }

}  // namespace mbproj
