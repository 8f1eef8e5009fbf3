// Hamilton's equations of mechanisms in minimal coordinates, derived by hand: what a general program cannot beat. They run
// with explicit Runge-Kutta methods, and with Gauss's collocation, which is symplectic: Hairer, Lubich & Wanner, Geometric
// Numerical Integration (2006), II.1.3 and VIII.6.
#include <limits>

#include "runge_kutta.hpp"

namespace {

// Hamilton's equations of one degree of freedom, H = p²/(2 I) + V, of a class that gives I, I' and V' at q.
template <class Real, class Linkage> struct OneDegree {
    static int size() { return 2; }
    static void derivative(const Real *y, Real *dy) {
        Real inertia, slope, pull;
        Linkage::template at<Real>(y[0], inertia, slope, pull);
        dy[0] = y[1] / inertia;
        dy[1] = slope * dy[0] * dy[0] / 2 - pull;
    }
};

// mechanisms/planar_four_bar.yaml by the crank's angle.
struct CrankRocker {
    template <class Real> static void at(Real phi, Real &inertia, Real &slope, Real &pull) {
        constexpr Real a = 0.1L, b = 0.3L, c = 0.25L, d = 0.3L, g = 9.81L, m1 = 2, m2 = 0.3L, m3 = 0.25L;
        constexpr Real J1 = 0.01L, J2 = 2.4e-3L, J3 = 1.3e-3L;
        const Real cosine = std::cos(phi), sine = std::sin(phi), x = d - a * cosine, z = -a * sine;
        const Real span2 = x * x + z * z;
        const Real psi = std::atan2(z, x) + std::acos((b * b + span2 - c * c) / (2 * b * std::sqrt(span2)));
        const Real chi = std::atan2(a * sine + b * std::sin(psi), a * cosine + b * std::cos(psi) - d);
        const Real s = std::sin(psi - chi), k = std::cos(psi - chi);
        const Real p1 = a * std::sin(chi - phi) / (b * s), c1 = a * std::sin(psi - phi) / (c * s);
        const Real p2 = (a * std::cos(chi - phi) * (c1 - 1) - b * p1 * k * (p1 - c1)) / (b * s);
        const Real c2 = (a * std::cos(psi - phi) * (p1 - 1) - c * c1 * k * (p1 - c1)) / (c * s);
        const Real cross = a * b * std::cos(phi - psi), rod = J2 + m2 * b * b / 4, last = J3 + m3 * c * c / 4;
        inertia = J1 + m1 * a * a / 4 + rod * p1 * p1 + m2 * (a * a + cross * p1) + last * c1 * c1;
        slope = 2 * rod * p1 * p2 + m2 * (cross * p2 - a * b * std::sin(phi - psi) * (1 - p1) * p1) + 2 * last * c1 * c2;
        pull = g * (m1 * a / 2 * cosine + m2 * (a * cosine + b / 2 * std::cos(psi) * p1) + m3 * c / 2 * std::cos(chi) * c1);
    }
};

// mechanisms/spatial_slider_crank.yaml by the crank's angle from the vertical: s is the slider's place, f the angle of the
// universal joint about the slider's axis; the rod turns about itself by s/L f'.
struct SliderCrank {
    template <class Real> static void at(Real p, Real &inertia, Real &slope, Real &pull) {
        constexpr Real r = 0.08L, L = 0.3L, rod = 0.5L, slider = 2, crank = 1e-4L, along = 4e-4L, across = 4e-3L, g = 9.8L;
        const Real sine = std::sin(p), cosine = std::cos(p), a = 0.1L, h = 0.12L;
        const Real u = a * cosine + h * sine, w = h * cosine - a * sine, y = a - r * sine, z = h + r * cosine;
        const Real square = y * y + z * z, s = std::sqrt(L * L - square);
        const Real s1 = r * u / s, s2 = (r * w - s1 * s1) / s, f1 = r * (w + r) / square;
        const Real f2 = (2 * f1 * s * s1 - r * u) / square;
        constexpr Real common = rod / 4 + across / (L * L), spin = along / (L * L);
        inertia = crank + common * (s1 * s1 + r * r) + slider * s1 * s1 + spin * s * s * f1 * f1;
        slope = 2 * (common + slider) * s1 * s2 + 2 * spin * s * f1 * (s1 * f1 + s * f2);
        pull = -rod * g * r * sine / 2;
    }
};

// Uniform bars of 1 m and 1 kg in a row, by their angles from hanging down; J is about a bar's centre. `Fixed`: so many of
// them, which the compiler may unroll; 0: n. `work` has n (n + 3) numbers.
template <class Real, int Fixed = 0> struct Chain {
    int n;
    Real J, g;
    mutable std::vector<Real> work;
    int bars() const { return Fixed > 0 ? Fixed : n; }
    int size() const { return 2 * bars(); }
    void derivative(const Real *y, Real *dy) const {
        const int n = bars();
        Real *c = work.data(), *s = c + n, *row = s + n, *m = row + n;
        for (int i = 0; i < n; ++i) c[i] = std::cos(y[i]), s[i] = std::sin(y[i]), dy[i] = y[n + i];
        for (int i = 0; i < n; ++i) {  // L D Lᵀ: m holds L below its diagonal, and 1 / D there
            Real diagonal = J + n - i - Real(0.75L);
            for (int j = 0; j < i; ++j) {
                Real sum = (n - i - Real(0.5L)) * (c[i] * c[j] + s[i] * s[j]);
                for (int k = 0; k < j; ++k) sum -= row[k] * m[j * n + k];
                row[j] = sum;
            }
            for (int j = 0; j < i; ++j) {
                m[i * n + j] = row[j] * m[j * n + j];
                diagonal -= m[i * n + j] * row[j];
                dy[i] -= m[i * n + j] * dy[j];
            }
            m[i * n + i] = 1 / diagonal;
        }
        for (int i = 0; i < n; ++i) dy[i] *= m[i * n + i];
        for (int i = n - 1; i >= 0; --i)
            for (int j = 0; j < i; ++j) dy[j] -= m[i * n + j] * dy[i];
        for (int i = 0; i < n; ++i) dy[n + i] = -g * (n - i - Real(0.5L)) * s[i];
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < i; ++j) {
                const Real pull = (n - i - Real(0.5L)) * (s[i] * c[j] - c[i] * s[j]) * dy[i] * dy[j];
                dy[n + i] -= pull, dy[n + j] += pull;
            }
    }
};

