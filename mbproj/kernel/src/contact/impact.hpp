// Impacts at stops by one of three laws of restitution, with dry friction: the jumps of the gaps' rates. No stop pulls, and none is
// passed.
#pragma once

#include "contact/friction_balance.hpp"
#include "contact/impulse_path.hpp"

namespace mbproj {

// The quantity that restitution relates: the speeds, the impulses, or the energy.
enum class ImpactLaw : int { newton, poisson, energetic };
constexpr ImpactLaw impact_laws[] = {ImpactLaw::newton, ImpactLaw::poisson, ImpactLaw::energetic};

// The result of a law: done; or no motion that the joints allow ends the closing of gaps.
enum class Strike : int { done, driven_into };

// For stops that touch, then for their tangents: impulses, rates afterwards, and the energy that each takes.
struct Impact {
    Eigen::VectorXd impulse, after, taken;

    // From B of these rows and the rates before. Gaps slower than `slow` do not close; `moves`: the rows that can move.
    Strike strike(ImpactLaw law, const Eigen::MatrixXd& B, const Eigen::VectorXd& before,
                  const Eigen::VectorXd& restitution, const Eigen::VectorXd& slow, const Rubbing& rubbing,
                  const std::vector<bool>& moves, const Thresholds& thresholds);

private:
    using Vector = Eigen::VectorXd;

    bool newton(const Eigen::MatrixXd& B, const Vector& before, const Vector& e);
    bool poisson(const Eigen::MatrixXd& B, const Vector& before, const Vector& e);
    bool energetic(const Eigen::MatrixXd& B, const Vector& before, const Vector& e, const Vector& slow);
    bool along_path(const Eigen::MatrixXd& B, const Vector& e);
    bool impulses(const Eigen::MatrixXd& B, const Vector& b, const Vector& given, Vector& y) const;
    void work(const Eigen::MatrixXd& B, const Vector& before, const Vector& z);

    const Rubbing* rubbing_ = nullptr;
    const std::vector<bool>* moves_ = nullptr;
    const Thresholds* thresholds_ = nullptr;
};

}  // namespace mbproj
