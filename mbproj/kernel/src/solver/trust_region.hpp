// One pass of a position correction: its solution, and the part of it that reduces the violation.
//
// In the metric of the masses light bodies turn far, lest a heavy one give way; linearised rows do not hold for large
// turns. Moments of inertia are added to such bodies, so that the smallest correction turns no body by more than ϑ. It
// is min ½ δᵀMδ subject to G δ = -C and |δθ| <= ϑ, with the conditions (M + Σ μ E) δ + Gᵀλ = 0, μ >= 0 where the bound
// is reached (a trust region: Conn, Gould & Toint 2000, sect. 7). It closes the rows to first order, and leaves a
// violation of order ϑ²: some ϑ reduces the violation wherever G has full rank.
#pragma once

#include "solver/equations_of_motion.hpp"

namespace mbproj {

template <class D> class TrustRegion final {
public:
    explicit TrustRegion(EquationsOfMotion<D>& equations)
        : equations_(equations), contacts_(equations.contacts()), model_(equations.model()),
          thresholds_(model_.thresholds), rhs_(model_.all_rows()), before_(equations.layout().bodies.size),
          added_(model_.size()) {
        for (const Instance<D>& p : model_.constraints.instances) owner_.insert(owner_.end(), p.rows, &p);
        double sum = 0.0;
        for (const Body<D>& body : model_.bodies) {
            moment_.push_back(body.inertia.trace() / Size<D>::turns);
            sum += moment_.back();
        }
        for (double& moment : moment_) moment = std::max(moment, thresholds_.lent_part * sum / model_.size());
    }

    // The correction of a violation, with the current factor. False where it is not unique.
    bool solve(const double* violation) {
        set_rhs(violation);
        return equations_.solver().solve(rhs_.data()) && (!contacts_.any() || close_contacts(false));
    }
    // The correction of velocities, with the rates of the state in place.
    bool solve_velocities(const double* violation) {
        set_rhs(violation);
        return equations_.solver().solve(rhs_.data()) && (!contacts_.any() || close_contacts(true));
    }

    // Moves y and the pose by a part of the current correction.
    void move(double* y, double part_of_it) {
        for (int b = 0; b < model_.size(); ++b) {
            WritablePart<D> part(y, b);
            part.position() += part_of_it * equations_.solver().shift(b);
            part.orientation() = turned(Column<Size<D>::orientation>(part.orientation()),
                                        Turn<D>(part_of_it * equations_.solver().turn(b)));
        }
        equations_.set_pose(y);
    }

    // The largest row that is open by more than round-off, with lengths in parts of the mechanism's. So the round-off at the end
    // of a long chain does not decide whether its beginning is closed.
    double scaled(const double* C) { return contacts_.any() ? larger(of_rows(C), contacts_.open()) : of_rows(C); }
    double of_rows(const double* C) const {
        double most = 0.0;
        std::size_t worst = 0;
        for (std::size_t r = 0; r < owner_.size(); ++r)
            if (const double size = std::abs(C[r]) / model_.row_scale[r]; !(size <= most)) {
                most = larger(most, size);
                worst = r;
            }
        if (most == 0.0 || !is_round_off(C, worst)) return most;
        most = 0.0;  // the largest row is round-off: looks at each
        for (std::size_t r = 0; r < owner_.size(); ++r)
            if (!is_round_off(C, r)) most = larger(most, std::abs(C[r]) / model_.row_scale[r]);
        return most;
    }

    // Moves y by the current correction, if that reduces the violation by half of what Newton's method predicts.
    bool whole(double* y, double& left) { return part(y, left, 1.0); }

    // Moves y by a part that turns no body by more than `widest_turn`, halved until it reduces the violation.
    bool shortened(double* y, double& left) {
        for (double tried = std::min(1.0, thresholds_.widest_turn / widest()); tried >= shortest_; tried *= 0.5)
            if (part(y, left, tried)) return true;
        return false;
    }

    // Applies the current correction, of a factor of this pose: whole; or with smaller and smaller turns of bodies; or shortened.
    bool damped(double* y, double& left, Metric metric) {
        double limit = thresholds_.widest_turn;
        if (widest() <= limit) {
            if (whole(y, left)) return true;
            limit = thresholds_.tighter * widest();
        }
        if (metric != Metric::coordinates && turning_less(y, left, metric, limit)) return true;
        return equations_.factor(metric) && solve(equations_.C()) && shortened(y, left);
    }

private:
    void set_rhs(const double* violation) {
        for (std::size_t r = 0; r < rhs_.size(); ++r) rhs_[r] = -violation[r];
        equations_.solver().clear_forces();
    }
    // Adds the contacts to the current solution: their gaps close, or do not change.
    [[gnu::noinline, gnu::cold]] bool close_contacts(bool velocities) {
        Eigen::VectorXd left, change, z;
        contacts_.set_normals();
        contacts_.changes(change);
        if (!contacts_.factor()) return false;
        velocities ? contacts_.rates(left) : contacts_.gaps(left);
        contacts_.close(left + change, z);
        return contacts_.respond(z, rhs_.data());
    }

    bool is_round_off(const double* C, std::size_t row) const {
        const double least = std::numeric_limits<double>::epsilon() * std::min(1.0, model_.row_scale[row]);
        if (std::abs(C[row]) <= thresholds_.closed_grains * least) return true;  // no grain is smaller
        const double grain = equations_.pose().grain(*owner_[row], static_cast<int>(row));
        return std::abs(C[row]) <= thresholds_.closed_grains * grain;
    }

    bool part(double* y, double& left, double part_of_it) {
        std::copy(y, y + before_.size(), before_.begin());
        move(y, part_of_it);
        if (const double now = scaled(equations_.constraint()); now < (1.0 - 0.5 * part_of_it) * left) {
            left = now;
            return true;
        }
        std::copy(before_.begin(), before_.end(), y);
        equations_.set_pose(y);
        equations_.constraint();
        return false;
    }

    bool turning_less(double* y, double& left, Metric metric, double limit) {
        std::fill(added_.begin(), added_.end(), 0.0);
        bool found = false;
        for (int trial = 0; trial < thresholds_.most_halvings && !found && stiffen(metric, limit); ++trial) {
            found = whole(y, left);
            limit = thresholds_.tighter * std::min(limit, widest());
        }
        equations_.stiffen({});
        return found;
    }

    // A correction that turns no body by more than `limit`; false where added moments of inertia do not achieve that.
    bool stiffen(Metric metric, double limit) {
        for (int pass = 0; pass < thresholds_.most_passes; ++pass) {
            equations_.stiffen(added_);
            if (!equations_.factor(metric) || !solve(equations_.C())) return false;
            if (widest() <= limit) return true;
            for (std::size_t b = 0; b < added_.size(); ++b)
                if (const double turn = equations_.solver().turn(static_cast<int>(b)).norm(); turn > limit)
                    added_[b] += thresholds_.stiffer * (moment_[b] + added_[b]) * turn / limit;
        }
        return false;
    }

    // The largest turn of a body, rad.
    double widest() const {
        double turn2 = 0.0;
        for (int b = 0; b < model_.size(); ++b) turn2 = std::max(turn2, equations_.solver().turn(b).squaredNorm());
        return std::sqrt(turn2);
    }

    EquationsOfMotion<D>& equations_;
    ContactBorder<D>& contacts_;
    const Model<D>& model_;
    const Thresholds& thresholds_;
    double shortest_ = std::ldexp(1.0, -thresholds_.most_halvings);  // the smallest part of a correction
    std::vector<const Instance<D>*> owner_;                          // of each row
    std::vector<double> rhs_, before_, moment_, added_;
};

}  // namespace mbproj