// A heavy symmetric top by Euler's angles θ, φ, ψ and their momenta: A across through the pivot, C along, weight m g l.
template <class Real> struct Top {
    Real A, C, weight;
    static int size() { return 6; }
    void derivative(const Real *y, Real *dy) const {
        const Real c = std::cos(y[0]), s = std::sin(y[0]), u = (y[4] - y[5] * c) / (A * s * s);
        dy[0] = y[3] / A, dy[1] = u, dy[2] = y[5] / C - u * c;
        dy[3] = u * (A * u * c - y[5]) * s + weight * s, dy[4] = dy[5] = 0;
    }
};

template <class Real> struct Collocation {
    int s;
    std::vector<Real> c, b, a, next;  // `next`: what the last polynomial gives at the next step's points

    explicit Collocation(int stages) : s(stages), c(s), b(s), a(s * s), next(s * s) {
        for (int i = 0; i < s; ++i) {
            Real x = std::cos(std::acos(Real(-1)) * (s - i - Real(0.25L)) / (s + Real(0.5L))), slope = 1;
            for (int round = 0; round < 100; ++round) {
                Real p = 1, before = 0;
                for (int k = 1; k <= s; ++k) {
                    const Real older = before;
                    before = p, p = ((2 * k - 1) * x * before - (k - 1) * older) / k;
                }
                slope = s * (x * p - before) / (x * x - 1);
                x -= p / slope;
            }
            c[i] = (1 + x) / 2, b[i] = 1 / ((1 - x * x) * slope * slope);
        }
        for (int i = 0; i < s; ++i)
            for (int j = 0; j < s; ++j) {
                a[i * s + j] = integral(j, c[i]);
                next[i * s + j] = integral(j, 1 + c[i]) - b[j];
            }
    }
    Real integral(int j, Real to) const {  // of Lagrange's polynomial j, from 0
        Real sum = 0;
        for (int k = 0; k < s; ++k) {
            Real product = b[k];
            for (int l = 0; l < s; ++l)
                if (l != j) product *= (to * c[k] - c[l]) / (c[j] - c[l]);
            sum += product;
        }
        return to * sum;
    }
};

