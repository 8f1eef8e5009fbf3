// Rolling bodies, and bodies that slide on an edge: the height of a wheel, and slip, a component of the relative velocity of two
// bodies at their contact. The definitions are those of mbproj.joints.primitives.table: wheel_height, ellipsoid and slip.
#pragma once

#include <cmath>

#include "model/model.hpp"

namespace mbproj {

// An ellipsoid with the axes b[0..2] on a plane with the normal n: its lowest point is at -below from its centre, at the depth
// `reach`.
template <class D> struct Ellipsoid {
    Scalar<D> along[3], square[3], reach = 0.0;
    Point<D> below = Point<D>::Zero();

    Ellipsoid(const Instance<D>& p, const Point<D>& n, const Point<D>* b) {
        for (int k = 0; k < 3; ++k) {
            square[k] = p.parameters[k] * p.parameters[k];
            along[k] = n.dot(b[k]);
            reach += square[k] * along[k] * along[k];
        }
        reach = sqrt(reach);
        for (int k = 0; k < 3; ++k) below += square[k] * along[k] / reach * b[k];
    }
    Scalar<D> share(int k) const { return square[k] * along[k] / reach; }
};

namespace slip {
// The slots, of body 1 and of body 2.
enum : int { p1, x1, y1, z1, p2, x2, y2, z2 };

// The contact point from p2, the direction e of the row, and the rates of both.
template <class D> struct Contact {
    Point<D> arm, e, arm_dot = Point<D>::Zero(), e_dot = Point<D>::Zero();
};

// The direction a × n in which a wheel rolls that turns about its axis a on a plane with the normal n. In the plane the axis is
// normal to it, on the side of x × y.
template <class S> inline Column<3, S> rolls_along(const Column<3, S>* x) { return x[z2].cross(x[z1]); }
template <class S> inline Column<2, S> rolls_along(const Column<2, S>* x) {
    return turned_by(moment(x[x2], x[y2]), x[z1]);
}
template <class S> inline Column<3, S> rolls_along_dot(const Column<3, S>* x, const Column<3, S>* v) {
    return v[z2].cross(x[z1]) + x[z2].cross(v[z1]);
}
template <class S> inline Column<2, S> rolls_along_dot(const Column<2, S>* x, const Column<2, S>* v) {
    return turned_by(moment(x[x2], x[y2]), v[z1]);
}

// The lowest point of a wheel, and the direction in which it rolls.
template <class D> Contact<D> wheel_contact(const Instance<D>& p, const Point<D>* x, const Point<D>* v) {
    const Scalar<D> R = p.parameters[0];
    Contact<D> at;
    const Point<D> along = rolls_along(x);
    const Scalar<D> length = along.norm();
    at.e = along / length;
    if constexpr (D::axes == 3)
        at.arm = R * x[z2].cross(at.e);
    else
        at.arm = -R * x[z1];
    if (!v) return at;
    const Point<D> rate = rolls_along_dot(x, v);
    at.e_dot = (rate - at.e * at.e.dot(rate)) / length;
    if constexpr (D::axes == 3)
        at.arm_dot = R * (v[z2].cross(at.e) + x[z2].cross(at.e_dot));
    else
        at.arm_dot = -R * v[z1];
    return at;
}

// The contact of an instance at slots x with the velocities v, or without rates where v is null.
template <class D> Contact<D> contact(const Instance<D>& p, const Point<D>* x, const Point<D>* v) {
    Contact<D> at{Point<D>::Zero(), Point<D>::Zero()};
    switch (p.kind) {
        case Kind::wheel_slip_along: return wheel_contact<D>(p, x, v);
        case Kind::wheel_slip_across:
            if constexpr (D::axes == 3) {
                at = wheel_contact<D>(p, x, v);
                if (v) at.e_dot = v[z1].cross(at.e) + x[z1].cross(at.e_dot);
                at.e = x[z1].cross(at.e);
            }
            break;
        case Kind::ball_slip:
            at.arm = -p.parameters[0] * x[z1];
            at.e = x[x1];
            if (v) at.arm_dot = -p.parameters[0] * v[z1], at.e_dot = v[x1];
            break;
        case Kind::ellipsoid_slip: {
            const Ellipsoid<D> own(p, x[z1], x + x2);
            at.arm = -own.below;
            at.e = x[x1];
            if (!v) break;
            at.e_dot = v[x1];
            Scalar<D> rate[3], stretch = 0.0;
            for (int k = 0; k < 3; ++k) {
                rate[k] = v[z1].dot(x[x2 + k]) + x[z1].dot(v[x2 + k]);
                stretch += own.share(k) * rate[k];
            }
            for (int k = 0; k < 3; ++k)
                at.arm_dot -= (own.square[k] * rate[k] - own.share(k) * stretch) / own.reach * x[x2 + k] +
                              own.share(k) * v[x2 + k];
            break;
        }
        default:
            at.e = x[z2];
            if (v) at.e_dot = v[z2];
    }
    return at;
}

template <class D> void gradient(const Instance<D>& p, const Point<D>* x, Point<D>* g) {
    const Contact<D> at = contact<D>(p, x, nullptr);
    const Point<D> away = x[p2] + at.arm - x[p1];
    g[p1] = -at.e;
    g[p2] = at.e;
    for (int k = 1; k <= 3; ++k) {
        g[p1 + k] = -away.dot(x[p1 + k]) * at.e;
        g[p2 + k] = at.arm.dot(x[p2 + k]) * at.e;
    }
}

template <class D> Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* v) {
    const Contact<D> at = contact<D>(p, x, v);
    const Point<D> away = x[p2] + at.arm - x[p1], away_dot = v[p2] + at.arm_dot - v[p1];
    Point<D> passing = v[p2] - v[p1], bend = Point<D>::Zero();
    for (int k = 1; k <= 3; ++k) {
        passing += at.arm.dot(x[p2 + k]) * v[p2 + k] - away.dot(x[p1 + k]) * v[p1 + k];
        bend += (at.arm_dot.dot(x[p2 + k]) + at.arm.dot(v[p2 + k])) * v[p2 + k] -
                (away_dot.dot(x[p1 + k]) + away.dot(v[p1 + k])) * v[p1 + k];
    }
    return at.e_dot.dot(passing) + at.e.dot(bend);
}
}  // namespace slip

