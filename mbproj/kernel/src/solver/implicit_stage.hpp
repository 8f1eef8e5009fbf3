// One equation of an implicit step: accelerations a with M a + Gᵀλ = f(q, v), G a = γ(q, v) where q and v follow from
// a. With g = hγ they are v = c + g a, and q changes with g² a. In Newton's method stiff forces are compliant rows
// (kinematics/compliant_rows.hpp). From accelerations b, on which the current state depends, it leads to a with (M +
// JᵀD J) a + Gᵀλ = f + JᵀD J b. At the solution a = b. Scenes without stiff forces have the usual solver. States of
// elements are eliminated, and functions of channels are included by solver/stage_crossing.hpp.
#pragma once

#include "solver/stage_crossing.hpp"

namespace mbproj {

template <class D> class ImplicitStage final {
public:
    using S = Size<D>;

    explicit ImplicitStage(EquationsOfMotion<D>& equations)
        : equations_(equations), model_(equations.model()), shift_(model_.size() + 1, Point<D>::Zero()),
          turn_(model_.size() + 1, Turn<D>::Zero()), crossing_(equations) {}

    // Whether Newton's matrix is more than that of the masses.
    bool is_stiff() const { return !model_.stiff.empty(); }
    // Whether an error has to be filtered.
    bool filters() const { return is_stiff() || crossing_.any(); }

    // Makes room for so many stages.
    void remember(int stages) { equations_.solver().compliance().remember(stages); }

    // A step begins at y at t: `filter` looks at how stiff forces are there, too.
    void begin(double t, const double* y, double g) {
        if (is_stiff()) equations_.begin_stiff(t, y, g);
    }

    // y' with the next accelerations a at the state y at t, which follows from those in the slope `before`; multipliers
    // on request. False where the equations have no solution, or none with these rows.
    bool slope(double t, const double* y, double g, const double* before, Pass pass, double* slope, double* lambda) {
        const bool found = is_stiff() ? stiff_slope(t, y, g, before, pass, slope, lambda)
                                      : equations_.watched_derivative(t, y, slope, lambda);
        return found && crossed(t, y, g, before, slope, lambda);
    }
    // `slope` at a state beside the step, which the row policy does not record.
    bool slope_beside(double t, const double* y, double g, const double* before, double* slope, double* lambda) {
        if (is_stiff())
            return stiff_slope(t, y, g, before, {0, 0}, slope, lambda) && crossed(t, y, g, before, slope, lambda);
        equations_.set_pose(t, y);
        if (!equations_.factor(Metric::mass)) return false;
        equations_.set_velocities(y, false);
        return equations_.slope_at(y, slope, lambda) && crossed(t, y, g, before, slope, lambda);
    }

    // Filters an error e of y at t after so many stages: (I - g ∂f/∂y)⁻¹ e, for stiff forces and states of elements.
    bool filter(double t, const double* y, double g, int stages, double* e) {
        const bool moves = is_stiff() || crossing_.pushes();
        Eigen::VectorXd shifted;
        if (crossing_.any()) shifted = crossing_.of_positions(t, y, g, e);
        if (moves && !filter_velocities(y, g, stages, e)) return false;
        if (crossing_.any() && !crossing_.filter(shifted, e)) return false;
        for (int b = 0; moves && b < model_.size(); ++b) {
            const Part<D> part(y, b);
            WritablePart<D> error(e, b);
            error.position() += g * error.velocity();
            error.orientation() +=
                g * orientation_rate(Column<S::orientation>(part.orientation()), Turn<D>(error.omega()));
        }
        return true;
    }

    // The coordinate along which a change of the accelerations changes a stiff force most; -1 without any.
    int leader(const Eigen::VectorXd& change) {
        turn_to(change.data());
        const auto& compliance = equations_.solver().compliance();
        int joint = model_.first_stiff(), found = -1;
        double most = 0.0;
        const auto take = [&](double force, int coordinate) {
            if (force > most) most = force, found = coordinate;
            ++joint;
        };
        each_stiff_force([&](std::size_t, int law) { take(compliance.weight(joint) * std::abs(along(law)), law); },
                         [&](const Bushing<D>& bushing) {
                             const auto& root = compliance.root(joint);
                             const auto force = (root.transpose() * (root * rate({bushing, equations_.pose()}))).eval();
                             const auto number = &bushing - model_.loads->bushings.data();
                             take(force.norm(), static_cast<int>(model_.loads->laws.size() + 6 * number));
                         });
        return found;
    }

private:
    // Adds the effect of channels to a slope.
    bool crossed(double t, const double* y, double g, const double* before, double* slope, double* lambda) {
        return !crossing_.any() || crossing_.take(t, y, g, before, slope, lambda);
    }
    // With the current factor, unless a force was softer at an earlier stage: a force that gave way has not reduced the
    // error. The projection corrects what e violates.
    bool filter_velocities(const double* y, double g, int stages, double* e) {
        if (equations_.solver().compliance().soften(stages, g) &&
            !equations_.solver().factor(equations_.pose(), Metric::stiff, 0.0))
            return false;
        Applied<D>& applied = equations_.applied();
        KktSolver<D>& solver = equations_.solver();
        const Pose<D>& pose = equations_.pose();
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> error(e, b), part(y, b);
            shift_[b] = error.position();
            turn_[b] = turn_of(Column<S::orientation>(part.orientation()), Column<S::orientation>(error.orientation()));
        }
        applied.clear();
        each_stiff_force(
            [&](std::size_t f, int law) {
                applied.add(*model_.loads, law, pose, -g * solver.compliance().slope(f) * along(law));
            },
            [&](const Bushing<D>& bushing) {
                const Deflection<D> bent(bushing, pose);
                bent.pull(-g * (bushing.stiffness * rate(bent)), applied.force, applied.torque);
            });
        const auto set_momentum = [&] {
            for (int b = 0; b < model_.size(); ++b) {
                const Part<D> error(e, b);
                const Turn<D> momentum = model_.bodies[b].inertia * error.omega();
                solver.set_force(b, applied.force[b] + model_.bodies[b].mass * error.velocity(),
                                 applied.torque[b] + to_global(pose[b].rotation, momentum));
            }
        };
        if (!equations_.contacts().answer(set_momentum)) return false;
        for (int b = 0; b < model_.size(); ++b) {
            WritablePart<D> error(e, b);
            error.velocity() = solver.shift(b);
            error.omega() = to_body(pose[b].rotation, solver.turn(b));
        }
        return true;
    }

