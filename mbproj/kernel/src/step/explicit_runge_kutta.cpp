#include "step/explicit_runge_kutta.hpp"

namespace mbproj {

bool ExplicitRungeKutta::attempt(double t, const Vector& y, double h, Vector& y_new) {
    for (int s = 1; s < tableau_.stages(); ++s) {
        combine(y, h, tableau_.a.row(s), s, stage_);
        if (!equations_.watched_derivative(t + tableau_.c[s] * h, stage_.data(), k_[s].data())) return false;
    }
    combine(y, h, tableau_.b, tableau_.stages(), y_new);
    return true;
}

void ExplicitRungeKutta::quadrature(double t, const Vector& y, double h, const Visit& visit) const {
    Vector state(y.size());
    for (int s = 0; s < tableau_.stages(); ++s) {
        if (tableau_.b[s] == 0.0) continue;
        combine(y, h, tableau_.a.row(s), s, state);
        visit(tableau_.b[s], t + tableau_.c[s] * h, state);
    }
}

std::optional<double> ExplicitRungeKutta::error(double t, const Vector& y, const Vector& y_new, double h,
                                                double tolerance, bool) {
    if (!equations_.watched_derivative(t, y_new.data(), k_[tableau_.stages()].data())) return std::nullopt;
    return norm_of_error(y, y_new, h, tolerance);
}

bool ExplicitRungeKutta::extend(double t, const Vector& y, double h) {
    for (std::size_t x = 0; x < tableau_.extra_c.size(); ++x) {
        const int known = tableau_.stages() + 1 + static_cast<int>(x);
        combine(y, h, tableau_.extra_a.row(x), known, stage_);
        if (!equations_.derivative(t + tableau_.extra_c[x] * h, stage_.data(), k_[known].data())) return false;
    }
    return true;
}

double ExplicitRungeKutta::norm_of_error(const Vector& y, const Vector& y_new, double h, double tolerance) const {
    double norms[2] = {0.0, 0.0};
    for (int e = 0; e < tableau_.error.rows(); ++e) {
        double sum = 0.0;
        for (int i = 0; i < layout_.controlled(); ++i) {
            double estimate = 0.0;
            for (int s = 0; s <= tableau_.stages(); ++s) estimate += tableau_.error(e, s) * k_[s][i];
            const double part =
                h * estimate / (tolerance * (layout_.scale[i] + std::max(std::abs(y[i]), std::abs(y_new[i]))));
            sum += part * part;
        }
        norms[e] = std::sqrt(sum / layout_.controlled());
    }
    return combined(norms);
}

}  // namespace mbproj
