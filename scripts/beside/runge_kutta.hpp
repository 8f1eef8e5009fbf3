// Explicit Runge-Kutta methods for the compiled right-hand sides of the benchmark: fixed steps, and error control with
// Hairer's norms and PI controller (Hairer, Norsett & Wanner 1993, II.4). The tableau comes from the caller.
#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

struct Tableau {
    int stages, estimates, error_order;
    const double *a, *b, *error;   // (s, s), (s), (estimates, s + 1)
};

template <class System>
class RungeKutta {
public:
    RungeKutta(System &system, const Tableau &tableau)
        : system_(system), tableau_(tableau), n_(system.size()), k_((tableau.stages + 1) * n_), stage_(n_), new_(n_) {}

    void fixed(double *y, double h, long steps) {
        for (long step = 0; step < steps; ++step) {
            system_.derivative(y, slope(0));
            advance(y, h);
            std::copy(new_.begin(), new_.end(), y);
        }
    }

    // Returns the number of steps, or -1 where the step became too small.
    long controlled(double *y, double duration, double tolerance) {
        const double k = tableau_.error_order + 1, integral = 0.2 / k;
        double t = 0.0, h = 1e-3 * duration, previous = 1e-4;
        bool rejected = false;
        long steps = 0;
        system_.derivative(y, slope(0));
        while (t < duration) {
            h = std::min(h, duration - t);
            if (h < 1e-14 * duration && duration - t > 1e-14 * duration) return -1;
            advance(y, h);
            system_.derivative(new_.data(), slope(tableau_.stages));
            const double error = norm(y, h, tolerance);
            if (error <= 1.0) {
                t = h == duration - t ? duration : t + h;
                std::copy(new_.begin(), new_.end(), y);
                std::copy(slope(tableau_.stages), slope(tableau_.stages) + n_, slope(0));
                const double factor = 0.9 * std::pow(std::max(error, 1e-10), 0.75 * integral - 1 / k) * std::pow(previous, integral);
                h *= std::clamp(factor, 0.2, rejected ? 1.0 : 10.0);
                previous = std::max(error, 1e-4);
                rejected = false;
                ++steps;
            } else {
                h *= std::isfinite(error) ? std::max(0.2, 0.9 * std::pow(error, 0.75 * integral - 1 / k)) : 0.2;
                rejected = true;
            }
        }
        return steps;
    }

private:
    double *slope(int stage) { return k_.data() + stage * n_; }

    void advance(const double *y, double h) {
        const int s = tableau_.stages;
        for (int i = 1; i < s; ++i) {
            combine(y, h, tableau_.a + i * s, i, stage_.data());
            system_.derivative(stage_.data(), slope(i));
        }
        combine(y, h, tableau_.b, s, new_.data());
    }

    void combine(const double *y, double h, const double *weights, int count, double *out) {
        std::copy(y, y + n_, out);
        for (int j = 0; j < count; ++j) {
            if (weights[j] == 0.0) continue;
            const double w = h * weights[j], *k = slope(j);
            for (int i = 0; i < n_; ++i) out[i] += w * k[i];
        }
    }

    double norm(const double *y, double h, double tolerance) {
        double norms[2] = {0.0, 0.0};
        for (int e = 0; e < tableau_.estimates; ++e) {
            const double *weights = tableau_.error + e * (tableau_.stages + 1);
            for (int i = 0; i < n_; ++i) {
                double estimate = 0.0;
                for (int j = 0; j <= tableau_.stages; ++j) estimate += weights[j] * slope(j)[i];
                estimate *= h / (tolerance * (1.0 + std::max(std::abs(y[i]), std::abs(new_[i]))));
                norms[e] += estimate * estimate / n_;
            }
        }
        if (tableau_.estimates < 2 || norms[0] == 0.0) return std::sqrt(norms[0]);
        return norms[0] / std::sqrt(norms[0] + 0.01 * norms[1]);
    }

    System &system_;
    const Tableau &tableau_;
    int n_;
    std::vector<double> k_, stage_, new_;
};

// The one function that each compiled system exports: runs from y in place; tolerance 0 means fixed steps.
template <class System>
long integrate(System &&system, const Tableau &tableau, double *y, double duration, long steps, double tolerance) {
    RungeKutta<std::remove_reference_t<System>> method(system, tableau);
    if (tolerance > 0.0) return method.controlled(y, duration, tolerance);
    method.fixed(y, duration / static_cast<double>(steps), steps);
    return steps;
}
