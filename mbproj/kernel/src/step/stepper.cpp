#include "step/stepper.hpp"

namespace mbproj {

void Stepper::at(const Vector& y, double h, double theta, Vector& out) const {
    std::vector<double> weights(static_cast<std::size_t>(tableau_.dense.rows()));
    for (std::size_t s = 0; s < weights.size(); ++s)
        for (Eigen::Index d = tableau_.dense.cols(); d-- > 0;)
            weights[s] = theta * (tableau_.dense(static_cast<Eigen::Index>(s), d) + weights[s]);
    combine(y, h, weights, static_cast<int>(weights.size()), out);
}

FirstStep Stepper::first_step(double t, const Vector& y, const Vector& slope, double tolerance, double longest) {
    const auto norm = [&](const Vector& v) {
        double sum = 0.0;
        for (int i = 0; i < layout_.controlled(); ++i) {
            const double part = v[i] / (tolerance * (layout_.scale[i] + std::abs(y[i])));
            sum += part * part;
        }
        return std::sqrt(sum / layout_.controlled());
    };
    const double size = norm(y), speed = norm(slope);
    const double wanted = std::min(size, speed) <= 1e-5 ? 1e-6 : 0.01 * size / speed;
    double h = std::min(wanted, longest), bend = not_a_number;
    Vector ahead(y.size());
    for (int tried = 0; tried < most_first && !std::isfinite(bend); ++tried, h *= 0.1) {
        stage_ = y + h * slope;
        if (equations_.derivative(t + h, stage_.data(), ahead.data())) bend = norm(ahead - slope) / h;
    }
    if (!std::isfinite(bend)) return {-1.0, wanted > longest};
    h *= 10.0;
    const double steepest = std::max(speed, bend);
    const double trial =
        steepest <= 1e-15 ? std::max(1e-6, h * 1e-3) : std::pow(0.01 / steepest, 1.0 / (tableau_.order + 1));
    const double found = std::min(100.0 * h, trial);
    return {std::min(found, longest), wanted > longest || found > longest};
}

std::vector<double> Stepper::dense_rates(double theta) const {
    std::vector<double> weights(static_cast<std::size_t>(tableau_.dense.rows()));
    for (std::size_t s = 0; s < weights.size(); ++s)
        for (Eigen::Index d = tableau_.dense.cols(); d-- > 0;)
            weights[s] =
                theta * weights[s] + static_cast<double>(d + 1) * tableau_.dense(static_cast<Eigen::Index>(s), d);
    return weights;
}

}  // namespace mbproj
