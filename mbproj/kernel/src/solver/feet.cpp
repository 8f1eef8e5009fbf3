#include "solver/feet.hpp"

namespace mbproj {

void Feet::hold(std::vector<ContactFoot> feet, std::size_t rows) {
    feet_ = std::move(feet), jammed_ = -1;
    any_ = std::any_of(feet_.begin(), feet_.end(), [](const ContactFoot& foot) { return !foot.rubs.empty(); });
    P_.setZero(static_cast<Eigen::Index>(feet_.size()), static_cast<Eigen::Index>(rows));
    for (std::size_t f = 0; f < feet_.size(); ++f)
        for (const auto& [row, part] : feet_[f].parts)
            P_(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(row)) = part;
}

bool Feet::is_unique(const SemidefiniteCholesky& factor, const Matrix& E) {
    jammed_ = -1;
    const auto feet = P_.rows();
    Matrix left = Matrix::Identity(feet, feet);
    Vector z;
    for (Eigen::Index f = 0; f < feet; ++f) {
        factor.solve(E.col(f), z);
        left.col(f) -= (P_ * z).cwiseMax(0.0);
    }
    const Vector x = solved(left, Vector::Ones(feet));
    if (x.allFinite() && x.minCoeff() > 0.0) return true;
    Eigen::Index worst = -1;
    for (Eigen::Index f = 0; f < feet; ++f)
        if (!feet_[static_cast<std::size_t>(f)].rubs.empty() && (worst < 0 || left(f, f) < left(worst, worst)))
            worst = f;
    jammed_ = feet_[static_cast<std::size_t>(worst)].rubs.front().law;
    return false;
}

}  // namespace mbproj
