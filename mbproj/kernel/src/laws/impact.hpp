// Impacts at stops without friction by one of three laws of restitution: what the rates of gaps jump to. The reference is
// mbproj.dynamics.contact.impact.
#pragma once

#include "laws/one_sided.hpp"

namespace mbproj {

// What restitution is of: the speeds, the impulses, or the energy.
enum class ImpactLaw : int { newton, poisson, energetic };

// Impulses of the stops, the rates of their gaps after, and the energy that each takes.
struct Impact {
    Eigen::VectorXd impulse, after, taken;

    // Of stops that touch, with B of their rows and the rates before; what is slower than `slow` does not close. False where nothing
    // that the joints allow opens the gaps, and where the law has no answer.
    bool strike(ImpactLaw law, const Eigen::MatrixXd& B, const Eigen::VectorXd& before,
                const Eigen::VectorXd& restitution, const Eigen::VectorXd& slow, double none) {
        taken = Eigen::VectorXd::Zero(before.size());
        switch (law) {
            case ImpactLaw::newton: return newton(B, before, restitution, none);
            case ImpactLaw::poisson: return poisson(B, before, restitution, none);
            default: return energetic(B, before, restitution, slow);
        }
    }

private:
    using Vector = Eigen::VectorXd;

    // Of each stop that is struck the speed after is -e times that before, or more where it is left.
    bool newton(const Eigen::MatrixXd& B, const Vector& before, const Vector& e, double none) {
        const Vector b = before + e.cwiseProduct(before.cwiseMin(0.0));
        if (!one_sided(B, b, none, impulse)) return false;
        work(B, before, impulse);
        return true;
    }

    // Compression until no gap closes; then each stop pushes at least with e times its impulse of compression.
    bool poisson(const Eigen::MatrixXd& B, const Vector& before, const Vector& e, double none) {
        Vector compression, more;
        if (!one_sided(B, before, none, compression)) return false;
        work(B, before, compression);
        const Vector between = after, least = e.cwiseProduct(compression);
        if (!one_sided(B, between + B * least, none, more)) return false;
        work(B, between, least + more);
        impulse = compression + least + more;
        return true;
    }

    // One stop gives back e² of the energy that it takes until its gap closes no more; others that touch are left alone.
    bool energetic(const Eigen::MatrixXd& B, const Vector& before, const Vector& e, const Vector& slow) {
        Eigen::Index first;
        before.minCoeff(&first);
        if ((before.array() < -slow.array()).count() > 1 || !(B(first, first) > 0.0)) return false;
        impulse = Vector::Zero(before.size());
        impulse[first] = -(1.0 + e[first]) * before[first] / B(first, first);
        work(B, before, impulse);
        return (after.array() >= -slow.array()).all();
    }

    // Impulses work at the mean of the rates before and after.
    void work(const Eigen::MatrixXd& B, const Vector& before, const Vector& z) {
        after = before + B * z;
        taken -= 0.5 * z.cwiseProduct(before + after);
    }
};

}  // namespace mbproj