// y after so many steps, in place; evaluations. Stages by fixed-point iteration until round-off; sums are compensated.
template <class Real, class System> double gauss(const System &system, int stages, Real h, long steps, Real *y) {
    const int n = system.size(), s = stages;
    const Collocation<Real> method(s);
    std::vector<Real> f(s * n), z(s * n), other(s * n), lost(n);
    double evaluations = 1;
    system.derivative(y, f.data());
    for (int i = 1; i < s; ++i) std::copy_n(f.data(), n, &f[i * n]);
    const auto apply = [&](const std::vector<Real> &by, std::vector<Real> &to) {
        for (int i = 0; i < s; ++i)
            for (int k = 0; k < n; ++k) {
                Real sum = 0;
                for (int j = 0; j < s; ++j) sum += by[i * s + j] * f[j * n + k];
                to[i * n + k] = h * sum;
            }
    };
    std::vector<Real> at(n);
    for (long step = 0; step < steps; ++step) {
        apply(step ? method.next : method.a, z);
        Real last = std::numeric_limits<Real>::infinity();
        for (int round = 0; round < 60; ++round) {
            for (int i = 0; i < s; ++i) {
                for (int k = 0; k < n; ++k) at[k] = y[k] + z[i * n + k];
                system.derivative(at.data(), &f[i * n]);
            }
            evaluations += s;
            apply(method.a, other);
            Real change = 0;
            for (int k = 0; k < s * n; ++k) change = std::max(change, std::abs(other[k] - z[k]));
            z.swap(other);
            if (change == 0 || (change >= last && round > 2)) break;
            last = change;
        }
        for (int k = 0; k < n; ++k) {
            Real sum = lost[k];
            for (int j = 0; j < s; ++j) sum += h * method.b[j] * f[j * n + k];
            const Real before = y[k];
            y[k] = before + sum, lost[k] = sum - (y[k] - before);
        }
    }
    return evaluations;
}

// Calls `run` with the system of a number, which takes up to three numbers.
template <class Real, class Run> auto with(int which, const double *parts, const Run &run) {
    if (which == 0) return run(OneDegree<Real, CrankRocker>{});
    if (which == 1) return run(OneDegree<Real, SliderCrank>{});
    if (which == 2) return run(Top<Real>{Real(parts[0]), Real(parts[1]), Real(parts[2])});
    const int n = static_cast<int>(parts[0]);
    if (n == 5) return run(Chain<Real, 5>{n, Real(parts[1]), Real(parts[2]), std::vector<Real>(40)});
    return run(Chain<Real>{n, Real(parts[1]), Real(parts[2]), std::vector<Real>(n * (n + 3))});
}

}  // namespace

extern "C" {

long advance(const Tableau *tableau, int which, const double *parts, double *y, double duration, long steps, double tolerance) {
    return with<double>(which, parts, [&](const auto &system) {
        return integrate(system, *tableau, y, duration, steps, tolerance);
    });
}

double gauss_double(int which, const double *parts, int stages, double h, long steps, double *y) {
    return with<double>(which, parts, [&](const auto &system) { return gauss(system, stages, h, steps, y); });
}

// The same in extended precision; h is span / steps.
double gauss_extended(int which, const double *parts, int stages, double span, long steps, double *y) {
    return with<long double>(which, parts, [&](const auto &system) {
        std::vector<long double> state(y, y + system.size());
        const double evaluations = gauss(system, stages, (long double)span / steps, steps, state.data());
        std::copy(state.begin(), state.end(), y);
        return evaluations;
    });
}
}
