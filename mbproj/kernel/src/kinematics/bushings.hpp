// Bushings, as in mbproj.equations.forces: elastic elements between two frames. Their coordinates are seen from the
// frame midway between both.
#pragma once

#include "kinematics/pose.hpp"

namespace mbproj {

// F = preload - stiffness s - c s' along the translation and the rotation vector from frame 1 to frame 2. c is `damping`; its
// rotational part acts on the relative angular velocity. In the plane the coordinates are two components and an angle; `map`
// takes them to the coordinates in space, whose others stay constant.
template <class D> struct Bushing {
    static constexpr int coordinates = Size<D>::freedoms;
    int body[2];
    Point<D> origin[2];   // of the frames, in the axes of their bodies
    Rotation<D> turn[2];  // from the frames to their bodies
    Matrix<coordinates, coordinates, Scalar<D>> stiffness, damping;
    Column<coordinates, Scalar<D>> preload;
    Matrix<6, coordinates, Scalar<D>> map;
    bool turns_freely;  // the force does not depend on the rotation
    bool sees_pose;     // the damping along the coordinates depends on the pose
};

// The frame after half of the rotation between two frames. `rotation` is the vector φ with φ' = H (ω2 - ω1), `turning` is H⁻¹.
// The midway frame turns with ½ (ω1 + ω2) - ½ lead × (ω2 - ω1), all in its axes. `cosine` is that of half the angle.
template <class D> struct Midway {
    Rotation<D> axes;
    Turn<D> rotation, lead;
    Matrix<Size<D>::turns, Size<D>::turns, Scalar<D>> H, turning;
    Scalar<D> cosine;
};

template <class S> inline Midway<Space<S>> midway(const Matrix<3, 3, S>& first, const Matrix<3, 3, S>& second) {
    const Matrix<3, 3, S> R = first.transpose() * second;
    const Column<3, S> skew(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
    const S trace = R.trace();
    S cosine = 0.5 * sqrt(max(1.0 + trace, 0.0));
    Column<3, S> sines = skew / (4.0 * max(cosine, 0.5));
    if (cosine < 0.5) {  // divide by the largest of them: the cosine may vanish
        const int i = R(0, 0) > R(1, 1) ? (R(0, 0) > R(2, 2) ? 0 : 2) : (R(1, 1) > R(2, 2) ? 1 : 2);
        const S size = (skew[i] < 0.0 ? -2.0 : 2.0) * sqrt(1.0 + 2.0 * R(i, i) - trace);
        cosine = skew[i] / size;
        for (int k = 0; k < 3; ++k) sines[k] = (R(i, k) + R(k, i) + (k == i ? 1.0 - trace : 0.0)) / size;
    }
    const S square = sines.squaredNorm(), sine = sqrt(square);
    const auto turns = square > 0.0;
    const S longer = turns ? atan2(sine, cosine) / sine : S(1.0);
    const S along = turns ? (1.0 - longer) / square : S(0.0);
    Column<4, S> half;
    half << 1.0 + cosine, sines;
    Midway<Space<S>> found;
    found.axes = first * mbproj::rotation(half);
    found.rotation = 2.0 * longer * sines;
    found.lead = sines / (1.0 + cosine);
    const Matrix<3, 3, S> square_part = along * (sines * sines.transpose());
    found.H = longer * Matrix<3, 3, S>::Identity() + square_part;
    found.turning = (Matrix<3, 3, S>::Identity() - square_part) / longer;
    found.cosine = cosine;
    return found;
}

template <class S> inline Midway<Plane<S>> midway(const Matrix<2, 2, S>& first, const Matrix<2, 2, S>& second) {
    const Matrix<2, 2, S> R = first.transpose() * second;
    const S angle = atan2(R(1, 0), R(0, 0));
    return {Rotation<Plane<S>>(first * mbproj::rotation(Column<1, S>(0.5 * angle))),
            Turn<Plane<S>>(angle),
            Turn<Plane<S>>(0.0),
            Matrix<1, 1, S>(1.0),
            Matrix<1, 1, S>(1.0),
            cos(0.5 * angle)};
}

template <class S> inline Column<3, S> across(const Column<3, S>& a, const Column<3, S>& b) { return a.cross(b); }
template <class S> inline Column<1, S> across(const Column<1, S>&, const Column<1, S>&) { return Column<1, S>(0.0); }

// The coordinates of a bushing at a pose.
template <class D> class Deflection {
public:
    using Coordinates = Column<Bushing<D>::coordinates, Scalar<D>>;

    Deflection(const Bushing<D>& bushing, const Pose<D>& pose)
        : bushing_(bushing),
          arm_{pose[bushing.body[0]].rotation * bushing.origin[0], pose[bushing.body[1]].rotation * bushing.origin[1]},
          midway_(midway(Rotation<D>(pose[bushing.body[0]].rotation * bushing.turn[0]),
                         Rotation<D>(pose[bushing.body[1]].rotation * bushing.turn[1]))) {
        const Point<D> between = pose[bushing.body[1]].position + arm_[1] - pose[bushing.body[0]].position - arm_[0];
        x_ = midway_.axes.transpose() * between;
    }

    Scalar<D> cosine() const { return midway_.cosine; }

    // c: the damping c_r of the relative angular velocity is H⁻¹ c_r H⁻¹ along φ.
    Matrix<Bushing<D>::coordinates, Bushing<D>::coordinates, Scalar<D>> damping() const {
        constexpr int turns = Size<D>::turns;
        Matrix<Bushing<D>::coordinates, Bushing<D>::coordinates, Scalar<D>> found = bushing_.damping;
        const Matrix<turns, turns, Scalar<D>> own = found.template block<turns, turns>(D::axes, D::axes);
        found.template block<turns, turns>(D::axes, D::axes) = midway_.turning * own * midway_.turning;
        return found;
    }

    Coordinates value() const {
        Coordinates s;
        s << x_, midway_.rotation;
        return s;
    }

    // s' from velocities and angular velocities of the bodies in global axes.
    template <class Velocity, class Omega> Coordinates rate(const Velocity& velocity, const Omega& omega) const {
        Point<D> apart = Point<D>::Zero();
        Turn<D> turning[2];
        for (int side = 0; side < 2; ++side) {
            const Turn<D> w = omega(bushing_.body[side]);
            const Point<D> end = velocity(bushing_.body[side]) + turned_by(w, arm_[side]);
            apart += side == 0 ? Point<D>(-end) : end;
            turning[side] = to_body(midway_.axes, w);
        }
        const Turn<D> relative = turning[1] - turning[0];
        const Turn<D> own = 0.5 * (turning[0] + turning[1]) - 0.5 * across(midway_.lead, relative);
        Coordinates found;
        found << midway_.axes.transpose() * apart - turned_by(own, x_), midway_.H * relative;
        return found;
    }

    // ∂s'/∂(r', ω) for one body in global axes: a column for each freedom.
    Matrix<Bushing<D>::coordinates, Size<D>::freedoms, Scalar<D>> gradient(int body) const {
        Matrix<Bushing<D>::coordinates, Size<D>::freedoms, Scalar<D>> found;
        for (int c = 0; c < Size<D>::freedoms; ++c) {
            const auto velocity = [&](int b) {
                return b == body && c < D::axes ? Point<D>(Point<D>::Unit(c)) : Point<D>(Point<D>::Zero());
            };
            const auto omega = [&](int b) {
                return b == body && c >= D::axes ? Turn<D>(Turn<D>::Unit(c - D::axes)) : Turn<D>(Turn<D>::Zero());
            };
            found.col(c) = rate(velocity, omega);
        }
        return found;
    }

    // Adds forces `along` the coordinates: forces and moments on both bodies about their centres of mass, global axes.
    void pull(const Coordinates& along, std::vector<Point<D>>& force, std::vector<Turn<D>>& torque) const {
        const Point<D> local = along.template head<D::axes>(), push = midway_.axes * local;
        const Turn<D> shared = -moment(x_, local);
        const Turn<D> relative = midway_.H * along.template tail<Size<D>::turns>() - 0.5 * across(shared, midway_.lead);
        for (int side = 0; side < 2; ++side) {
            const Scalar<D> sign = side == 0 ? -1.0 : 1.0;
            const int body = bushing_.body[side];
            force[body] += sign * push;
            torque[body] += to_global(midway_.axes, Turn<D>(0.5 * shared + sign * relative)) +
                            moment(arm_[side], Point<D>(sign * push));
        }
    }

private:
    const Bushing<D>& bushing_;
    Point<D> arm_[2], x_;
    Midway<D> midway_;
};

}  // namespace mbproj
