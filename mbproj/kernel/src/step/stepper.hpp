// The interface of a method to the time loop: {attempt, error, extend, at}, their costs, and the slope with which a
// step begins. The loop, the turn counter and the step doubling know no more of it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "model/weighted_sum.hpp"
#include "solver/equations.hpp"

namespace mbproj {

constexpr int most_stages = 32;  // with those of a continuous extension
constexpr int most_first = 300;  // times that the trial step for a first step size is shortened, tenfold each
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// The size of a first step, and whether the time ahead has limited it.
struct FirstStep {
    double h;
    bool limited;
};

// The body whose accelerations Newton's method has not found, and the force or state that is the cause: its number
// among the coordinates of forces and then the states, or -1.
struct Unsolved {
    int body, force;
};

class Stepper {
public:
    using Vector = Eigen::VectorXd;
    using Visit = std::function<void(double, double, const Vector&)>;
    virtual ~Stepper() = default;
    Stepper& operator=(const Stepper&) = delete;
    virtual std::unique_ptr<Stepper> copy() const = 0;

    // Sets the slope with which the next attempts begin.
    void begin(const Vector& slope) { k_[0] = slope; }

    // Numbers of evaluations: of the last attempt after its first stage, its error, an extension, and the end's slope.
    virtual long attempt_cost() const = 0;
    virtual int error_cost() const = 0;
    virtual int extend_cost() const = 0;
    virtual int arrival_cost() const = 0;
    int error_order() const { return tableau_.error_order; }

    // y_new from y; false where a stage has no unique accelerations, or where its equations are not solved.
    virtual bool attempt(double t, const Vector& y, double h, Vector& y_new) = 0;
    // The equations that the last attempt did not solve.
    virtual std::optional<Unsolved> unsolved() const { return std::nullopt; }

    // The states at which the last step, from y at t over h, has evaluated f: visit(weight, time, state).
    virtual void quadrature(double t, const Vector& y, double h, const Visit& visit) const = 0;

    // Hairer's norm of the estimated error of the step to y_new at t: 1 is just acceptable; none where f fails there.
    // `again`: a longer step from y was rejected.
    virtual std::optional<double> error(double t, const Vector& y, const Vector& y_new, double h, double tolerance,
                                        bool again) = 0;

    // The estimated error of each number of y; null where it is not stored.
    virtual const Vector* estimate() const { return nullptr; }

    // Computes what the continuous extension of the last step needs.
    virtual bool extend(double t, const Vector& y, double h) = 0;
    // y(t + θ h).
    void at(const Vector& y, double h, double theta, Vector& out) const;

    // The slope at the end of the last step, which the projection has moved to y; multipliers on request. The pose of y
    // is in place and factored with the masses, and its velocities are in place.
    virtual bool arrive(const Vector& y, Vector& slope, double* lambda) = 0;
    // Sets the first slope of a step that follows at once, from y at t.
    virtual bool follow_on(double t, const Vector& y) = 0;
    // The slope at the part θ of the last step, where the projection has moved the state to y.
    virtual bool inside(double t, double h, double theta, const Vector& y, Vector& slope, double* lambda) = 0;

    // Forces jump at y at t. `after_jump` changes `slope`, and `lambda` on request, to their values after the jump.
    virtual bool before_jump(double t, const Vector& y) = 0;
    virtual bool after_jump(double t, const Vector& y, Vector& slope, double* lambda) = 0;
    // Changes the slope at the end of a step at a break: from the forces inside the window, which the step has used, to
    // those at that time itself.
    virtual bool meet_break(double t, const Vector& y, const TimeWindow& window, Vector& slope, double* lambda) = 0;
    // Whether the slope with which a step begins is part of the state, not a function of the state.
    virtual bool carries_slope() const = 0;
    // Whether Newton's method closes each stage, so that nothing of the motion is integrated.
    virtual bool closes_stages() const { return false; }

    // A first step size from f, the slope, and an estimate of f' (Hairer's hinit), at most `longest`; negative where f fails
    // or overflows however near to the start. Tells whether `longest` limits it.
    FirstStep first_step(double t, const Vector& y, const Vector& slope, double tolerance, double longest);

protected:
    Stepper(const Tableau& tableau, Equations& equations, std::size_t kept)
        : tableau_(tableau), equations_(equations), layout_(equations.layout()), stage_(layout_.size()),
          k_(kept, Vector::Zero(layout_.size())) {}
    Stepper(const Stepper&) = default;

    // The weights of the stages in y' at t + θ h, by the continuous extension.
    std::vector<double> dense_rates(double theta) const;

    // y + h Σ w k, without the stages of no weight.
    template <class Row> void combine(const Vector& y, double h, const Row& weights, int count, Vector& out) const {
        const double* stages[most_stages];
        double factors[most_stages];
        int used = 0;
        for (int s = 0; s < count; ++s)
            if (weights[s] != 0.0) {
                stages[used] = k_[s].data();
                factors[used++] = h * weights[s];
            }
        add_weighted(y.data(), stages, factors, used, y.size(), out.data());
    }

    const Tableau& tableau_;
    Equations& equations_;
    const Layout& layout_;
    Vector stage_;
    std::vector<Vector> k_;  // y' at the stages
};

}  // namespace mbproj
