// The poses and velocities of the bodies: from the state vector to points, vectors and their derivatives.
#pragma once

#include "kinematics/primitives.hpp"

namespace mbproj {

// A view of one body's part of a state vector.
template <class D> struct Part {
    using S = Size<D>;
    const Scalar<D>* at;
    Part(const Scalar<D>* y, int body) : at(y + S::state * body) {}
    auto position() const { return matrix_at<D::axes>(at); }
    auto orientation() const { return matrix_at<S::orientation>(at + D::axes); }
    auto velocity() const { return matrix_at<D::axes>(at + S::pose); }
    auto omega() const { return matrix_at<S::turns>(at + S::pose + D::axes); }
};

template <class D> struct WritablePart {
    using S = Size<D>;
    Scalar<D>* at;
    WritablePart(Scalar<D>* y, int body) : at(y + S::state * body) {}
    auto position() const { return matrix_at<D::axes>(at); }
    auto orientation() const { return matrix_at<S::orientation>(at + D::axes); }
    auto velocity() const { return matrix_at<D::axes>(at + S::pose); }
    auto omega() const { return matrix_at<S::turns>(at + S::pose + D::axes); }
};

template <class D> struct Placement {
    Point<D> position;
    Rotation<D> rotation;
};

template <class D> struct Twist {
    Point<D> velocity;
    Turn<D> omega;  // global axes
};

// Every body's pose, the ground's last, and the constraints' attachments in global axes.
template <class D> class Pose final {
public:
    const double* held = nullptr;  // the branches of curves, or none

    explicit Pose(const Model<D>& model)
        : model_(model), bodies_(model.size() + 1), spokes_(model.constraints.attachments.size()),
          curves_(model.curves.size()), touches_(model.curves.size()) {
        bodies_.back() = {Point<D>::Zero(), Rotation<D>::Identity()};
    }
    void update(const Scalar<D>* y) {
        place_bodies(y);
        for (std::size_t a = 0; a < spokes_.size(); ++a) {
            const Attachment<D>& attachment = model_.constraints.attachments[a];
            spokes_[a] = bodies_[attachment.body].rotation * attachment.local;
        }
        if (!curves_.empty()) update_curves();
    }
    // The argument of a curve that belongs to a row.
    Scalar<D> curved(std::size_t number) const {
        const Instance<D>& p = model_.constraints.instances[model_.curves[number].instance];
        if (!p.on_line()) return value<D>(p, Places(*this, p).x);
        return model_.curves[number].second ? touches_[p.follower].other.s : touches_[number].foot.s;
    }
    // The geometry at the contact of an instance that follows a curve, if its foot stays on a piece; else null.
    const Touch<D>* touch(const Instance<D>& p) const { return p.follower < 0 ? nullptr : &touches_[p.follower]; }
    // The piece on which a follower's foot is held; none where it is free.
    int piece(int number) const {
        if (number < 0) return PlaneCurve::free;
        const int at = model_.programs.start[model_.curves[number].program] + 1;
        if (!held || isnan(held[at])) return PlaneCurve::free;
        const int table = static_cast<int>(model_.programs.operand[at]);
        return static_cast<int>(held[at]) - model_.programs.table_start[table];
    }
    // f, f' and f'' of a curve at this pose.
    const Series<Scalar<D>>& curve(int number) const { return curves_[number]; }
    // The derivative of a row by the value of an instance.
    Scalar<D> weight(const Instance<D>& p) const { return p.curve < 0 ? p.weight : p.weight - curves_[p.curve].d; }
    const Placement<D>& operator[](int body) const { return bodies_[body]; }
    // Whether all numbers are finite.
    bool finite() const {
        for (const Placement<D>& each : bodies_)
            if (!each.position.allFinite() || !each.rotation.allFinite()) return false;
        return true;
    }

    // A constraint's attachment: the vector from its body's centre of mass (spoke), and the point or vector itself.
    const Point<D>& spoke(int attachment) const { return spokes_[attachment]; }
    Point<D> place(int attachment) const {
        const Attachment<D>& a = model_.constraints.attachments[attachment];
        return a.is_point ? Point<D>(bodies_[a.body].position + spokes_[attachment]) : spokes_[attachment];
    }

    // ε × the largest coordinate of the points of an instance and of those coupled with it; at least ε times the row's
    // scale or 1, whichever is less.
    Scalar<D> grain(const Instance<D>& first, int row) const {
        Scalar<D> reach = min(1.0, model_.row_scale[row]);
        const Instance<D>* const end = model_.constraints.instances.data() + model_.constraints.instances.size();
        for (const Instance<D>* p = &first; p == &first || (p != end && p->rows == 0); ++p)
            for (int s = 0; s < p->slot_count; ++s) {
                const Attachment<D>& a = model_.constraints.attachments[p->slots[s]];
                if (a.is_point) reach = max(reach, bodies_[a.body].position.largest() + a.size);
            }
        return std::numeric_limits<double>::epsilon() * reach;
    }

private:
    void place_bodies(const Scalar<D>* y) {
        if constexpr (std::is_same_v<D, Plane<double>>) return place_at_once(y);
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> part(y, b);
            bodies_[b] = {part.position(), rotation(Orientation<D>(part.orientation()))};
        }
    }
    // In the plane an orientation is an angle: sines are computed for several bodies at once.
    void place_at_once(const double* y) {
        double angle[at_once] = {}, sine[at_once], cosine[at_once];
        for (int first = 0; first < model_.size(); first += at_once) {
            const int count = std::min(at_once, model_.size() - first);
            for (int k = 0; k < count; ++k) angle[k] = Part<D>(y, first + k).orientation()[0];
            sines_and_cosines(angle, sine, cosine);
            for (int k = 0; k < count; ++k) {
                Placement<D>& body = bodies_[first + k];
                body.position = Part<D>(y, first + k).position();
                body.rotation << cosine[k], -sine[k], sine[k], cosine[k];
            }
        }
    }

