// Explicit Runge-Kutta steps: the first stepper. A stepper has {attempt, error, extend, at} and says what they cost; the
// time loop, the turn counter and the step doubling know no more of it.
#pragma once

#include <optional>
#include <vector>

#include "dynamics/equations_of_motion.hpp"

namespace mbproj {

constexpr int most_stages = 32;  // with those of a continuous extension
constexpr int most_first = 300;  // times that the trial step for a first step size is shortened, tenfold each
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// The size of a first step, and whether the way ahead has limited it.
struct FirstStep {
    double h;
    bool limited;
};

template <int D> class RungeKutta {
public:
    using Vector = Eigen::VectorXd;

    RungeKutta(const Tableau& tableau, EquationsOfMotion<D>& equations, double length)
        : tableau_(tableau), equations_(equations), stage_(equations.total()), scale_(equations.size()) {
        const auto kept = tableau.stages() + (tableau.error.rows() > 0 ? 1 + tableau.extra_c.size() : 0);
        k_.assign(kept, Vector::Zero(equations.total()));
        for (int i = 0; i < equations.size(); ++i) {
            const int within = i % Size<D>::state;
            const bool is_length = within < D || (within >= Size<D>::pose && within < Size<D>::pose + D);
            scale_[i] = is_length ? length : 1.0;
        }
    }

    // The step's first stage, f(y).
    Vector& first() { return k_[0]; }

    // Evaluations that an attempt takes beyond the first stage, and an extension. An error takes one.
    int attempt_cost() const { return tableau_.stages() - 1; }
    int extend_cost() const { return static_cast<int>(tableau_.extra_c.size()); }
    int error_order() const { return tableau_.error_order; }

    // y_new from y; false where a stage has no unique accelerations.
    bool attempt(double t, const Vector& y, double h, Vector& y_new) {
        for (int s = 1; s < tableau_.stages(); ++s) {
            combine(y, h, tableau_.a.row(s), s, stage_);
            if (!equations_.watched_derivative(t + tableau_.c[s] * h, stage_.data(), k_[s].data())) return false;
        }
        combine(y, h, tableau_.b, tableau_.stages(), y_new);
        return true;
    }

    // The states at which the last step, from y at t over h, has evaluated f: visit(weight, time, state).
    template <class Visit> void quadrature(double t, const Vector& y, double h, Visit&& visit) const {
        Vector state(y.size());
        for (int s = 0; s < tableau_.stages(); ++s) {
            if (tableau_.b[s] == 0.0) continue;
            combine(y, h, tableau_.a.row(s), s, state);
            visit(tableau_.b[s], t + tableau_.c[s] * h, state);
        }
    }

    // Hairer's norm of the estimated error of the step to y_new at t: 1 is just acceptable; none where f fails there. It
    // evaluates f before any projection, as the extension needs it too.
    std::optional<double> error(double t, const Vector& y, const Vector& y_new, double h, double tolerance) {
        if (!equations_.watched_derivative(t, y_new.data(), k_[tableau_.stages()].data())) return std::nullopt;
        return norm_of_error(y, y_new, h, tolerance);
    }

    // A first step size from f and an estimate of f' (Hairer's hinit), at most `longest`; negative where f fails or
    // overflows however near to the start. Says whether `longest` has a say in it.
    FirstStep first_step(double t, const Vector& y, double tolerance, double longest) {
        const auto norm = [&](const Vector& v) {
            double sum = 0.0;
            for (int i = 0; i < equations_.size(); ++i) {
                const double part = v[i] / (tolerance * (scale_[i] + std::abs(y[i])));
                sum += part * part;
            }
            return std::sqrt(sum / equations_.size());
        };
        const double size = norm(y), speed = norm(k_[0]);
        const double wanted = std::min(size, speed) <= 1e-5 ? 1e-6 : 0.01 * size / speed;
        double h = std::min(wanted, longest), bend = not_a_number;
        Vector slope(y.size());
        for (int tried = 0; tried < most_first && !std::isfinite(bend); ++tried, h *= 0.1) {
            stage_ = y + h * k_[0];
            if (equations_.derivative(t + h, stage_.data(), slope.data())) bend = norm(slope - k_[0]) / h;
        }
        if (!std::isfinite(bend)) return {-1.0, wanted > longest};
        h *= 10.0;
        const double steepest = std::max(speed, bend);
        const double trial =
            steepest <= 1e-15 ? std::max(1e-6, h * 1e-3) : std::pow(0.01 / steepest, 1.0 / (tableau_.order + 1));
        const double found = std::min(100.0 * h, trial);
        return {std::min(found, longest), wanted > longest || found > longest};
    }

    // The extra stages of the continuous extension of the last step.
    bool extend(double t, const Vector& y, double h) {
        for (std::size_t x = 0; x < tableau_.extra_c.size(); ++x) {
            const int known = tableau_.stages() + 1 + static_cast<int>(x);
            combine(y, h, tableau_.extra_a.row(x), known, stage_);
            if (!equations_.derivative(t + tableau_.extra_c[x] * h, stage_.data(), k_[known].data())) return false;
        }
        return true;
    }

    // y(t + θ h).
    void at(const Vector& y, double h, double theta, Vector& out) const {
        std::vector<double> weights(static_cast<std::size_t>(tableau_.dense.rows()));
        for (std::size_t s = 0; s < weights.size(); ++s)
            for (Eigen::Index d = tableau_.dense.cols(); d-- > 0;)
                weights[s] = theta * (tableau_.dense(static_cast<Eigen::Index>(s), d) + weights[s]);
        combine(y, h, weights, static_cast<int>(weights.size()), out);
    }

private:
    // Of two estimates (DOP853) the combination of its authors. What is integrated beside the bodies' state (work,
    // dissipation) has no say.
    double norm_of_error(const Vector& y, const Vector& y_new, double h, double tolerance) const {
        double norms[2] = {0.0, 0.0};
        for (int e = 0; e < tableau_.error.rows(); ++e) {
            double sum = 0.0;
            for (int i = 0; i < equations_.size(); ++i) {
                double estimate = 0.0;
                for (int s = 0; s <= tableau_.stages(); ++s) estimate += tableau_.error(e, s) * k_[s][i];
                const double part =
                    h * estimate / (tolerance * (scale_[i] + std::max(std::abs(y[i]), std::abs(y_new[i]))));
                sum += part * part;
            }
            norms[e] = std::sqrt(sum / equations_.size());
        }
        if (tableau_.error.rows() == 1 || norms[0] == 0.0) return norms[0];
        return norms[0] * norms[0] / std::hypot(norms[0], 0.1 * norms[1]);
    }

    // y + h Σ w k in one pass, without the stages of no weight.
    template <class Row> void combine(const Vector& y, double h, const Row& weights, int count, Vector& out) const {
        const double* stages[most_stages];
        double factors[most_stages];
        int used = 0;
        for (int s = 0; s < count; ++s)
            if (weights[s] != 0.0) {
                stages[used] = k_[s].data();
                factors[used++] = h * weights[s];
            }
        const double* from = y.data();
        double* to = out.data();
        constexpr Eigen::Index width = 8;  // at a time, so that the sums stay in registers
        Eigen::Index i = 0;
        for (; i + width <= y.size(); i += width) {
            double sum[width] = {};
            for (int s = 0; s < used; ++s)
                for (Eigen::Index k = 0; k < width; ++k) sum[k] += factors[s] * stages[s][i + k];
            for (Eigen::Index k = 0; k < width; ++k) to[i + k] = from[i + k] + sum[k];
        }
        for (; i < y.size(); ++i) {
            double sum = 0.0;
            for (int s = 0; s < used; ++s) sum += factors[s] * stages[s][i];
            to[i] = from[i] + sum;
        }
    }

    const Tableau& tableau_;
    EquationsOfMotion<D>& equations_;
    Vector stage_, scale_;
    std::vector<Vector> k_;
};

// What the loop steps with.
template <int D> using Stepper = RungeKutta<D>;

}  // namespace mbproj
