// Conserved quantities as further rows of the velocity projection: the energy balance T + V - W = E0, and momenta. The balance is
// quadratic in the velocities. Along a direction d of the tangent space it is a scalar quadratic equation, which is solved
// exactly. Afterwards the joints' rows and the balance hold to round-off.
#pragma once

#include "model/decompositions.hpp"
#include "solver/projector.hpp"
#include "solver/trust_region.hpp"

namespace mbproj {

// A rigid motion of all bodies: shift + turn × r at r.
template <class D> struct RigidField {
    Point<D> shift;
    Turn<D> turn;
};

template <class D> class InvariantRows final : public Invariants {
public:
    // `tolerance`: that of the steps' errors; 0 where it is unknown.
    InvariantRows(EquationsOfMotion<D>& equations, TrustRegion<D>& trust_region, Metric metric, bool energy,
                  std::vector<RigidField<D>> fields, double tolerance)
        : equations_(equations), trust_region_(trust_region), model_(equations.model()), metric_(metric),
          energy_(energy), fields_(std::move(fields)), motion_(model_), raw_(model_.all_rows()),
          beyond_(model_.all_rows()), own_(equations.layout().bodies.size), now_(model_.size()) {
        const Thresholds& thresholds = model_.thresholds;
        tolerated_ = std::max(thresholds.half_digits, thresholds.row_tolerated * tolerance);
        scale_ = speed(equations_.layout().scale.data());
        kept.momenta.resize(fields_.size());
        across_.resize(fields_.size());
    }

    void begin(double t, const double* y) override {
        equations_.set_pose(t, y);
        equations_.constraint_velocity(y);
        set_rates(equations_.motion(), raw_);
        kept.energy = energy(t, y);
        copy(y, now_);
        for (std::size_t k = 0; k < fields_.size(); ++k) kept.momenta[k] = momentum_of(fields_[k], now_);
    }

    // Records a step from `before`.
    void enter_step(const double* before) {
        refused_ = false;
        before_.assign(before, before + own_.size());
    }

    // Corrects the velocities at the step's end y at t, whose pose is in place, factored and closed. A correction that is larger
    // than an error of the step is refused, and a new balance begins.
    void after_step(double t, double* y) {
        const Result result = hold(t, y, true);
        refused_ = result == Result::refused;
        if (result == Result::rests) ++kept.rested;
        if (result == Result::refused) ++kept.refused, begin(t, y);
        if (result != Result::held) return;
        ++kept.held;
        kept.given += energy_given_;
        kept.moved += std::abs(energy_given_);
        kept.furthest = std::max(kept.furthest, std::abs(kept.given));
        kept.largest = std::max(kept.largest, change_);
    }
    // Corrects a state inside that step, whose interpolation has a larger error; nothing is counted or refused.
    void inside_step(double t, double* y) {
        if (!refused_ && !before_.empty()) hold(t, y, false);
    }

private:
    enum class Result { held, rests, refused };
    using Way = std::vector<Twist<D>>;  // a change of each body's velocities, global axes

    Result hold(double t, double* y, bool refuses) {
        const Thresholds& thresholds = model_.thresholds;
        equations_.constraint_velocity(y);
        set_rates(equations_.motion(), raw_);
        const double now = speed(y), by_step = speed_from_before(y);
        if (!(now > thresholds.row_rests * by_step)) return Result::rests;
        copy(y, now_);
        way_ = now_;
        total_ = Way(model_.size(), Twist<D>{Point<D>::Zero(), Turn<D>::Zero()});
        if (!fields_.empty() && !momenta_directions()) return Result::rests;
        energy_given_ = 0.0;
        const bool singular = energy_ && !close_balance(t, y, now);
        if (singular && fields_.empty()) return Result::rests;
        const double change = std::sqrt(product(total_, total_));
        change_ = change / now;
        if (refuses && change > std::max(thresholds.row_refused * by_step, tolerated_ * (scale_ + now)))
            return Result::refused;
        for (int b = 0; b < model_.size(); ++b) {
            WritablePart<D> part(y, b);
            part.velocity() += total_[b].velocity;
            part.omega() += to_body(equations_.pose()[b].rotation, total_[b].omega);
        }
        return singular ? Result::rests : Result::held;
    }

    // Adds the change of the velocities that closes the balance to that of the momenta's rows; changes of round-off size are
    // omitted. False where the balance is singular: the free kinetic energy is small, or less than the energy to remove, or no
    // more than the error of the balance.
    bool close_balance(double t, const double* y, double now) {
        const double missing = kept.energy - energy(t, y);
        const double grain = model_.thresholds.round_off_grains * std::numeric_limits<double>::epsilon() * terms_;
        if (!(0.5 * now * now > std::max(grain, tolerated_ * worked_) && direction(y))) return false;
        const double of_momenta = fields_.empty() ? 0.0 : 0.5 * product(total_, total_) + product(now_, total_);
        const double slope = product(now_, way_) + flywheels(raw_, beyond_) + product(total_, way_);
        const double curve = product(way_, way_) + flywheels(beyond_, beyond_);
        const double wanted = missing - of_momenta, root = slope * slope + 2.0 * curve * wanted;
        if (std::abs(wanted) <= grain) return true;
        // slope² / curve is twice the kinetic energy along `way_`, in any metric.
        const double least = model_.thresholds.half_digits;
        if (!(slope > 0.0 && slope * slope > least * curve * now * now && curve > least * whole_ && root > 0.0))
            return false;
        add(total_, 2.0 * wanted / (slope + std::sqrt(root)), way_);
        energy_given_ = missing;
        return true;
    }

    // `way_`: the direction in which the balance is corrected, the smallest in the metric, in the tangent space and
    // normal to the momenta. It is this part of the velocity v in the metric of the masses, else of M v.
    bool direction(const double* y) {
        if (metric_ == Metric::coordinates && !equations_.contacts().any()) {
            if (!pulled(way_)) return false;
        } else if (model_.driven.size() > 0 || equations_.contacts().any()) {
            if (!trust_region_.solve_velocities(of_rows())) return false;
            for (int b = 0; b < model_.size(); ++b) {
                way_[b].velocity += equations_.solver().shift(b);
                way_[b].omega += equations_.solver().turn(b);
            }
        }
        whole_ = metric_ == Metric::coordinates ? product(way_, way_) : std::pow(speed(y), 2);
        if (!fields_.empty()) {
            Eigen::VectorXd parts(fields_.size());
            for (std::size_t k = 0; k < fields_.size(); ++k) parts[k] = momentum_of(fields_[k], way_);
            const Eigen::VectorXd much = solved(coupling_, parts);
            for (std::size_t k = 0; k < fields_.size(); ++k) add(way_, -much[k], across_[k]);
        }
        if (!model_.flywheels.empty()) {
            std::copy(y, y + own_.size(), own_.begin());
            for (int b = 0; b < model_.size(); ++b) {
                WritablePart<D> part(own_.data(), b);
                part.velocity() = way_[b].velocity;
                part.omega() = to_body(equations_.pose()[b].rotation, way_[b].omega);
            }
            motion_.update(own_.data(), equations_.pose());
            set_rates(motion_, beyond_);
        }
        return true;
    }

    // Sets changes of velocity, one for each momentum, their coupling, and their sum that closes the momenta's rows.
    bool momenta_directions() {
        const std::size_t count = fields_.size();
        Eigen::VectorXd missing(count);
        coupling_.resize(count, count);
        for (std::size_t k = 0; k < count; ++k) {
            across_[k] = Way(model_.size());
            for (int b = 0; b < model_.size(); ++b)
                across_[k][b] = {fields_[k].shift + turned_by(fields_[k].turn, Point<D>(equations_.pose()[b].position)),
                                 fields_[k].turn};
            if (metric_ == Metric::coordinates && !equations_.contacts().any() && !pulled(across_[k])) return false;
            for (std::size_t i = 0; i < count; ++i) coupling_(i, k) = momentum_of(fields_[i], across_[k]);
            missing[k] = kept.momenta[k] - momentum_of(fields_[k], now_);
        }
        const Eigen::VectorXd much = solved(coupling_, missing);
        for (std::size_t k = 0; k < count; ++k) add(total_, much[k], across_[k]);
        return much.allFinite();
    }

    // The response of the bodies to the momentum of a change, in the current metric, with the joints closed.
    bool pulled(Way& way) {
        for (int b = 0; b < model_.size(); ++b)
            equations_.solver().set_force(b, model_.bodies[b].mass * way[b].velocity, spin(b, way[b].omega));
        rhs_.assign(model_.all_rows(), 0.0);
        if (!equations_.solver().solve(rhs_.data())) return false;
        for (int b = 0; b < model_.size(); ++b) way[b] = {equations_.solver().shift(b), equations_.solver().turn(b)};
        return true;
    }

    // G v of all rows but the flywheels'.
    const double* of_rows() {
        rhs_ = raw_;
        leave_flywheels(model_, rhs_);
        return rhs_.data();
    }

    // The rates of all rows, of motions and flywheels too.
    void set_rates(const Motion<D>& motion, std::vector<double>& rates) const {
        if (model_.driven.empty() && model_.flywheels.empty()) return;
        moving_rows(model_, equations_.pose(), motion, rates.data(), static_cast<double*>(nullptr));
    }

    // E = T + V - W at y at t, whose pose and velocities are in place. `terms_`: the sum of the magnitudes of its
    // terms; `worked_`: that of the integrated ones.
    double energy(double t, const double* y) {
        double sum = terms_ = 0.5 * (std::pow(speed(y), 2) + flywheels(raw_, raw_));
        const auto add = [&](double term) { sum += term, terms_ += std::abs(term); };
        for (int b = 0; b < model_.size(); ++b)
            add(-model_.bodies[b].mass * model_.gravity.dot(Point<D>(equations_.pose()[b].position)));
        if (model_.loads)
            add(equations_.applied().stored(*model_.loads, equations_.pose(), equations_.channels_at(t, y)));
        const Block& work = equations_.layout().quadratures;
        worked_ = work.size ? std::abs(y[work.first]) + std::abs(y[work.first + 1]) : 0.0;
        if (work.size) add(-y[work.first]), add(y[work.first + 1]);
        return sum;
    }

    // The change of the velocities by the step, in the bodies' axes, as a speed.
    double speed_from_before(const double* y) {
        for (std::size_t i = 0; i < own_.size(); ++i) own_[i] = y[i] - before_[i];
        return speed(own_.data());
    }

    // √(vᵀMv) of the bodies.
    double speed(const double* y) const {
        double sum = 0.0;
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> part(y, b);
            const Turn<D> omega = part.omega();
            sum += model_.bodies[b].mass * part.velocity().squaredNorm() + omega.dot(model_.bodies[b].inertia * omega);
        }
        return std::sqrt(sum);
    }
    double flywheels(const std::vector<double>& a, const std::vector<double>& b) const {
        double sum = 0.0;
        const std::size_t first = model_.constraints.rows;
        for (std::size_t f = 0; f < model_.flywheels.size(); ++f)
            sum += model_.flywheels[f] * a[first + f] * b[first + f];
        return sum;
    }

