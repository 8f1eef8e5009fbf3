// One explicit Runge-Kutta step, its error estimate, and its continuous extension, from a tableau's coefficients.
#pragma once

#include <vector>

#include "dynamics.hpp"

namespace mbproj {

template <int D> class RungeKutta {
public:
    using Vector = Eigen::VectorXd;

    RungeKutta(const Tableau& tableau, Dynamics<D>& dynamics, double length)
        : tableau_(tableau), dynamics_(dynamics), stage_(dynamics.size()), scale_(dynamics.size()) {
        const auto kept = tableau.stages() + (tableau.error.rows() > 0 ? 1 + tableau.extra_c.size() : 0);
        k_.assign(kept, Vector::Zero(dynamics.size()));
        for (int i = 0; i < dynamics.size(); ++i) {
            const int within = i % Size<D>::state;
            const bool is_length = within < D || (within >= Size<D>::pose && within < Size<D>::pose + D);
            scale_[i] = is_length ? length : 1.0;
        }
    }

    // The step's first stage, f(y).
    Vector& first() { return k_[0]; }

    // y_new from y; false where a stage has no unique accelerations.
    bool step(const Vector& y, double h, Vector& y_new) {
        for (int s = 1; s < tableau_.stages(); ++s) {
            combine(y, h, tableau_.a.row(s), s, stage_);
            if (!dynamics_.derivative(stage_.data(), k_[s].data())) return false;
        }
        y_new = y;
        for (int s = 0; s < tableau_.stages(); ++s)
            if (tableau_.b[s] != 0.0) y_new.noalias() += (h * tableau_.b[s]) * k_[s];
        return true;
    }

    // f at the new point, before any projection, for the estimate and the extension.
    bool last(const Vector& y_new) { return dynamics_.derivative(y_new.data(), k_[tableau_.stages()].data()); }

    // Hairer's norm of the estimated error: 1 is just acceptable. Of two estimates (DOP853) the combination of its authors.
    double error(const Vector& y, const Vector& y_new, double h, double tolerance) const {
        double norms[2] = {0.0, 0.0};
        for (int e = 0; e < tableau_.error.rows(); ++e) {
            double sum = 0.0;
            for (int i = 0; i < y.size(); ++i) {
                double estimate = 0.0;
                for (int s = 0; s <= tableau_.stages(); ++s) estimate += tableau_.error(e, s) * k_[s][i];
                const double part = h * estimate / (tolerance * (scale_[i] + std::max(std::abs(y[i]), std::abs(y_new[i]))));
                sum += part * part;
            }
            norms[e] = std::sqrt(sum / static_cast<double>(y.size()));
        }
        if (tableau_.error.rows() == 1 || norms[0] == 0.0) return norms[0];
        return norms[0] * norms[0] / std::hypot(norms[0], 0.1 * norms[1]);
    }

    // A first step size from f and an estimate of f' (Hairer's hinit), at most `longest`; negative where f fails.
    double first_step(const Vector& y, double tolerance, double longest) {
        const auto norm = [&](const Vector& v) {
            double sum = 0.0;
            for (int i = 0; i < v.size(); ++i) {
                const double part = v[i] / (tolerance * (scale_[i] + std::abs(y[i])));
                sum += part * part;
            }
            return std::sqrt(sum / static_cast<double>(v.size()));
        };
        const double size = norm(y), speed = norm(k_[0]);
        const double h = std::min(std::min(size, speed) <= 1e-5 ? 1e-6 : 0.01 * size / speed, longest);
        stage_ = y + h * k_[0];
        Vector slope(y.size());
        if (!dynamics_.derivative(stage_.data(), slope.data())) return -1.0;
        const double steepest = std::max(speed, norm(slope - k_[0]) / h);
        const double trial =
            steepest <= 1e-15 ? std::max(1e-6, h * 1e-3) : std::pow(0.01 / steepest, 1.0 / (tableau_.order + 1));
        return std::min({100.0 * h, trial, longest});
    }

    // The extra stages of the continuous extension of the last step.
    bool extend(const Vector& y, double h) {
        for (std::size_t x = 0; x < tableau_.extra_c.size(); ++x) {
            const int known = tableau_.stages() + 1 + static_cast<int>(x);
            combine(y, h, tableau_.extra_a.row(x), known, stage_);
            if (!dynamics_.derivative(stage_.data(), k_[known].data())) return false;
        }
        return true;
    }

    // y(t + θ h).
    void at(const Vector& y, double h, double theta, Vector& out) const {
        out = y;
        for (int s = 0; s < tableau_.dense.rows(); ++s) {
            double weight = 0.0;
            for (Eigen::Index d = tableau_.dense.cols(); d-- > 0;) weight = theta * (tableau_.dense(s, d) + weight);
            if (weight != 0.0) out.noalias() += (h * weight) * k_[s];
        }
    }

private:
    template <class Row> void combine(const Vector& y, double h, const Row& weights, int count, Vector& out) const {
        out = y;
        for (int s = 0; s < count; ++s)
            if (weights[s] != 0.0) out.noalias() += (h * weights[s]) * k_[s];
    }

    const Tableau& tableau_;
    Dynamics<D>& dynamics_;
    Vector stage_, scale_;
    std::vector<Vector> k_;
};

}  // namespace mbproj
