// Newton and Euler in the bodies' own velocities, with the joints' multipliers: y' = f(y).
#pragma once

#include "bordered.hpp"
#include "settings.hpp"

namespace mbproj {

// Everything that is known at one state; scratch that evaluations overwrite.
template <int D> class Dynamics {
public:
    using S = Size<D>;

    Dynamics(const Model<D>& model, const Projection& projection)
        : model_(model), projection_(projection), pose_(model), motion_(model), bordered_(model),
          gamma_(model.constraints.rows), C_(model.constraints.rows), C_dot_(model.constraints.rows) {}

    int size() const { return S::state * model_.size(); }

    // y' at a state. False where the equations have no unique solution.
    bool derivative(const double* y, double* slope) {
        place(y);
        if (!factor(Metric::mass)) return false;
        move(y, false);
        slope_at(y, slope);
        return true;
    }

    // The velocities at the pose in place, with the right-hand sides that go with them; C' on request.
    void move(const double* y, bool with_C_dot) {
        motion_.update(y, pose_);
        const bool baumgarte = projection_.correction == Correction::baumgarte;
        moving_rows(model_, pose_, motion_, with_C_dot || baumgarte ? C_dot_.data() : nullptr, gamma_.data());
        if (baumgarte) stabilise();
    }

    // y' where the pose is in place and factored with the masses, and its velocities are; multipliers on request.
    void slope_at(const double* y, double* slope, double* lambda = nullptr) {
        set_forces(y);
        bordered_.solve(gamma_.data(), lambda);
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> part(y, b);
            WritablePart<D> out(slope, b);
            out.position() = part.velocity();
            out.orientation() = orientation_rate(Column<S::orientation>(part.orientation()), Turn<D>(part.omega()));
            out.velocity() = bordered_.shift(b);
            out.omega() = to_body(pose_[b].rotation, bordered_.turn(b));
        }
    }

    void place(const double* y) {
        pose_.update(y);
        factored_ = false;
    }
    bool factor(Metric metric) {
        if (factored_ && metric == metric_) return true;
        metric_ = metric;
        return factored_ = bordered_.factor(pose_, metric);
    }
    const double* constraint() {
        mbproj::constraint(model_, pose_, C_.data());
        return C_.data();
    }
    const double* constraint_velocity(const double* y) {
        motion_.update(y, pose_);
        moving_rows(model_, pose_, motion_, C_dot_.data(), static_cast<double*>(nullptr));
        return C_dot_.data();
    }
    // Of the last `move`.
    const double* gamma() const { return gamma_.data(); }
    const double* C_dot() const { return C_dot_.data(); }

    const Model<D>& model() const { return model_; }
    Pose<D>& pose() { return pose_; }
    const Motion<D>& motion() const { return motion_; }
    Bordered<D>& bordered() { return bordered_; }
    const Bordered<D>& bordered() const { return bordered_; }

private:
    void set_forces(const double* y) {
        for (int b = 0; b < model_.size(); ++b) {
            Turn<D> torque = Turn<D>::Zero();
            if constexpr (D == 3) {
                const Turn<3> omega = Part<3>(y, b).omega();
                const Turn<3> momentum = model_.bodies[b].inertia * omega;
                torque.noalias() = pose_[b].rotation * momentum.cross(omega);
            }
            bordered_.set_force(b, model_.bodies[b].mass * model_.gravity, torque);
        }
    }

    // Baumgarte (ref. 9): C'' + 2α C' + β² C = 0.
    void stabilise() {
        const double* C = constraint();
        for (std::size_t r = 0; r < gamma_.size(); ++r)
            gamma_[r] -= 2.0 * projection_.alpha * C_dot_[r] + projection_.beta * projection_.beta * C[r];
    }

    const Model<D>& model_;
    const Projection& projection_;
    Pose<D> pose_;
    Motion<D> motion_;
    Bordered<D> bordered_;
    std::vector<double> gamma_, C_, C_dot_;
    bool factored_ = false;
    Metric metric_ = Metric::mass;
};

}  // namespace mbproj
