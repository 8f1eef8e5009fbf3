// Quantities of the whole mechanism at a state y: its speed, its kinetic energy, gaps of stops, values of programs, and
// velocities after impulses.
#pragma once

#include "dynamics/equations_of_motion.hpp"

namespace mbproj {

// The speed of the fastest part, in lengths of the mechanism and rad per s.
template <class D> double fastest_part(const Model<D>& model, const Eigen::VectorXd& y) {
    double shift = 0.0, turn = 0.0;
    for (int b = 0; b < model.size(); ++b) {
        const Part<D> part(y.data(), b);
        for (int i = 0; i < D::axes; ++i) shift = std::max(shift, std::abs(part.velocity()[i]));
        for (int i = 0; i < Size<D>::turns; ++i) turn = std::max(turn, std::abs(part.omega()[i]));
    }
    return shift / model.length + turn;
}

// The kinetic energy, with the pose in place. Flywheels have rows after those of C.
template <class D> double kinetic_energy(const EquationsOfMotion<D>& equations, const Eigen::VectorXd& y) {
    const Model<D>& model = equations.model();
    double sum = 0.0;
    for (int b = 0; b < model.size(); ++b) {
        const Part<D> part(y.data(), b);
        const Turn<D> omega = part.omega();
        sum += model.bodies[b].mass * part.velocity().squaredNorm() + omega.dot(model.bodies[b].inertia * omega);
    }
    if (model.flywheels.empty()) return 0.5 * sum;
    Motion<D> motion(model);
    motion.update(y.data(), equations.pose());
    std::vector<double> rates(model.all_rows());
    moving_rows(model, equations.pose(), motion, rates.data(), static_cast<double*>(nullptr));
    for (std::size_t k = 0; k < model.flywheels.size(); ++k)
        sum += model.flywheels[k] * std::pow(rates[model.constraints.rows + k], 2);
    return 0.5 * sum;
}

// The gap of a stop on this side, with whole turns of the joints' coordinates.
template <class D>
double stop_gap(const Model<D>& model, const Pose<D>& pose, const std::vector<long>& turns, int stop, double side) {
    const int coordinate = model.stops.joint_coordinate[stop];
    const double whole = coordinate < 0 ? 0.0 : 2.0 * M_PI * static_cast<double>(turns[coordinate]);
    return side * (Coordinate<D>(model.stops.coordinates, stop, pose).value() + whole - model.stops.bound[stop]);
}

// The value of a program at the last state, along a coordinate with this rate.
template <class D> double given(EquationsOfMotion<D>& equations, int program, double rate = 0.0) {
    return equations.model().programs.value(program, equations.channels().variables(0.0, rate),
                                            equations.applied().held);
}

// Adds the velocities that the solver has found for impulses.
template <class D> void add_velocities(const EquationsOfMotion<D>& equations, Eigen::VectorXd& y) {
    for (int b = 0; b < equations.model().size(); ++b) {
        WritablePart<D> part(y.data(), b);
        part.velocity() += equations.solver().shift(b);
        part.omega() += to_body(equations.pose()[b].rotation, equations.solver().turn(b));
    }
}

}  // namespace mbproj