    void copy(const double* y, Way& way) const {
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> part(y, b);
            way[b] = {part.velocity(), to_global(equations_.pose()[b].rotation, Turn<D>(part.omega()))};
        }
    }
    static void add(Way& way, double part, const Way& other) {
        for (std::size_t b = 0; b < way.size(); ++b) {
            way[b].velocity += part * other[b].velocity;
            way[b].omega += part * other[b].omega;
        }
    }
    // J ω in global axes.
    Turn<D> spin(int b, const Turn<D>& omega) const {
        const Rotation<D>& A = equations_.pose()[b].rotation;
        return to_global(A, Turn<D>(model_.bodies[b].inertia * to_body(A, omega)));
    }
    // aᵀMb of the bodies.
    double product(const Way& a, const Way& b) const {
        double sum = 0.0;
        for (int i = 0; i < model_.size(); ++i)
            sum += model_.bodies[i].mass * a[i].velocity.dot(b[i].velocity) + a[i].omega.dot(spin(i, b[i].omega));
        return sum;
    }
    double momentum_of(const RigidField<D>& field, const Way& way) const {
        double sum = 0.0;
        for (int b = 0; b < model_.size(); ++b)
            sum += model_.bodies[b].mass *
                       Point<D>(field.shift + turned_by(field.turn, Point<D>(equations_.pose()[b].position)))
                           .dot(way[b].velocity) +
                   field.turn.dot(spin(b, way[b].omega));
        return sum;
    }

    EquationsOfMotion<D>& equations_;
    TrustRegion<D>& trust_region_;
    const Model<D>& model_;
    const Metric metric_;
    const bool energy_;
    const std::vector<RigidField<D>> fields_;
    Motion<D> motion_;
    std::vector<double> raw_, beyond_, rhs_, own_, before_;
    Way now_, way_, total_;  // the velocities, the direction of the balance, and the change
    std::vector<Way> across_;
    Eigen::MatrixXd coupling_;
    double tolerated_ = 0.0, scale_ = 0.0;  // the tolerated error and the scale of the velocities, as speeds
    double energy_given_ = 0.0, change_ = 0.0, whole_ = 0.0, terms_ = 0.0, worked_ = 0.0;
    bool refused_ = false;
};

}  // namespace mbproj
