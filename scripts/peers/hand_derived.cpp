// The two mechanisms in minimal coordinates, derived by hand: what a general program cannot beat.
#include "runge_kutta.hpp"

namespace {

constexpr double gravity = 9.8;

// A chain of bars of 1 m and 1 kg in a vertical plane, in the bars' angles above the horizontal:
// sum_j c_ij (cos(p_i - p_j) p_j'' + sin(p_i - p_j) p_j'^2) = -g w_i cos p_i. State: angles, then rates.
template <int Fixed>
class Chain {
public:
    explicit Chain(int links) : n_(links), cosine_(n()), sine_(n()), matrix_(n() * n()), pivot_(n()) {}
    int size() const { return 2 * n(); }

    void derivative(const double *y, double *dy) {
        const int n = this->n();
        const double *rate = y + n;
        double *acceleration = dy + n;
        for (int i = 0; i < n; ++i) {
            cosine_[i] = std::cos(y[i]);
            sine_[i] = std::sin(y[i]);
            dy[i] = rate[i];
        }
        for (int i = 0; i < n; ++i) {
            const double outer = n - 0.5 - i;
            double right = -gravity * outer * cosine_[i];
            for (int j = 0; j < n; ++j) {
                const double coupling = j <= i ? outer : n - 0.5 - j;
                right -= coupling * (sine_[i] * cosine_[j] - cosine_[i] * sine_[j]) * rate[j] * rate[j];
                if (j < i) matrix_[i * n + j] = coupling * (cosine_[i] * cosine_[j] + sine_[i] * sine_[j]);
            }
            matrix_[i * n + i] = 1.01 / 12 + outer - 0.25;
            acceleration[i] = right;
        }
        solve(acceleration);
    }

private:
    int n() const { return Fixed > 0 ? Fixed : n_; }

    // Cholesky's L D Lᵀ in place; the rows of L are overwritten from those of the matrix.
    void solve(double *x) {
        const int n = this->n();
        for (int i = 0; i < n; ++i) {
            double *row = &matrix_[i * n], diagonal = row[i];
            for (int j = 0; j < i; ++j) {
                double sum = row[j];
                for (int k = 0; k < j; ++k) sum -= row[k] * matrix_[j * n + k];
                row[j] = sum;                                  // L_ij D_j until the row is complete
            }
            for (int j = 0; j < i; ++j) {
                const double scaled = row[j] * pivot_[j];
                diagonal -= scaled * row[j];
                row[j] = scaled;
                x[i] -= scaled * x[j];
            }
            pivot_[i] = 1.0 / diagonal;
        }
        for (int i = 0; i < n; ++i) x[i] *= pivot_[i];
        for (int i = n - 1; i >= 0; --i)
            for (int j = 0; j < i; ++j) x[j] -= matrix_[i * n + j] * x[i];
    }

    int n_;
    std::vector<double> cosine_, sine_, matrix_, pivot_;
};

// The spatial slider-crank in the crank's angle p from the vertical: A(p) p'' + A'(p) p'^2 / 2 + V'(p) = 0.
// s is the slider's place, f the angle of the universal joint about the slider's axis; the rod turns about itself by s/L f'.
struct SliderCrank {
    static constexpr double r = 0.08, L = 0.3, rod = 0.5, slider = 2.0, crank_x = 1e-4, along = 4e-4, across = 4e-3;
    static constexpr int size() { return 2; }

    static double place(double angle) {
        const double y = 0.1 - r * std::sin(angle), z = 0.12 + r * std::cos(angle);
        return std::sqrt(L * L - y * y - z * z);
    }

    void derivative(const double *state, double *out) const {
        const double sine = std::sin(state[0]), cosine = std::cos(state[0]);
        const double u = 0.1 * cosine + 0.12 * sine, w = 0.12 * cosine - 0.1 * sine;
        const double y = 0.1 - r * sine, z = 0.12 + r * cosine, square = y * y + z * z;
        const double s = std::sqrt(L * L - square), s1 = r * u / s, s2 = (r * w - s1 * s1) / s;
        const double f1 = r * (w + r) / square, f2 = (2 * f1 * s * s1 - r * u) / square;
        constexpr double common = rod / 4 + across / (L * L), spin = along / (L * L);
        const double inertia = crank_x + common * (s1 * s1 + r * r) + slider * s1 * s1 + spin * s * s * f1 * f1;
        const double half_change = (common + slider) * s1 * s2 + spin * s * f1 * (s1 * f1 + s * f2);
        out[0] = state[1];
        out[1] = (0.5 * rod * gravity * r * sine - half_change * state[1] * state[1]) / inertia;
    }
};

}  // namespace

extern "C" {

long chain(const Tableau *tableau, int links, double *y, double duration, long steps, double tolerance) {
    if (links == 5) {
        Chain<5> five(5);
        return integrate(five, *tableau, y, duration, steps, tolerance);
    }
    Chain<0> any(links);
    return integrate(any, *tableau, y, duration, steps, tolerance);
}

long slider_crank(const Tableau *tableau, double *y, double duration, long steps, double tolerance) {
    SliderCrank system;
    return integrate(system, *tableau, y, duration, steps, tolerance);
}

double slider_place(double angle) { return SliderCrank::place(angle); }

}