// Slots: a point and the normal of the plane, the wheel's centre and axis. In the plane the wheel stands upright, and its height
// is reduced by its radius.
namespace wheel_height {
template <class S> inline Column<3, S> across(const Column<3, S>* x) { return x[1].cross(x[3]); }

template <class D> Scalar<D> value(const Instance<D>& p, const Point<D>* x) {
    const Scalar<D> height = x[1].dot(x[2] - x[0]);
    if constexpr (D::axes == 3)
        return height - p.parameters[0] * across(x).norm();
    else
        return height - p.parameters[0];
}
template <class D> void gradient(const Instance<D>& p, const Point<D>* x, Point<D>* g) {
    g[0] = -x[1];
    g[1] = x[2] - x[0];
    g[2] = x[1];
    g[3].setZero();
    if constexpr (D::axes == 3) {
        const Point<D> unit = p.parameters[0] * across(x).normalized();
        g[1] -= x[3].cross(unit);
        g[3] = -unit.cross(x[1]);
    }
}
template <class D> Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* v) {
    const Scalar<D> moved = 2.0 * v[1].dot(v[2] - v[0]);
    if constexpr (D::axes == 3) {
        const Point<D> c = across(x), rate = v[1].cross(x[3]) + x[1].cross(v[3]);
        const Scalar<D> length = c.norm(), stretch = c.dot(rate) / length;
        const Scalar<D> bend = rate.squaredNorm() + 2.0 * c.dot(v[1].cross(v[3])) - stretch * stretch;
        return moved - p.parameters[0] * bend / length;
    } else {
        return moved;
    }
}
}  // namespace wheel_height

// Slots: a point and the normal of the plane, the ellipsoid's centre and axes.
namespace ellipsoid_height {
template <class D> Scalar<D> value(const Instance<D>& p, const Point<D>* x) {
    return x[1].dot(x[2] - x[0]) - Ellipsoid<D>(p, x[1], x + 3).reach;
}
template <class D> void gradient(const Instance<D>& p, const Point<D>* x, Point<D>* g) {
    const Ellipsoid<D> own(p, x[1], x + 3);
    g[0] = -x[1];
    g[1] = x[2] - x[0] - own.below;
    g[2] = x[1];
    for (int k = 0; k < 3; ++k) g[3 + k] = -own.share(k) * x[1];
}
template <class D> Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* v) {
    const Ellipsoid<D> own(p, x[1], x + 3);
    Scalar<D> bend = 0.0, stretch = 0.0;
    for (int k = 0; k < 3; ++k) {
        const Scalar<D> rate = v[1].dot(x[3 + k]) + x[1].dot(v[3 + k]);
        bend += own.square[k] * (rate * rate + 2.0 * own.along[k] * v[1].dot(v[3 + k]));
        stretch += own.share(k) * rate;
    }
    return 2.0 * v[1].dot(v[2] - v[0]) - (bend - stretch * stretch) / own.reach;
}
}  // namespace ellipsoid_height

// These functions are not inlined: most mechanisms do not roll, and pay only for their own rows.
namespace rolling {
template <class D> [[gnu::noinline, gnu::cold]] Scalar<D> value(const Instance<D>& p, const Point<D>* x) {
    if (is_slip(p.kind)) return 0.0;
    return p.kind == Kind::wheel_height ? wheel_height::value<D>(p, x) : ellipsoid_height::value<D>(p, x);
}
template <class D> [[gnu::noinline, gnu::cold]] void gradient(const Instance<D>& p, const Point<D>* x, Point<D>* g) {
    if (is_slip(p.kind)) return slip::gradient<D>(p, x, g);
    p.kind == Kind::wheel_height ? wheel_height::gradient<D>(p, x, g) : ellipsoid_height::gradient<D>(p, x, g);
}
template <class D>
[[gnu::noinline, gnu::cold]] Scalar<D> curvature(const Instance<D>& p, const Point<D>* x, const Point<D>* v) {
    if (is_slip(p.kind)) return slip::curvature<D>(p, x, v);
    return p.kind == Kind::wheel_height ? wheel_height::curvature<D>(p, x, v) : ellipsoid_height::curvature<D>(p, x, v);
}
}  // namespace rolling

}  // namespace mbproj
