// The projection of several cases at once, as by `Projector` and `TrustRegion` where nothing rare happens. A lane whose
// correction would have to be damped leaves. Lanes need not agree on how many passes they make, nor when they need a
// fresh factor: those that can use the current factor go first, and the others wait for a new one.
#pragma once

#include "ensembles/packed_equations.hpp"

namespace mbproj {

// Whether packs make projections with these settings.
inline bool fits_packs(const ProjectionSettings& settings) {
    return (settings.correction == Correction::mass || settings.correction == Correction::coordinates) &&
           !settings.paper_test && settings.threshold < 0.0 && !settings.fallback;
}

// The passes of a projection in each lane, and its change of the velocity, as a part of the velocity and as it is.
struct PackedProjected {
    LaneCounts position_passes, velocity_passes;
    Pack velocity_change = 0.0, speed_change = 0.0;
};

template <class P> class PackedProjection final {
public:
    using S = Size<P>;

    PackedProjection(PackedEquations<P>& equations, const ProjectionSettings& settings)
        : equations_(equations), model_(equations.model()), thresholds_(model_.thresholds), settings_(settings),
          metric_(settings.correction == Correction::coordinates ? Metric::coordinates : Metric::mass),
          before_(S::pose * model_.size()), rhs_(model_.all_rows()) {
        for (const Instance<P>& p : model_.constraints.instances) owner_.insert(owner_.end(), p.rows, &p);
    }

    // Whether step number `step` of a case is projected.
    bool is_due(long step) const { return model_.constraints.rows > 0 && step % settings_.every == 0; }

    // Projects y at t after a step, in those lanes that are `due`; its pose is in place then.
    PackedProjected after_step(const Pack& t, Pack* y, const Mask& due) {
        normalise(y);
        equations_.set_pose(t, y);
        return correct(y, due, !equations_.holds(metric_));
    }
    // Projects a state between two steps.
    PackedProjected anywhere(const Pack& t, Pack* y) {
        normalise(y);
        equations_.set_pose(t, y);
        return correct(y, model_.constraints.rows > 0, true);
    }

private:
    PackedProjected correct(Pack* y, const Mask& due, bool fresh) {
        PackedProjected done;
        const OnlyLanes only(due);
        if (Lanes::in().none()) return done;
        if (settings_.position) correct_position(y, done, fresh);
        if (settings_.velocity) correct_velocity(y, done);
        return done;
    }

    void normalise(Pack* y) const {
        for (int b = 0; b < model_.size(); ++b) {
            auto orientation = WritablePart<P>(y, b).orientation();
            orientation = normalised(Orientation<P>(orientation));
        }
    }

    // See Projector::by_violation.
    void correct_position(Pack* y, PackedProjected& done, bool begins_fresh) {
        Pack left = scaled(equations_.constraint());
        Mask fresh = begins_fresh, settled = false;
        for (;;) {
            const Mask open = Lanes::in() & ~settled & ~meets(equations_.constraint());
            if (open.none()) return;
            const Mask holding = open & ~fresh;
            const bool anew = holding.none();
            const OnlyLanes only(anew ? open : holding);
            if (anew) equations_.factor(metric_);
            solve(equations_.constraint());
            const Mask tried = Lanes::in();
            done.position_passes.add(tried);
            for (int k = 0; k < pack_width; ++k)
                if (tried[k] && done.position_passes.of[k] > settings_.max_iterations) Lanes::leave(k);
            const Mask last = anew ? may_be_round_off(equations_.constraint()) : Mask(false);
            if (anew) Lanes::keep(last | (widest() <= thresholds_.widest_turn));
            const Pack before = left;
            const Mask moved = whole(y, left);
            if (anew) settled |= tried & last & ~moved;
            if (anew) Lanes::keep(last | moved);
            fresh = (fresh & ~tried) | (tried & ~(moved & (left < thresholds_.slow * before)));
        }
    }
    // Moves y by the current correction, in the lanes that are in, where that reduces the violation by half of what
    // Newton's method predicts. Returns these lanes.
    Mask whole(Pack* y, Pack& left) {
        const Mask tried = Lanes::in();
        for (int b = 0; b < model_.size(); ++b) {
            WritablePart<P> part(y, b);
            std::copy_n(part.at, S::pose, &before_[S::pose * b]);
            part.position() += equations_.solver().shift(b);
            part.orientation() = turned(Orientation<P>(part.orientation()), Turn<P>(equations_.solver().turn(b)));
        }
        keep_others(y, tried);
        equations_.set_pose(y);
        const Pack now = scaled(equations_.constraint());
        const Mask moved = tried & (now < 0.5 * left);
        left = where(moved, now, left);
        if ((tried & ~moved).any()) {
            keep_others(y, moved);
            equations_.set_pose(y);
        }
        return moved;
    }
    // Restores the poses of all other lanes.
    void keep_others(Pack* y, const Mask& moved) const {
        if ((~moved).none()) return;
        for (int b = 0; b < model_.size(); ++b)
            for (int i = 0; i < S::pose; ++i)
                y[S::state * b + i] = where(moved, y[S::state * b + i], before_[S::pose * b + i]);
    }

    void correct_velocity(Pack* y, PackedProjected& done) {
        const Pack* C_dot = equations_.constraint_velocity(y);
        equations_.factor(metric_);
        solve(C_dot);
        const Mask corrected = Lanes::in();
        const Pack length2 = model_.length * model_.length;
        Pack change2 = 0.0, speed2 = 0.0;
        for (int b = 0; b < model_.size(); ++b) {
            const Point<P> shift = equations_.solver().shift(b);
            const Turn<P> turn = equations_.solver().turn(b);
            WritablePart<P> part(y, b);
            change2 += shift.squaredNorm() + length2 * turn.squaredNorm();
            speed2 += part.velocity().squaredNorm() + length2 * part.omega().squaredNorm();
            part.velocity() = chosen(corrected, part.velocity() + shift, part.velocity());
            part.omega() = chosen(corrected, part.omega() + to_body(equations_.pose()[b].rotation, turn), part.omega());
        }
        done.velocity_passes.add(corrected);
        done.velocity_change = where(corrected, sqrt(change2 / speed2), 0.0);
        done.speed_change = where(corrected, sqrt(change2), 0.0);
    }

    // a in these lanes, b in the others.
    template <class A, class B> static A chosen(const Mask& lanes, const A& a, const B& b) {
        A found;
        for (int i = 0; i < A::rows(); ++i) found[i] = where(lanes, a[i], b[i]);
        return found;
    }

    void solve(const Pack* violation) {
        for (std::size_t r = 0; r < rhs_.size(); ++r) rhs_[r] = -violation[r];
        equations_.solver().clear_forces();
        if (!equations_.solver().solve(rhs_.data())) Lanes::set(false);
    }

    // The largest row that is open by more than round-off, with lengths in parts of the mechanism's.
    Pack scaled(const Pack* C) const {
        Pack most = 0.0;
        for (std::size_t r = 0; r < owner_.size(); ++r) {
            const Pack size = abs(C[r]);
            const Pack least = std::numeric_limits<double>::epsilon() * min(1.0, model_.row_scale[r]);
            Mask open = ~(size <= thresholds_.closed_grains * least);  // no grain is smaller
            if ((open & Lanes::in()).none()) continue;
            open &= ~(size <= thresholds_.closed_grains * equations_.pose().grain(*owner_[r], static_cast<int>(r)));
            most = where(open, larger(most, size / model_.row_scale[r]), most);
        }
        return most;
    }

    Mask meets(const Pack* C) const {
        Pack most = 0.0;
        for (int r = 0; r < model_.constraints.rows; ++r) most = larger(most, abs(C[r]));
        if (settings_.tolerance >= 0.0) return most <= settings_.tolerance;
        const Mask found = most <= thresholds_.closed_to * min(1.0, model_.length);
        if ((Lanes::in() & ~found).none()) return found;
        return found | within(C, thresholds_.closed_grains, thresholds_.closed_to);
    }
    Mask may_be_round_off(const Pack* C) const {
        const double tolerance = settings_.tolerance >= 0.0 ? settings_.tolerance : thresholds_.closed_to;
        return within(C, thresholds_.round_off_grains, tolerance);
    }
    Mask within(const Pack* C, double grains, double least) const {
        Mask found = true;
        for (const Instance<P>& p : model_.constraints.instances)
            for (int r = p.row; r < p.row + p.rows; ++r) {
                const Pack smallest = least * min(1.0, model_.row_scale[r]);
                found &= abs(C[r]) <= max(smallest, grains * equations_.pose().grain(p, r));
            }
        return found;
    }

    // The largest turn of a body, rad.
    Pack widest() const {
        Pack turn2 = 0.0;
        for (int b = 0; b < model_.size(); ++b) turn2 = max(turn2, equations_.solver().turn(b).squaredNorm());
        return sqrt(turn2);
    }

    PackedEquations<P>& equations_;
    const Model<P>& model_;
    const Thresholds& thresholds_;
    const ProjectionSettings& settings_;
    const Metric metric_;
    std::vector<const Instance<P>*> owner_;  // of each row
    std::vector<Pack> before_, rhs_;
};

}  // namespace mbproj