    // The points and vectors of an instance.
    struct Places {
        Point<D> x[most_slots];
        Places(const Pose& pose, const Instance<D>& p) {
            for (int s = 0; s < p.slot_count; ++s) x[s] = pose.place(p.slots[s]);
        }
    };

    void update_curves() {
        for (std::size_t c = 0; c < curves_.size(); ++c) {
            if (model_.curves[c].of != Of::row) continue;
            if (const Instance<D>& p = model_.constraints.instances[model_.curves[c].instance]; p.on_line()) {
                if (!model_.curves[c].second)
                    touches_[c] = on_curve::touch<D>(p, Places(*this, p).x, piece(p.follower), piece(p.other_follower));
                continue;
            }
            const Series<Scalar<D>> variables[law_variables] = {{}, {curved(c), 1.0, 0.0}, {}};
            curves_[c] = model_.programs.run(model_.curves[c].program, variables, held);
        }
    }

    const Model<D>& model_;
    std::vector<Placement<D>> bodies_;
    std::vector<Point<D>> spokes_;
    std::vector<Series<Scalar<D>>> curves_;
    std::vector<Touch<D>> touches_;
};

// Every body's velocities at a pose, the ground's last.
template <class D> class Motion final {
public:
    explicit Motion(const Model<D>& model) : bodies_(model.size() + 1) {
        bodies_.back() = {Point<D>::Zero(), Turn<D>::Zero()};
    }
    void update(const Scalar<D>* y, const Pose<D>& pose) {
        for (std::size_t b = 0; b + 1 < bodies_.size(); ++b) {
            const Part<D> part(y, static_cast<int>(b));
            bodies_[b] = {part.velocity(), to_global(pose[static_cast<int>(b)].rotation, Turn<D>(part.omega()))};
        }
    }
    const Twist<D>& operator[](int body) const { return bodies_[body]; }

private:
    std::vector<Twist<D>> bodies_;
};

// The time in which a violation of the velocities counts as one of the positions: the mechanism moves by its own length
// or 1 rad in it. It is 0 at rest.
template <class D> Scalar<D> time_scale(const Model<D>& model, const Scalar<D>* y) {
    const Scalar<D> rest = model.thresholds.rest_rate;
    Scalar<D> speed = 0.0;
    for (int b = 0; b < model.size(); ++b) {
        const Part<D> part(y, b);
        speed = max({speed, part.velocity().norm() / model.length, part.omega().norm()});
    }
    return speed / (speed * speed + rest * rest);
}

}  // namespace mbproj