    // The twists of a slope's accelerations, at the pose in place.
    void turn_to(const double* slope) {
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> part(slope, b);
            shift_[b] = part.velocity();
            turn_[b] = to_global(equations_.pose()[b].rotation, Turn<D>(part.omega()));
        }
    }
    bool stiff_slope(double t, const double* y, double g, const double* before, Pass pass, double* slope,
                     double* lambda) {
        equations_.set_pose(t, y);
        equations_.set_velocities(y, false);
        if (!equations_.factor_stiff(y, g, pass)) return false;
        turn_to(before);
        double* asked = equations_.gamma() + model_.constraints.rows + model_.flywheels.size();
        each_stiff_force([&](std::size_t, int law) { *asked++ = along(law); },
                         [&](const Bushing<D>& bushing) {
                             const auto found = rate(Deflection<D>(bushing, equations_.pose()));
                             asked = std::copy(found.begin(), found.end(), asked);
                         });
        return equations_.slope_at(y, slope, lambda);
    }

    // Calls of_law(number of the stiff force, number of the law) or of_bushing(bushing), in the order of their rows.
    template <class OfLaw, class OfBushing> void each_stiff_force(OfLaw&& of_law, OfBushing&& of_bushing) const {
        for (std::size_t f = 0; f < model_.stiff.size(); ++f)
            if (const StiffForce& force = model_.stiff[f]; force.law >= 0)
                of_law(f, force.law);
            else
                of_bushing(model_.loads->bushings[force.bushing]);
    }

    // The rate of a coordinate with the current twists, of accelerations or of small motions.
    double along(int law) const {
        return equations_.applied().rate(*model_.loads, law, equations_.pose(), shift_, turn_);
    }
    auto rate(const Deflection<D>& bent) const {
        return bent.rate([this](int b) { return shift_[b]; }, [this](int b) { return turn_[b]; });
    }

    EquationsOfMotion<D>& equations_;
    const Model<D>& model_;
    std::vector<Point<D>> shift_;  // of all bodies, the ground's last, global axes
    std::vector<Turn<D>> turn_;
    StageCrossing<D> crossing_;
};

}  // namespace mbproj
