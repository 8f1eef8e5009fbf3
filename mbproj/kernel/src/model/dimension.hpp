// Vectors, arms and orientations of the plane (D = 2) and of space (D = 3), so that everything above is written once.
#pragma once

#include "algebra/operators.hpp"

namespace mbproj {

// Sizes: `turns` axes to turn about, `freedoms` of a body, `orientation` numbers (θ, or Euler parameters Λ), and the
// state of a body: r, orientation, r' in global axes, ω in body axes.
template <int D> struct Size {
    static constexpr int turns = D == 2 ? 1 : 3;
    static constexpr int freedoms = D + turns;
    static constexpr int orientation = D == 2 ? 1 : 4;
    static constexpr int pose = D + orientation;
    static constexpr int state = pose + freedoms;
};

template <int D> using Point = Column<D>;
template <int D> using Turn = Column<Size<D>::turns>;
template <int D> using Rotation = Matrix<D, D>;

// Velocity ω × s of a point at s, and moment s × f of a force there.
inline Column<3> turned_by(const Column<3>& omega, const Column<3>& s) { return omega.cross(s); }
inline Column<2> turned_by(const Column<1>& omega, const Column<2>& s) { return {-omega[0] * s.y(), omega[0] * s.x()}; }

inline Column<3> moment(const Column<3>& s, const Column<3>& f) { return s.cross(f); }
inline Column<1> moment(const Column<2>& s, const Column<2>& f) { return Column<1>(s.x() * f.y() - s.y() * f.x()); }

// L of Eq. 13: ω = 2 L Λ' in body axes.
inline Matrix<3, 4> matrix_L(const Column<4>& p) {
    Matrix<3, 4> L;
    L << -p[1], p[0], p[3], -p[2], -p[2], -p[3], p[0], p[1], -p[3], p[2], -p[1], p[0];
    return L;
}

// E: ω = 2 E Λ' in global axes.
inline Matrix<3, 4> matrix_E(const Column<4>& p) {
    Matrix<3, 4> E;
    E << -p[1], p[0], -p[3], p[2], -p[2], p[3], p[0], -p[1], -p[3], -p[2], p[1], p[0];
    return E;
}

// The rotation of an orientation. Stages of a step leave |Λ| = 1 by their truncation error; the division keeps A orthogonal.
inline Rotation<3> rotation(const Column<4>& p) {
    const double s = 2.0 / p.squaredNorm();
    const double xx = s * p[1] * p[1], yy = s * p[2] * p[2], zz = s * p[3] * p[3];
    const double xy = s * p[1] * p[2], xz = s * p[1] * p[3], yz = s * p[2] * p[3];
    const double wx = s * p[0] * p[1], wy = s * p[0] * p[2], wz = s * p[0] * p[3];
    Rotation<3> A;
    A << 1 - yy - zz, xy - wz, xz + wy, xy + wz, 1 - xx - zz, yz - wx, xz - wy, yz + wx, 1 - xx - yy;
    return A;
}
inline Rotation<2> rotation(const Column<1>& angle) {
    const double c = std::cos(angle[0]), s = std::sin(angle[0]);
    Rotation<2> A;
    A << c, -s, s, c;
    return A;
}

// How fast the orientation changes with ω in body axes: Λ' = ½ Lᵀ ω, or θ' = ω.
inline Column<4> orientation_rate(const Column<4>& p, const Column<3>& omega) {
    return 0.5 * matrix_L(p).transpose() * omega;
}
inline Column<1> orientation_rate(const Column<1>&, const Column<1>& omega) { return omega; }

// The orientation p with p - g p' = base, where p' = orientation_rate(p, ω): base ⊗ (1 + gω/2) / (1 + |gω/2|²).
inline Column<4> orientation_ahead(const Column<4>& base, const Column<3>& omega, double g) {
    return (base + g * orientation_rate(base, omega)) / (1.0 + 0.25 * g * g * omega.squaredNorm());
}
inline Column<1> orientation_ahead(const Column<1>& base, const Column<1>& omega, double g) { return base + g * omega; }

// ω in body axes that belongs to Λ': 2 L Λ' / |Λ|².
inline Column<3> omega_of(const Column<4>& p, const Column<4>& rate) {
    return (2.0 / p.squaredNorm()) * (matrix_L(p) * rate);
}
inline Column<1> omega_of(const Column<1>&, const Column<1>& rate) { return rate; }

// δθ in global axes that belongs to δΛ.
inline Column<3> turn_of(const Column<4>& p, const Column<4>& by) {
    return (2.0 / p.squaredNorm()) * (matrix_E(p) * by);
}
inline Column<1> turn_of(const Column<1>&, const Column<1>& by) { return by; }

// An angular velocity in body axes from the global ones, and back; in the plane they are one.
inline Column<3> to_body(const Rotation<3>& A, const Column<3>& omega) { return A.transpose() * omega; }
inline Column<1> to_body(const Rotation<2>&, const Column<1>& omega) { return omega; }
inline Column<3> to_global(const Rotation<3>& A, const Column<3>& omega) { return A * omega; }
inline Column<1> to_global(const Rotation<2>&, const Column<1>& omega) { return omega; }

// The orientation turned by a small δθ in global axes and normalised: Λ + ½ Eᵀ δθ, or θ + δθ within [-2π, 2π]: two turns,
// because Λ changes its sign with one, and what is recorded must not jump.
inline Column<4> turned(const Column<4>& p, const Column<3>& by) {
    return (p + 0.5 * matrix_E(p).transpose() * by).normalized();
}
inline Column<4> normalised(const Column<4>& p) { return p.normalized(); }
inline Column<1> normalised(const Column<1>& angle) {
    return std::abs(angle[0]) <= 2.0 * M_PI ? angle : Column<1>(std::remainder(angle[0], 4.0 * M_PI));
}
inline Column<1> turned(const Column<1>& angle, const Column<1>& by) { return normalised(Column<1>(angle + by)); }

// J in global axes.
inline Matrix<3, 3> inertia_in_global(const Rotation<3>& A, const Matrix<3, 3>& J) { return A * J * A.transpose(); }
inline Matrix<1, 1> inertia_in_global(const Rotation<2>&, const Matrix<1, 1>& J) { return J; }

// The larger of two values; not a number where one of them is none, which std::max would pass over.
inline double larger(double most, double value) { return most >= value || most != most ? most : value; }

}  // namespace mbproj
