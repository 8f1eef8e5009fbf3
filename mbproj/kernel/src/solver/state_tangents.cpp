// The tangents of states, in the plane and in space: the only place where the kernel computes with dual numbers.
#include "solver/state_tangents.hpp"

namespace mbproj {

template <class D> StateTangents<D>::StateTangents(const Model<D>& model, const Tableau& tableau, Metric metric,
                                                   Answers& answers, const double* numbers, int count)
    : model_([&] {
          auto own = with<Dual>(model);
          const auto loads = own.loads ? std::make_shared<Loads<Duals>>(*own.loads) : nullptr;
          std::size_t size = 0, at = 0;
          each_number(own, loads.get(), [&](const Dual&) { ++size; });
          each_number(own, loads.get(), [&](Dual& number) {
              for (int k = 0; k < count; ++k) number.tangent[k] = numbers[k * size + at];
              ++at;
          });
          own.loads = loads;
          return own;
      }()),
      tableau_(tableau), metric_(metric), answers_(answers), count_(count), pose_(model_), motion_(model_),
      channels_(model_), applied_(model_), drive_(model_), states_(model_), y_(model.layout.size()), stage_(y_),
      before_(y_), begun_(y_), k_(tableau.stages() + 1 + tableau.extra_c.size(), y_), rows_(model.all_rows()),
      moved_(model.size()), residual_(model.size()), at_(model.layout.size()), slope_(at_),
      lambda_(model.all_multipliers()), forces_(F * model.size()), rhs_(model.all_rows()), changes_(forces_),
      tangents_(count * forces_.size()) {}

template <class D> bool StateTangents<D>::start(double t, const double* y, const double* slopes) {
    for (std::size_t i = 0; i < y_.size(); ++i) {
        y_[i] = y[i];
        for (int k = 0; k < count_; ++k) y_[i].tangent[k] = slopes[k * y_.size() + i];
    }
    drive_.set(t, {});
    return close(t, y, true, true);
}

template <class D> bool StateTangents<D>::stand(double t, const double* y) {
    for (std::size_t i = 0; i < y_.size(); ++i) y_[i] = y[i];
    drive_.set(t, {});
    return close(t, y, true, true);
}

template <class D>
void StateTangents<D>::combine(const Vector& y, double h, const double* weights, int count, Vector& out) const {
    out = y;
    for (int j = 0; j < count; ++j)
        if (const double weight = h * weights[j]; weight != 0.0)
            for (std::size_t i = 0; i < out.size(); ++i) out[i] += weight * k_[j][i];
}

template <class D> static void normalise(std::vector<Dual>& y, int bodies) {
    for (int b = 0; b < bodies; ++b) {
        WritablePart<D> part(y.data(), b);
        part.orientation() = normalised(Orientation<D>(part.orientation()));
    }
}

template <class D> bool StateTangents<D>::follow(const StepMade& step, const double* y) {
    for (int s = 0; s < tableau_.stages(); ++s) {
        combine(y_, step.h, tableau_.a.row(s).data(), s, stage_);
        if (!evaluate(step.t + tableau_.c[s] * step.h, step.window, stage_, k_[s])) return false;
    }
    combine(y_, step.h, tableau_.b.data(), tableau_.stages(), stage_);
    y_.swap(stage_);
    normalise<Duals>(y_, model_.size());
    drive_.set(step.end, {});
    return close(step.end, y, step.position, step.velocity);
}

// f at the step's end, before its projection, and the extra stages, as in the run itself.
template <class D> bool StateTangents<D>::extend(const StepMade& step) {
    const int stages = tableau_.stages();
    if (tableau_.dense.rows() <= stages) return true;
    combine(begun_, step.h, tableau_.b.data(), stages, stage_);
    if (!evaluate(step.t + step.h, step.window, stage_, k_[stages])) return false;
    for (std::size_t x = 0; x < tableau_.extra_c.size(); ++x) {
        const int known = stages + 1 + static_cast<int>(x);
        combine(begun_, step.h, tableau_.extra_a.row(x).data(), known, stage_);
        if (!evaluate(step.t + tableau_.extra_c[x] * step.h, step.window, stage_, k_[known])) return false;
    }
    return true;
}

template <class D>
bool StateTangents<D>::inside(const StepMade& step, double t, const double* y, std::vector<Dual>& found) {
    const int stages = static_cast<int>(tableau_.dense.rows());
    const double theta = (t - step.t) / step.h;
    std::vector<double> weights(stages);
    for (int s = 0; s < stages; ++s)
        for (Eigen::Index d = tableau_.dense.cols(); d-- > 0;) weights[s] = theta * (tableau_.dense(s, d) + weights[s]);
    Vector end = y_;
    combine(begun_, step.h, weights.data(), stages, y_);
    normalise<Duals>(y_, model_.size());
    drive_.set(t, {});
    const bool closed = close(t, y, step.position, step.velocity);
    found = y_;
    y_.swap(end);
    return closed;
}

// y' at a state, and its derivatives.
template <class D> bool StateTangents<D>::evaluate(double t, const TimeWindow& window, const Vector& y, Vector& slope) {
    std::transform(y.begin(), y.end(), at_.begin(), [](const Dual& number) { return number.value; });
    if (!answers_.slope(t, at_.data(), slope_.data(), lambda_.data()) || !drive_.set(t, window)) return false;
    pose_.update(y.data());
    motion_.update(y.data(), pose_);
    channels_.set(window.clamped(t), y.data(), pose_, motion_);
    if (model_.loads && !applied_.update(*model_.loads, pose_, motion_, channels_)) return false;
    std::copy(slope_.begin(), slope_.end(), slope.begin());
    if (states_.any() && !states_.set(channels_, slope.data())) return false;
    for (int b = 0; b < model_.size(); ++b) {
        const Part<D> part(slope_.data(), b);
        const Rotation<D> A = values_of(pose_[b].rotation);
        moved_[b].template head<D::axes>() = with<Dual>(Point<D>(part.velocity()));
        moved_[b].template tail<S::turns>() = with<Dual>(to_global(A, Turn<D>(part.omega())));
    }
    moving_rows<Duals>(model_, pose_, motion_, nullptr, rows_.data());
    for (std::size_t k = 0; k < drive_.size(); ++k) rows_[model_.driven[k].row] += drive_[k].dd;
    set_residual(y);
    if (!respond()) return false;
    for (int b = 0; b < model_.size(); ++b) {
        const Part<Duals> part(y.data(), b);
        WritablePart<Duals> out(slope.data(), b);
        const Column<F, Dual> acceleration = moved_[b] + change(b);
        out.position() = part.velocity();
        out.orientation() = orientation_rate(Orientation<Duals>(part.orientation()), Turn<Duals>(part.omega()));
        out.velocity() = acceleration.template head<D::axes>();
        out.omega() = to_body(pose_[b].rotation, Turn<Duals>(acceleration.template tail<S::turns>()));
    }
    return true;
}

// Calls visit(row, body, ∂row) for all rows from the first on, and each body that they act on.
template <class D> template <class Visit> void StateTangents<D>::each_gradient(int first_row, Visit&& visit) const {
    Matrix<6, F, Dual> G;
    for (const Joint& joint : model_.joints) {
        if (joint.row + joint.rows <= first_row) continue;
        for (const int b : joint.bodies) {
            jacobian<Duals>(model_, pose_, joint, b, G);
            for (int r = 0; r < joint.rows; ++r) visit(joint.row + r, b, G.row(r));
        }
    }
}

// W δ of a body in the current metric.
template <class D> Column<Size<D>::freedoms, Dual> StateTangents<D>::momentum(int body) const {
    Column<F, Dual> found = moved_[body];
    const Turn<Duals> turn = found.template tail<S::turns>();
    if (!weighs_) {
        found.template tail<S::turns>() = 0.25 * turn;
        return found;
    }
    found.template head<D::axes>() *= model_.bodies[body].mass;
    found.template tail<S::turns>() = inertia_in_global(pose_[body].rotation, model_.bodies[body].inertia) * turn;
    return found;
}

// Sets the residuals f - W a - Gᵀλ of the bodies, and γ - G a of the rows, which are 0; their derivatives are not.
template <class D> void StateTangents<D>::set_residual(const Vector& y) {
    weighs_ = true;
    for (int b = 0; b < model_.size(); ++b) {
        const Body<Duals>& body = model_.bodies[b];
        Point<Duals> force = body.mass * model_.gravity;
        Turn<Duals> torque = Turn<Duals>::Zero();
        if constexpr (D::axes == 3) {
            const Turn<Duals> omega = Part<Duals>(y.data(), b).omega();
            const Turn<Duals> momentum = body.inertia * omega;
            torque = pose_[b].rotation * momentum.cross(omega);
        }
        if (model_.loads) {
            force += applied_.force[b];
            torque += applied_.torque[b];
        }
        residual_[b] << force, torque;
        residual_[b] -= momentum(b);
    }
    each_gradient(0, [&](int row, int b, const auto& gradient) {
        residual_[b] -= Dual(lambda_[row]) * gradient.transpose();
        rows_[row] -= gradient.dot(moved_[b]);
    });
    const int first = model_.constraints.rows;  // a flywheel's own rate changes by λ / I
    for (std::size_t f = 0; f < model_.flywheels.size(); ++f)
        rows_[first + f] += lambda_[first + f] / model_.flywheels[f];
}

// Solves for the derivatives of the solution, direction by direction.
template <class D> bool StateTangents<D>::respond() {
    for (int k = 0; k < count_; ++k) {
        for (std::size_t b = 0; b < residual_.size(); ++b)
            for (int i = 0; i < F; ++i) forces_[F * b + i] = residual_[b][i].tangent[k];
        for (std::size_t r = 0; r < rhs_.size(); ++r) rhs_[r] = rows_[r].tangent[k];
        if (!answers_.respond(forces_.data(), rhs_.data(), changes_.data(), nullptr)) return false;
        std::copy(changes_.begin(), changes_.end(), tangents_.begin() + k * changes_.size());
    }
    return true;
}

// Solves for the derivatives of a projection that has moved the bodies by δ: W δ + Gᵀμ = 0, rows' values in `rows_`.
template <class D> bool StateTangents<D>::respond_to_projection() {
    const int first = model_.constraints.rows;
    for (std::size_t r = 0; r < rows_.size(); ++r) rows_[r] = static_cast<int>(r) < first ? -rows_[r] : Dual(0.0);
    weighs_ = metric_ == Metric::mass;
    if (weighs_)
        each_gradient(first, [&](int row, int b, const auto& gradient) { rows_[row] -= gradient.dot(moved_[b]); });
    for (std::size_t b = 0; b < residual_.size(); ++b) {
        residual_[b] = -momentum(static_cast<int>(b));
        for (int i = 0; i < F; ++i) forces_[F * b + i] = residual_[b][i].value;
    }
    for (std::size_t r = 0; r < rhs_.size(); ++r) rhs_[r] = static_cast<int>(r) < first ? 0.0 : rows_[r].value;
    if (!answers_.respond(forces_.data(), rhs_.data(), changes_.data(), lambda_.data())) return false;
    each_gradient(
        0, [&](int row, int b, const auto& gradient) { residual_[b] -= Dual(lambda_[row]) * gradient.transpose(); });
    for (std::size_t f = 0; f < model_.flywheels.size(); ++f)
        rows_[first + f] += lambda_[first + f] / model_.flywheels[f];
    return respond();
}

// The derivatives of a body's part of the last solution.
template <class D> Column<Size<D>::freedoms, Dual> StateTangents<D>::change(int body) const {
    Column<F, Dual> found = Column<F, Dual>::Zero();
    for (int i = 0; i < F; ++i)
        for (int k = 0; k < count_; ++k) found[i].tangent[k] = tangents_[k * changes_.size() + F * body + i];
    return found;
}

// Sets the state to y of the run, and makes its derivatives satisfy the joints there.
template <class D> bool StateTangents<D>::close(double t, const double* y, bool position, bool velocity) {
    before_ = y_;
    set(y);
    if (!(position || velocity)) return true;
    if (!answers_.close(t, y)) return false;
    pose_.update(y_.data());
    return (!position || close_position(y)) && (!velocity || close_velocity(y));
}

// The small rotation between two orientations, as an argument of `turned`.
static Column<3, Dual> turn_between(const Column<4, Dual>& from, const Column<4, Dual>& to) {
    return (2.0 / from.dot(to)) * (matrix_E(from) * to);
}
static Column<1, Dual> turn_between(const Column<1, Dual>& from, const Column<1, Dual>& to) {
    return Column<1, Dual>(remainder(to[0] - from[0], 4.0 * M_PI));
}

template <class D> bool StateTangents<D>::close_position(const double* y) {
    for (int b = 0; b < model_.size(); ++b) {
        const Part<Duals> from(before_.data(), b), to(y_.data(), b);
        moved_[b] << Point<Duals>(to.position() - from.position()),
            turn_between(Orientation<Duals>(from.orientation()), Orientation<Duals>(to.orientation()));
    }
    constraint<Duals>(model_, pose_, rows_.data());
    for (std::size_t k = 0; k < drive_.size(); ++k) rows_[model_.driven[k].row] -= drive_.prescribed(k);
    if (!respond_to_projection()) return false;
    for (int b = 0; b < model_.size(); ++b) {
        WritablePart<Duals> part(y_.data(), b);
        const Column<F, Dual> by = change(b);
        part.position() += by.template head<D::axes>();
        part.orientation() = turned(Orientation<Duals>(part.orientation()), Turn<Duals>(by.template tail<S::turns>()));
    }
    set(y);
    pose_.update(y_.data());
    return true;
}

template <class D> bool StateTangents<D>::close_velocity(const double* y) {
    motion_.update(y_.data(), pose_);
    for (int b = 0; b < model_.size(); ++b) {
        const Part<Duals> from(before_.data(), b), to(y_.data(), b);
        moved_[b] << Point<Duals>(to.velocity() - from.velocity()),
            to_global(pose_[b].rotation, Turn<Duals>(to.omega() - from.omega()));
    }
    moving_rows<Duals>(model_, pose_, motion_, rows_.data(), nullptr);
    for (std::size_t k = 0; k < drive_.size(); ++k) rows_[model_.driven[k].row] -= drive_[k].d;
    if (!respond_to_projection()) return false;
    for (int b = 0; b < model_.size(); ++b) {
        WritablePart<Duals> part(y_.data(), b);
        const Column<F, Dual> by = change(b);
        part.velocity() += by.template head<D::axes>();
        part.omega() += to_body(pose_[b].rotation, Turn<Duals>(by.template tail<S::turns>()));
    }
    set(y);
    return true;
}

template <class D> void StateTangents<D>::set(const double* values) {
    for (std::size_t i = 0; i < y_.size(); ++i) y_[i].value = values[i];
}

template class StateTangents<Plane<double>>;
template class StateTangents<Space<double>>;

}  // namespace mbproj
