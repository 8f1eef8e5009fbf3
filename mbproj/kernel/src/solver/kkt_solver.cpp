#include "solver/kkt_solver.hpp"

namespace mbproj {

template <class D> KktSolver<D>::KktSolver(const Model<D>& model, std::optional<double> penalty)
    : model_(model), thresholds_(model.thresholds), compliance_(model), order_(model, !penalty),
      leaves_(model, order_.leaves), loops_(model, order_, compliance_), shift_(penalty ? 1.0 / *penalty : 0.0),
      lent_(lent_mass(model)), inertias_(model.size()), reference_(model.size() + 1, Point<D>::Zero()),
      is_bare_(model.size(), false), force_(model.size() + 1), delta_(model.size() + 1) {
    for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b) is_bare_[order_.loop_bodies[b]] = !loops_.is_hinged(b);
    for (const LoopHinge<D>& hinge : order_.loop_hinges)
        if (hinge.parent() < model.size()) is_bare_[hinge.parent()] = false;
    for (const Leaf<D>& leaf : order_.leaves)
        if (leaf.hinge.parent < model.size()) is_bare_[leaf.hinge.parent] = false;
    for (int b = 0; b < model.size(); ++b)
        if (!is_bare_[b] || model.bodies[b].is_light) with_inertia_.push_back(b);
}

template <class D> void KktSolver<D>::leave_out(const std::vector<int>& rows) {
    if (rows != loops_.left_out()) loops_.leave_out(rows);
}

template <class D> bool KktSolver<D>::factor(const Pose<D>& pose, Metric metric, double near) {
    ++factorisations_;
    metric_ = metric;
    const Compliance<D>* stiff = metric == Metric::stiff ? &compliance_ : nullptr;
    if (const int joint = leaves_.set_pose(pose, reference_, stiff); joint >= 0) return fails(joint);
    if (stiff_.empty())
        for (const int b : with_inertia_) set_inertia(b, pose[b].rotation, metric);
    else
        for (int b = 0; b < model_.size(); ++b) set_inertia(b, pose[b].rotation, metric);
    if (const int joint = leaves_.factor(inertias_, reference_, metric != Metric::coordinates); joint >= 0)
        return fails(joint);
    if (order_.loop_bodies.empty()) return true;
    if (const int joint = loops_.set_hinges(pose); joint >= 0) return fails(joint);
    if (!set_halves(pose, metric)) return fails(-1);
    if (order_.loop_joints.empty()) return true;
    loops_.leave_none_out();
    const double shift = metric == Metric::penalised ? shift_ : 0.0;
    const int failed = loops_.factor(pose, thresholds_.no_digits, shift);
    if (failed >= 0 && stiff) return loops_.factor_by_qr(pose) || fails(-1);
    if (failed >= 0 || pivots_part() < near)
        if (near == 0.0 || !factor_near_singular(pose, shift, failed, near)) return fails(failed);
    return true;
}

template <class D> bool KktSolver<D>::is_clear(const Pose<D>& pose, double near) {
    return is_regular() && metric_ == Metric::mass && near < even_nearness(pose);
}

template <class D> bool KktSolver<D>::is_near_singular(const Pose<D>& pose, double near) {
    ++close_looks_;
    return count_dependent(pose, near * model_.rows.even) > model_.rows.redundant;
}

template <class D> int KktSolver<D>::count_dependent(const Pose<D>& pose, double smallest) {
    return static_cast<int>(loops_.dependent_rows(pose, smallest).size());
}

template <class D> double KktSolver<D>::even_pivot(const Pose<D>& pose) {
    ++close_looks_;
    return loops_.even_pivot(pose);
}

template <class D> bool KktSolver<D>::solve(const double* c, double* lambda) {
    leaves_.solve_up(c, force_);
    const bool settled = order_.loop_bodies.empty() || loops_.solve(force_, c, delta_, metric_ == Metric::penalised);
    delta_.back().setZero();
    leaves_.solve_down(delta_, lambda);
    if (lambda) loops_.multipliers(lambda);
    return settled || fails(-1);
}

template <class D> bool KktSolver<D>::spread(const Pose<D>& pose, double* lambda) {
    loops_.multipliers(lambda);
    if (left_out().empty()) return true;
    return spread_over_all(pose, lambda, near_singular() ? thresholds_.half_digits : thresholds_.no_digits);
}

template <class D> bool KktSolver<D>::spread_over_all(const Pose<D>& pose, double* lambda) {
    return spread_over_all(pose, lambda, thresholds_.no_digits);
}

template <class D> bool KktSolver<D>::spread_over_all(const Pose<D>& pose, double* lambda, double shift) {
    if (!smallest_) smallest_ = std::make_unique<MinimumNormMultipliers<D>>(model_, order_);
    return smallest_->spread(pose, shift, lambda);
}

template <class D> bool KktSolver<D>::factor_near_singular(const Pose<D>& pose, double shift, int failed, double near) {
    ++close_looks_;
    near_ = near;
    const int dependent = loops_.leave_out_dependent(pose, near * model_.rows.even);
    if (dependent == 0 && failed >= 0) return loops_.factor_by_qr(pose);
    return loops_.factor(pose, thresholds_.no_digits, shift) < 0;
}

template <class D> double KktSolver<D>::pivots_part() const {
    if (metric_ == Metric::coordinates) return cholesky().smallest_pivot() / model_.rows.even;
    return cholesky().nearness();
}

template <class D> bool KktSolver<D>::lends_inertia(int body, Metric metric) const {
    return model_.bodies[body].is_light && metric != Metric::coordinates;
}

template <class D> bool KktSolver<D>::takes_inertia(int body, Metric metric) const {
    return !is_bare_[body] || lends_inertia(body, metric) || !stiff_.empty();
}

template <class D> bool KktSolver<D>::set_halves(const Pose<D>& pose, Metric metric) {
    const bool by_coordinates = metric == Metric::coordinates;
    loops_.set_lent_inertia(by_coordinates ? Wrench(Wrench::Zero()) : lent_);
    loops_.turn_flywheels(!by_coordinates);
    loops_.comply(metric == Metric::stiff);
    if (!loops_.set_hinged(inertias_)) return false;
    for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b) {
        const int body = order_.loop_bodies[b];
        if (loops_.is_hinged(b)) continue;
        if (takes_inertia(body, metric)) {
            Inertia<D> M = inertias_[body];
            if (lends_inertia(body, metric)) M.add_lent_inertia(lent_);
            if (!loops_.half(b).articulated(M)) return false;
        } else if (by_coordinates) {
            loops_.half(b).bare(1.0, pose[body].rotation, 2.0 * Matrix<S::turns, S::turns, double>::Identity());
        } else {
            loops_.half(b).bare(model_.bodies[body].mass, pose[body].rotation, model_.bodies[body].inverse_root);
        }
    }
    return true;
}

template <class D> std::optional<std::vector<int>> KktSolver<D>::rows_to_leave_out(const Pose<D>& pose) {
    ++close_looks_;
    return loops_.rows_to_leave_out(pose, model_.rows.redundant);
}

template <class D> double KktSolver<D>::of_flywheels() const { return loops_.of_flywheels() + leaves_.of_flywheels(); }

template <class D> double KktSolver<D>::contradiction(const double* violation) {
    return loops_.contradiction(violation);
}

template <class D> KktSolver<D>::~KktSolver() = default;

template class KktSolver<Plane<double>>;
template class KktSolver<Space<double>>;

}  // namespace mbproj
