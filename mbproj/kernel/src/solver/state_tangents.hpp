// The derivatives of a run's states by numbers of its model and by its start, step by step, each after the run's.
// Slopes at the stages are in dual numbers; all systems are solved in doubles. The factor at a stage is that of
// the doubles: for K(p) x = b(p), x' = K⁻¹ (b' - K' x). The residual b - K x is computed in dual numbers, and
// the bracket is its derivative. The step sizes are constants (internal differentiation: Bock 1981). A
// projection is the smallest change that closes the joints in its metric, at the pose where it ends: W δ + Gᵀμ =
// 0. The kernel uses W and G of a pose nearby, so that its slopes differ from these by δ times the difference of
// the two.
#pragma once

#include <Eigen/Core>

#include "model/settings.hpp"
#include "solver/metric.hpp"
#include "solver/model_numbers.hpp"
#include "solver/row_values.hpp"
#include "solver/state_rates.hpp"

namespace mbproj {

// The interface to the run's equations, in doubles.
class Answers {
public:
    virtual ~Answers() = default;
    // y' and λ of all rows at a state; false where they are not unique.
    virtual bool slope(double t, const double* y, double* slope, double* lambda) = 0;
    // Factors at the end of a step, which is closed.
    virtual bool close(double t, const double* y) = 0;
    // With the last factor: the changes or accelerations by forces and right-hand sides of the rows, for each body a
    // translation and a rotation in global axes. Multipliers on request.
    virtual bool respond(const double* forces, const double* rhs, double* changes, double* lambda) = 0;

    Answers() = default;
    Answers(const Answers&) = delete;
    Answers& operator=(const Answers&) = delete;
};

// A step of the run: from t to `end` over h, with functions of time evaluated inside the window.
struct StepMade {
    double t, h, end;
    TimeWindow window;
    bool position, velocity;  // whether they were projected
};

// The numbers of D are doubles.
template <class D> class StateTangents final {
public:
    using S = Size<D>;
    using Duals = WithDuals<D>;
    static constexpr int F = S::freedoms;

    // The `metric` of projections; `numbers` (count, size), row by row: slopes of the model's numbers by direction.
    StateTangents(const Model<D>& model, const Tableau& tableau, Metric metric, Answers& answers, const double* numbers,
                  int count);

    // The run begins at y, which is closed; `slopes` of y for each direction.
    bool start(double t, const double* y, const double* slopes);
    // The run begins at y, which joints and motions alone determine.
    bool stand(double t, const double* y);
    // Follows a step to y. False where the equations have no unique solution, or a function no value.
    bool follow(const StepMade& step, const double* y);
    // Stores the data for states inside the next step: `begin` before it; after it `extend`, if there are such states.
    void begin() { begun_ = y_; }
    bool extend(const StepMade& step);
    // The slope of each number of the state y at a time inside the last step, which is extended. False as above.
    bool inside(const StepMade& step, double t, const double* y, std::vector<Dual>& found);
    // The state, with its derivatives along the directions.
    const std::vector<Dual>& state() const { return y_; }

private:
    using Vector = std::vector<Dual>;

    bool evaluate(double t, const TimeWindow& window, const Vector& y, Vector& slope);
    void combine(const Vector& y, double h, const double* weights, int count, Vector& out) const;
    void set_residual(const Vector& y);
    bool close(double t, const double* y, bool position, bool velocity);
    bool close_position(const double* y);
    bool close_velocity(const double* y);
    bool respond();
    bool respond_to_projection();
    template <class Visit> void each_gradient(int first_row, Visit&& visit) const;
    Column<Size<D>::freedoms, Dual> momentum(int body) const;
    Column<Size<D>::freedoms, Dual> change(int body) const;
    void set(const double* values);

    const Model<Duals> model_;
    const Tableau& tableau_;
    const Metric metric_;
    Answers& answers_;
    const int count_;
    Pose<Duals> pose_;
    Motion<Duals> motion_;
    Channels<Duals> channels_;
    Applied<Duals> applied_;
    Drive<Duals> drive_;
    StateRates<Duals> states_;
    Vector y_, stage_, before_, begun_;
    std::vector<Vector> k_;
    Vector rows_;                                 // right-hand sides, or their residuals
    std::vector<Column<F, Dual>> moved_;          // accelerations of the bodies, or their change by a projection
    std::vector<Column<F, Dual>> residual_;       // residuals of the forces on the bodies
    std::vector<double> at_, slope_, lambda_;     // a state in doubles, its slope, and the multipliers
    std::vector<double> forces_, rhs_, changes_;  // forces, right-hand sides and changes for one direction
    std::vector<double> tangents_;                // the changes of each direction
    bool weighs_ = true;                          // whether the current metric is that of the masses
};

extern template class StateTangents<Plane<double>>;
extern template class StateTangents<Space<double>>;

}  // namespace mbproj
