// Impacts at stops by one of three laws of restitution, two of them with dry friction: the jumps of the gaps' rates. The
// reference is mbproj.dynamics.contact.impact.
#pragma once

#include "laws/friction_balance.hpp"

namespace mbproj {

// The quantity that restitution relates: the speeds, the impulses, or the energy.
enum class ImpactLaw : int { newton, poisson, energetic };

// Friction along tangents of stops that touch: each tangent's coefficient, the other tangent of its plane, and its stop.
struct Rubbing {
    std::vector<double> coefficient;
    std::vector<int> partner, by;

    Eigen::Index size() const { return static_cast<Eigen::Index>(coefficient.size()); }
};

// For stops that touch, then for their tangents: impulses, rates afterwards, and the energy that each takes.
struct Impact {
    Eigen::VectorXd impulse, after, taken;

    // With B of their rows and the rates before; what is slower than `slow` does not close, and these rows can move. False where
    // nothing that the joints allow opens the gaps, and where the law has no answer.
    bool strike(ImpactLaw law, const Eigen::MatrixXd& B, const Eigen::VectorXd& before,
                const Eigen::VectorXd& restitution, const Eigen::VectorXd& slow, const Rubbing& rubbing,
                const std::vector<bool>& moves, const Thresholds& thresholds);

private:
    using Vector = Eigen::VectorXd;

    bool newton(const Eigen::MatrixXd& B, const Vector& before, const Vector& e);
    bool poisson(const Eigen::MatrixXd& B, const Vector& before, const Vector& e);
    bool energetic(const Eigen::MatrixXd& B, const Vector& before, const Vector& e, const Vector& slow);
    bool impulses(const Eigen::MatrixXd& B, const Vector& b, const Vector& given, Vector& y) const;
    void work(const Eigen::MatrixXd& B, const Vector& before, const Vector& z);

    const Rubbing* rubbing_ = nullptr;
    const std::vector<bool>* moves_ = nullptr;
    const Thresholds* thresholds_ = nullptr;
};

}  // namespace mbproj
