// Vectors, lever arms and orientations in the plane and in space, so that all other code is written once for both.
#pragma once

#include "model/operators.hpp"

namespace mbproj {

// The dimension D of all templates: the number of axes, and the type of the numbers.
template <int Axes, class Number> struct Dimension {
    static constexpr int axes = Axes;
    using Scalar = Number;
};
template <class Number> using Plane = Dimension<2, Number>;
template <class Number> using Space = Dimension<3, Number>;
template <class D> using Scalar = typename D::Scalar;

// The sizes of a body: `turns` axes of rotation, `freedoms`, `orientation` numbers (θ, or Euler parameters Λ), and `state`: r,
// orientation, r' in global axes, ω in body axes.
template <class D> struct Size {
    static constexpr int turns = D::axes == 2 ? 1 : 3;
    static constexpr int freedoms = D::axes + turns;
    static constexpr int orientation = D::axes == 2 ? 1 : 4;
    static constexpr int pose = D::axes + orientation;
    static constexpr int state = pose + freedoms;
};

template <class D> using Point = Column<D::axes, Scalar<D>>;
template <class D> using Turn = Column<Size<D>::turns, Scalar<D>>;
template <class D> using Orientation = Column<Size<D>::orientation, Scalar<D>>;
template <class D> using Rotation = Matrix<D::axes, D::axes, Scalar<D>>;
template <class D> using TurnMatrix = Matrix<Size<D>::turns, Size<D>::turns, Scalar<D>>;

// Velocity ω × s of a point at s, and moment s × f of a force there. Always inline: a compiler that leaves these out of line in
// a large unit makes a step in space a sixth longer.
template <class S>
[[gnu::always_inline]] inline Column<3, S> turned_by(const Column<3, S>& omega, const Column<3, S>& s) {
    return omega.cross(s);
}
template <class S>
[[gnu::always_inline]] inline Column<2, S> turned_by(const Column<1, S>& omega, const Column<2, S>& s) {
    return {-omega[0] * s.y(), omega[0] * s.x()};
}

template <class S> [[gnu::always_inline]] inline Column<3, S> moment(const Column<3, S>& s, const Column<3, S>& f) {
    return s.cross(f);
}
template <class S> [[gnu::always_inline]] inline Column<1, S> moment(const Column<2, S>& s, const Column<2, S>& f) {
    return Column<1, S>(s.x() * f.y() - s.y() * f.x());
}

// L of Eq. 13: ω = 2 L Λ' in body axes.
template <class S> inline Matrix<3, 4, S> matrix_L(const Column<4, S>& p) {
    Matrix<3, 4, S> L;
    L << -p[1], p[0], p[3], -p[2], -p[2], -p[3], p[0], p[1], -p[3], p[2], -p[1], p[0];
    return L;
}

// E: ω = 2 E Λ' in global axes.
template <class S> inline Matrix<3, 4, S> matrix_E(const Column<4, S>& p) {
    Matrix<3, 4, S> E;
    E << -p[1], p[0], -p[3], p[2], -p[2], p[3], p[0], -p[1], -p[3], -p[2], p[1], p[0];
    return E;
}

// The rotation of an orientation. Stages of a step leave |Λ| = 1 by their truncation error; the division keeps A orthogonal.
template <class S> inline Matrix<3, 3, S> rotation(const Column<4, S>& p) {
    const S s = 2.0 / p.squaredNorm();
    const S xx = s * p[1] * p[1], yy = s * p[2] * p[2], zz = s * p[3] * p[3];
    const S xy = s * p[1] * p[2], xz = s * p[1] * p[3], yz = s * p[2] * p[3];
    const S wx = s * p[0] * p[1], wy = s * p[0] * p[2], wz = s * p[0] * p[3];
    Matrix<3, 3, S> A;
    A << 1 - yy - zz, xy - wz, xz + wy, xy + wz, 1 - xx - zz, yz - wx, xz - wy, yz + wx, 1 - xx - yy;
    return A;
}
template <class S> inline Matrix<2, 2, S> rotation(const Column<1, S>& angle) {
    const auto [s, c] = sine_and_cosine(angle[0]);
    Matrix<2, 2, S> A;
    A << c, -s, s, c;
    return A;
}

// The rate of the orientation from ω in body axes: Λ' = ½ Lᵀ ω, or θ' = ω.
template <class S> inline Column<4, S> orientation_rate(const Column<4, S>& p, const Column<3, S>& omega) {
    return 0.5 * matrix_L(p).transpose() * omega;
}
template <class S> inline Column<1, S> orientation_rate(const Column<1, S>&, const Column<1, S>& omega) {
    return omega;
}

// The orientation p with p - g p' = base, where p' = orientation_rate(p, ω): base ⊗ (1 + gω/2) / (1 + |gω/2|²).
template <class S>
inline Column<4, S> orientation_ahead(const Column<4, S>& base, const Column<3, S>& omega, const S& g) {
    return (base + g * orientation_rate(base, omega)) / (1.0 + 0.25 * g * g * omega.squaredNorm());
}
template <class S>
inline Column<1, S> orientation_ahead(const Column<1, S>& base, const Column<1, S>& omega, const S& g) {
    return base + g * omega;
}

// ω in body axes that belongs to Λ': 2 L Λ' / |Λ|².
template <class S> inline Column<3, S> omega_of(const Column<4, S>& p, const Column<4, S>& rate) {
    return (2.0 / p.squaredNorm()) * (matrix_L(p) * rate);
}
template <class S> inline Column<1, S> omega_of(const Column<1, S>&, const Column<1, S>& rate) { return rate; }

// δθ in global axes that belongs to δΛ.
template <class S> inline Column<3, S> turn_of(const Column<4, S>& p, const Column<4, S>& by) {
    return (2.0 / p.squaredNorm()) * (matrix_E(p) * by);
}
template <class S> inline Column<1, S> turn_of(const Column<1, S>&, const Column<1, S>& by) { return by; }

// Angular velocities from global to body axes, and back; in the plane both are the same.
template <class S> inline Column<3, S> to_body(const Matrix<3, 3, S>& A, const Column<3, S>& omega) {
    return A.transpose() * omega;
}
template <class S> inline Column<1, S> to_body(const Matrix<2, 2, S>&, const Column<1, S>& omega) { return omega; }
template <class S> inline Column<3, S> to_global(const Matrix<3, 3, S>& A, const Column<3, S>& omega) {
    return A * omega;
}
template <class S> inline Column<1, S> to_global(const Matrix<2, 2, S>&, const Column<1, S>& omega) { return omega; }

// The orientation turned by a small δθ in global axes and normalised: Λ + ½ Eᵀ δθ, or θ + δθ within [-2π, 2π]: two turns,
// because Λ changes its sign with one, and recorded angles must not jump.
template <class S> inline Column<4, S> turned(const Column<4, S>& p, const Column<3, S>& by) {
    return (p + 0.5 * matrix_E(p).transpose() * by).normalized();
}
template <class S> inline Column<4, S> normalised(const Column<4, S>& p) { return p.normalized(); }
template <class S> inline Column<1, S> normalised(const Column<1, S>& angle) {
    return Column<1, S>(wrapped(angle[0], 2.0 * M_PI, 4.0 * M_PI));
}
template <class S> inline Column<1, S> turned(const Column<1, S>& angle, const Column<1, S>& by) {
    return normalised(Column<1, S>(angle + by));
}

// J in global axes.
template <class S> inline Matrix<3, 3, S> inertia_in_global(const Matrix<3, 3, S>& A, const Matrix<3, 3, S>& J) {
    return A * J * A.transpose();
}
template <class S> inline Matrix<1, 1, S> inertia_in_global(const Matrix<2, 2, S>&, const Matrix<1, 1, S>& J) {
    return J;
}

// The larger of two values; NaN where one of them is NaN, which std::max would ignore.
template <class S> inline S larger(S most, S value) { return most >= value || most != most ? most : value; }

}  // namespace mbproj
