// The kinds of constraint primitives in the kernel, their names, and their properties. What each of them is says its
// class in Python, which mbproj.joints.primitives.table names.
#pragma once

#include <algorithm>

#include "model/rope_path.hpp"

namespace mbproj {

// A coupling is none of them: it is a sum of instances of these. `forms` has the same order.
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
    enum Is : unsigned {
        slip = 1,     // at velocity level, G v = 0 without a C: its value is 0, and its gradient is that of no function
        angle = 2,    // a pose gives the value only up to whole turns, which the run counts
        on_line = 4,  // it follows a curve
        held = 8,     // a distance from a curve: its foot, the nearest point, stays on one piece of the curve in a step
        on_face = 16,   // a flat face touches the curve
        of_two = 32,    // two curves touch
        in_space = 64,  // its curve is a space curve
    };
    const char* name;  // in the table of Python
    int slots;         // the number of points and vectors of bodies on which the primitive acts
    int parameters;    // the number of its constants, such as a radius
    unsigned is = 0;   // what it is
};
constexpr Form forms[] = {{"coincident", 2, 0},
                          {"perpendicular", 2, 0},
                          {"along", 3, 0},
                          {"distance", 2, 0},
                          {"angle", 3, 0, Form::angle},
                          {"wheel_height", 4, 1},
                          {"ellipsoid_height", 6, 3},
                          {"profile", 4, 2, Form::on_line | Form::held},
                          {"arc", 4, 0, Form::on_line},
                          {"lap", 4, 2, Form::on_line | Form::angle},
                          {"face", 5, 0, Form::on_line | Form::on_face | Form::held},
                          {"face_place", 5, 0, Form::on_line | Form::on_face},
                          {"face_slip", 5, 0, Form::on_line | Form::on_face},
                          {"two_curves", 5, 3, Form::on_line | Form::of_two | Form::held},
                          {"place_on_first", 5, 2, Form::on_line | Form::of_two},
                          {"place_on_second", 5, 2, Form::on_line | Form::of_two},
                          {"slip_of_two", 5, 2, Form::on_line | Form::of_two},
                          {"beside_first", 5, 0, Form::on_line | Form::in_space | Form::held},
                          {"beside_second", 5, 0, Form::on_line | Form::in_space},
                          {"space_arc", 5, 0, Form::on_line | Form::in_space},
                          {"rope", most_rope_slots, 0},
                          {"wheel_slip_along", 8, 1, Form::slip},
                          {"wheel_slip_across", 8, 1, Form::slip},
                          {"ball_slip", 8, 1, Form::slip},
                          {"ellipsoid_slip", 8, 3, Form::slip},
                          {"edge_slip", 8, 0, Form::slip}};
constexpr const Form& form_of(Kind kind) { return forms[static_cast<int>(kind)]; }
// The sizes of arrays that serve all kinds; at least 1, because no array is empty.
constexpr int most(int Form::* number) {
    int largest = 1;
    for (const Form& form : forms) largest = std::max(largest, form.*number);
    return largest;
}
constexpr int most_slots = most(&Form::slots), most_parameters = most(&Form::parameters);
constexpr bool is(Form::Is property, Kind kind) { return (form_of(kind).is & property) != 0; }
constexpr bool is_slip(Kind kind) { return is(Form::slip, kind); }
constexpr bool is_angle(Kind kind) { return is(Form::angle, kind); }
constexpr bool is_held(Kind kind) { return is(Form::held, kind); }
constexpr bool is_on_face(Kind kind) { return is(Form::on_face, kind); }
constexpr bool is_of_two(Kind kind) { return is(Form::of_two, kind); }
constexpr bool is_in_space(Kind kind) { return is(Form::in_space, kind); }

}  // namespace mbproj
