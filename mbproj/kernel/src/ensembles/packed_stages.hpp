// Explicit Runge-Kutta steps of several cases at once, each of its own size: what `ExplicitRungeKutta` is for one case.
#pragma once

#include "ensembles/packed_equations.hpp"
#include "steppers/stepper.hpp"

namespace mbproj {

// Whether packs make the steps of this method.
inline bool fits_packs(const Tableau& tableau) { return !tableau.is_implicit() && !tableau.kinematic; }

// The smallest and the largest pivot of S over the poses of a step.
struct PackedPassed {
    Pack smallest = 1.0, largest = 0.0;
    void record(const Pack& nearness) {
        smallest = min(smallest, nearness);
        largest = max(largest, nearness);
    }
};

template <class P> class PackedStages final {
public:
    using Vector = std::vector<Pack>;

    PackedStages(const Tableau& tableau, PackedEquations<P>& equations, const Vector& scale)
        : tableau_(tableau), equations_(equations), scale_(scale), stage_(equations.model().layout.size()),
          k_(tableau.stages() + (tableau.error.rows() > 0 ? 1 + tableau.extra_c.size() : 0), Vector(stage_.size())) {}

    // The slope with which a step begins.
    Vector& first() { return k_[0]; }
    const PackedPassed& passed() const { return passed_; }
    long attempt_cost() const { return tableau_.stages() - 1; }
    long extend_cost() const { return static_cast<long>(tableau_.extra_c.size()); }
    int error_order() const { return tableau_.error_order; }

    // y_new from y at t; `here`: the nearness of y's pose to a singular one.
    void attempt(const Pack& t, const Vector& y, const Pack& h, const PackedPassed& here, Vector& y_new) {
        passed_ = here;
        for (int s = 1; s < tableau_.stages(); ++s) {
            combine(y, h, tableau_.a.row(s).data(), s, stage_);
            evaluate(t + tableau_.c[s] * h, stage_, k_[s]);
        }
        combine(y, h, tableau_.b.data(), tableau_.stages(), y_new);
    }
    // Hairer's norm of the estimated error of the last step, to y_new at t, of each lane.
    Pack error(const Pack& t, const Vector& y, const Vector& y_new, const Pack& h, const Pack& tolerance) {
        evaluate(t, y_new, k_[tableau_.stages()]);
        Pack norms[2] = {0.0, 0.0};
        const double count = static_cast<double>(scale_.size());
        for (int e = 0; e < tableau_.error.rows(); ++e) {
            Pack sum = 0.0;
            for (std::size_t i = 0; i < scale_.size(); ++i) {
                Pack estimate = 0.0;
                for (int s = 0; s <= tableau_.stages(); ++s) estimate += tableau_.error(e, s) * k_[s][i];
                const Pack part = h * estimate / (tolerance * (scale_[i] + max(abs(y[i]), abs(y_new[i]))));
                sum += part * part;
            }
            norms[e] = sqrt(sum / count);
        }
        if (tableau_.error.rows() == 1) return norms[0];
        Pack both;
        for (int k = 0; k < pack_width; ++k) {
            const double first = norms[0][k];
            both.set(k, first == 0.0 ? first : first * first / std::hypot(first, 0.1 * norms[1][k]));
        }
        return both;
    }

    // The extra stages of the continuous extension of the last step, from y at t.
    void extend(const Pack& t, const Vector& y, const Pack& h) {
        const PackedPassed of_step = passed_;
        for (std::size_t x = 0; x < tableau_.extra_c.size(); ++x) {
            const int known = tableau_.stages() + 1 + static_cast<int>(x);
            combine(y, h, tableau_.extra_a.row(x).data(), known, stage_);
            evaluate(t + tableau_.extra_c[x] * h, stage_, k_[known]);
        }
        passed_ = of_step;
    }
    // y(t + θ h).
    void at(const Vector& y, const Pack& h, const Pack& theta, Vector& out) const {
        std::vector<Pack> weights(static_cast<std::size_t>(tableau_.dense.rows()), 0.0);
        for (std::size_t s = 0; s < weights.size(); ++s)
            for (Eigen::Index d = tableau_.dense.cols(); d-- > 0;)
                weights[s] = theta * (tableau_.dense(static_cast<Eigen::Index>(s), d) + weights[s]);
        combine(y, h, weights.data(), static_cast<int>(weights.size()), out);
    }

    // The sizes of first steps of the lanes that are in, at most `longest`: see Stepper::first_step. A lane that would need a
    // shorter trial leaves.
    Pack first_step(const Pack& t, const Vector& y, const Pack& tolerance, const Pack& longest) {
        const auto norm = [&](auto&& number) {
            Pack sum = 0.0;
            for (std::size_t i = 0; i < scale_.size(); ++i) {
                const Pack part = number(i) / (tolerance * (scale_[i] + abs(y[i])));
                sum += part * part;
            }
            return sqrt(sum / static_cast<double>(scale_.size()));
        };
        const Pack size = norm([&](std::size_t i) { return y[i]; });
        const Pack speed = norm([&](std::size_t i) { return k_[0][i]; });
        const Pack wanted = where(min(size, speed) <= 1e-5, 1e-6, 0.01 * size / speed);
        Pack h = min(wanted, longest);
        for (std::size_t i = 0; i < y.size(); ++i) stage_[i] = y[i] + h * k_[0][i];
        Vector slope(y.size());
        evaluate(t + h, stage_, slope);
        const Pack bend = norm([&](std::size_t i) { return slope[i] - k_[0][i]; }) / h;
        Lanes::keep(isfinite(bend));
        h = 0.1 * h * 10.0;
        const Pack steepest = max(speed, bend);
        Pack found;
        for (int k = 0; k < pack_width; ++k) {
            const double trial = steepest[k] <= 1e-15 ? std::max(1e-6, h[k] * 1e-3)
                                                      : std::pow(0.01 / steepest[k], 1.0 / (tableau_.order + 1));
            found.set(k, std::min(std::min(100.0 * h[k], trial), longest[k]));
        }
        return found;
    }

private:
    void evaluate(const Pack& t, const Vector& y, Vector& slope) {
        equations_.derivative(t, y.data(), slope.data(), [this](const Pack& nearness) { passed_.record(nearness); });
    }
    // y + h Σ w k, without the stages of no weight.
    template <class Weight>
    void combine(const Vector& y, const Pack& h, const Weight* weights, int count, Vector& out) const {
        const Pack* stages[most_stages];
        Pack factors[most_stages];
        int used = 0;
        for (int s = 0; s < count; ++s) {
            if constexpr (std::is_same_v<Weight, double>)
                if (weights[s] == 0.0) continue;
            stages[used] = k_[s].data();
            factors[used++] = h * weights[s];
        }
        for (std::size_t i = 0; i < y.size(); ++i) {
            Pack sum = 0.0;
            for (int s = 0; s < used; ++s) sum += factors[s] * stages[s][i];
            out[i] = sum + y[i];
        }
    }

    const Tableau& tableau_;
    PackedEquations<P>& equations_;
    const Vector& scale_;  // of the numbers with error control
    Vector stage_;
    std::vector<Vector> k_;  // y' at the stages
    PackedPassed passed_;
};

}  // namespace mbproj
