// What is left when the leaves are gone: S = G W⁻¹ Gᵀ over the joints of the loops, with the articulated inertias of the
// loops' bodies as W, and its block-sparse Cholesky factor.
#pragma once

#include <memory>
#include <optional>

#include "algebra/decompositions.hpp"
#include "elimination/light_body.hpp"
#include "loops/hinged_bodies.hpp"
#include "loops/refinement.hpp"

namespace mbproj {

template <class D> class LoopSolver final {
public:
    static constexpr int F = Size<D>::freedoms;
    static constexpr bool has_qr = std::is_same_v<Scalar<D>, double>;  // that of Eigen is of doubles

    LoopSolver(const Model<D>& model, const EliminationOrder<D>& order, const Compliance<D>& compliance)
        : model_(model), order_(order), compliance_(compliance),
          rows_(std::make_unique<DelassusMatrix<D>>(model, order, compliance, LoopRows::reduced)),
          hinged_(model, *rows_), work_(order.loop_bodies.size()) {
        for (std::size_t b = 0; b < work_.size(); ++b)
            if (model.bodies[order.loop_bodies[b]].is_light) light_.emplace_back().body = static_cast<int>(b);
    }

    InverseRoot<D>& half(int b) { return rows_->halves[b]; }
    // The hinges by which bodies move, at a pose; the joint whose rows are dependent there, or -1.
    int set_hinges(const Pose<D>& pose) { return rows_->set_hinges(pose); }
    // See HingedBodies.
    bool set_hinged(std::vector<Inertia<D>>& inertias) { return hinged_.set_inertias(inertias, rows_->halves); }
    bool is_hinged(int b) const { return rows_->layout().hinge_of(b) >= 0; }
    // What light bodies are lent: nothing where their inertia is not theirs (GOPM's metric), nor that of flywheels.
    void lend(const Column<F, Scalar<D>>& lent) {
        for (Light<D>& light : light_) light.lent = lent;
    }
    void turn_flywheels(bool turn) { rows_->flywheels_turn = turn; }
    void comply(bool comply) { rows_->complies = comply; }

    // S + shift and its factor at a pose; returns the joint whose rows depend on the others, or -1.
    int factor(const Pose<D>& pose, double smallest, double shift = 0.0) {
        rows_->fill(pose, shift);
        by_qr_ = false;
        const int failed = rows_->cholesky.factor(smallest);
        return failed < 0 ? -1 : rows_->joint_of(failed);
    }

    // The factor of Y in place of that of S; false where it would be too large.
    bool factor_by_qr(const Pose<D>& pose) {
        if constexpr (has_qr) {
            if (rows_->count() > model_.thresholds.most_dense) return false;
            rows_->fill(pose);
            const std::size_t bodies = F * rows_->layout().pieces();
            Eigen::MatrixXd Y = Eigen::MatrixXd::Zero(bodies + rows_->flywheels().size(), rows_->count());
            rows_->each_column([&](int body, int row, const auto& y) {
                for (int i = 0; i < F; ++i) Y(F * body + i, row) = y[i];
            });
            rows_->each_flywheel([&](std::size_t f, int row, double y) { Y(bodies + f, row) = y; });
            qr_.factor(Y);
            by_qr_ = true;
        }
        return has_qr;
    }
    bool by_qr() const { return by_qr_; }
    // Holds all rows of the loops' joints from here on but these of the model, ascending.
    void leave_out(const std::vector<int>& rows) {
        if (!before_) before_ = std::make_unique<DelassusMatrix<D>>(model_, order_, compliance_, LoopRows::reduced);
        std::swap(rows_, before_);
        std::swap(left_out_, left_out_before_);
        if (left_out_ == rows) return;
        left_out_ = rows;
        rows_->leave_out(rows);
    }
    const std::vector<int>& left_out() const { return left_out_; }

    // Leaves out of the factors to come the rows that depend on the others at this pose, up to a distance of √smallest, or
    // none again. How many.
    int leave_out_dependent(const Pose<D>& pose, double smallest) {
        even().fill_evenly(pose);
        return rows_->leave_out_all_but(even_->independent_rows(smallest, even_->count()));
    }
    void leave_none_out() { rows_->cholesky.leave_out({}); }
    // The smallest pivot where all bodies weigh the same.
    Measure<D> even_pivot(const Pose<D>& pose) {
        even().fill_evenly(pose);
        return even_->cholesky.factor(0.0), even_->cholesky.smallest_pivot();
    }

    // As many rows as are `redundant` without which those of a pose are best-conditioned; nothing where more of them depend on
    // the others there.
    std::optional<std::vector<int>> rows_to_leave_out(const Pose<D>& pose, int redundant) {
        const Thresholds& from = model_.thresholds;
        BlockCholesky<Scalar<D>>& S = all().cholesky;
        all().fill_evenly(pose);
        S.keep();
        Scalar<D> left = std::numeric_limits<double>::infinity();
        for (double smallest = from.tied; smallest > from.no_digits; smallest *= 0.5) {
            if (smallest >= left) continue;  // it leaves out what the last one has
            S.restore();
            if (auto rows = all().dependent_rows(smallest, redundant); static_cast<int>(rows.size()) == redundant)
                return rows;
            if (!all().has_levels()) left = S.largest_left();
        }
        return std::nullopt;
    }
    // Those of all rows that depend on the others at a pose, up to a distance of √smallest.
    std::vector<int> dependent_rows(const Pose<D>& pose, double smallest) {
        all().fill_evenly(pose);
        return all().dependent_rows(smallest, all().count());
    }

    // δ of the loops' bodies from their forces f, with G δ = c; the multipliers stay for `multipliers`. False where the
    // motion of a light body does not settle: then it moves no mass. A shifted factor is applied as it is.
    template <class Forces, class Twists>
    bool solve(const Forces& f, const Scalar<D>* c, Twists& delta, bool shifted = false) {
        push(f, c);
        spin_.assign(rows_->flywheels().size(), 0.0);
        rhs_.assign(rows_->count(), 0.0);
        rows_->each_row([&](int own, int of_model) { rhs_[own] = -c[of_model]; });
        rows_->scale(rhs_.data());
        hinged_.add_particular(rhs_.data(), 1.0);
        const Scalar<D> driven = light_.empty() ? 0.0 : energy();
        lambda_.assign(rhs_.size(), 0.0);
        step_.resize(rhs_.size());
        improve();
        if (!shifted) refine();
        const bool settled = light_.empty() || settle(shifted, max(driven, energy()));
        release(delta);
        return settled;
    }

    // Σ I s'² of the flywheels in the last solve, where δ is a velocity.
    auto of_flywheels() const { return std::inner_product(spin_.begin(), spin_.end(), spin_.begin(), Scalar<D>()); }
    // λ of the loops' joints and of the hinges by which bodies move, of the last solve, at their rows; 0 in rows left out.
    void multipliers(Scalar<D>* lambda) {
        for (const int j : order_.loop_joints) {
            const Joint& joint = model_.joints[j];
            std::fill(lambda + joint.row, lambda + joint.row + joint.rows, 0.0);
        }
        rows_->each_row([&](int own, int of_model) { lambda[of_model] = lambda_[own]; });
        hinged_.multipliers(lambda_, lambda);
    }
    // How far rows that are left out at this pose alone are from what the others say of a violation, in rows' own scales.
    Scalar<D> contradiction(const Scalar<D>* violation) {
        std::vector<Scalar<D>> own(rows_->count());
        Scalar<D> least = std::numeric_limits<double>::infinity();
        rows_->each_row([&](int row, int of_model) {
            own[row] = violation[of_model];
            least = min(least, model_.row_scale[of_model]);
        });
        hinged_.move(violation);
        hinged_.add_particular(own.data(), -1.0);
        return cholesky().contradiction(own.data()) / least;
    }

    const BlockCholesky<Scalar<D>>& cholesky() const { return rows_->cholesky; }
    // What the pivots of the rows held usually are, or none: see BlockCholesky.
    void expect(const std::vector<Measure<D>>& usual) { rows_->cholesky.expect(usual); }

private:
    // The forces on the loops' bodies and pieces, with the half of each, less what their hinges take.
    template <class Forces> void push(const Forces& f, const Scalar<D>* c) {
        hinged_.move(c);
        work_.resize(rows_->layout().pieces());
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b) work_[b] = f[order_.loop_bodies[b]];
        for (std::size_t h = 0; h < rows_->hinges.size(); ++h) {
            const int b = child(h);
            hinged_.push(static_cast<int>(h), half(b), work_[b], parent(h));
            if (const Scalar<D> root = rows_->layout().root(b); root > 1.0) work_[b] /= root;
        }
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b)
            if (!is_hinged(static_cast<int>(b))) half(b).forward(work_[b]);
        for (std::size_t p = order_.loop_bodies.size(); p < work_.size(); ++p)
            work_[p] = work_[rows_->layout().body_of(p)];
    }
    // And their motions; that of a body in pieces is the mean of theirs, which differ by round-off.
    template <class Twists> void release(Twists& delta) {
        for (std::size_t p = order_.loop_bodies.size(); p < work_.size(); ++p)
            work_[rows_->layout().body_of(p)] += work_[p];
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b)
            if (!is_hinged(static_cast<int>(b))) half(b).backward(work_[b]);
        for (std::size_t h = 0; h < rows_->hinges.size(); ++h) {
            const int b = child(h);
            if (const Scalar<D> root = rows_->layout().root(b); root > 1.0) work_[b] /= root;
            hinged_.release(static_cast<int>(h), half(b), work_[b], parent(h));
        }
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b) delta[order_.loop_bodies[b]] = work_[b];
    }
    // Of a hinge, its child among the loops' bodies, and what `work_` has of its parent, or nothing of the ground.
    int child(std::size_t h) const { return rows_->layout().place(rows_->hinges[h].child()); }
    Column<F, Scalar<D>>* parent(std::size_t h) {
        const int body = rows_->hinges[h].parent();
        return body == model_.size() ? nullptr : &work_[rows_->layout().place(body)];
    }

    // All rows, to look for those that depend on others.
    DelassusMatrix<D>& all() {
        if (!all_) all_ = std::make_unique<DelassusMatrix<D>>(model_, order_, compliance_, LoopRows::all);
        return *all_;
    }
    // The rows that are held, where all bodies weigh the same; the factor at hand stays.
    DelassusMatrix<D>& even() {
        if (!even_) even_ = std::make_unique<DelassusMatrix<D>>(model_, order_, compliance_, LoopRows::hinges_first);
        even_->leave_out(left_out_);
        return *even_;
    }

    void refine() {
        const auto again = [this] { improve(); };
        const auto pivot = cholesky().smallest_pivot();  // S squares the condition
        const auto is_ill = pivot * pivot < model_.thresholds.half_digits;
        if constexpr (!is_full<D>)
            refine_lanes(is_ill, model_.thresholds, step_, lambda_, work_, again);
        else if (is_ill)
            mbproj::refine(model_.thresholds, step_, lambda_, again);
    }

    // λ += S⁻¹ (Yᵀ w - c), and w less Y times that, with -c in `rhs_`.
    void improve() {
        if constexpr (has_qr)
            if (by_qr_) return improve_by_qr();
        step_ = rhs_;
        rows_->add_products(work_, step_.data());
        rows_->each_flywheel([this](std::size_t f, int row, Scalar<D> y) { step_[row] += y * spin_[f]; });
        cholesky().solve(step_.data());
        rows_->subtract_products(step_.data(), work_);
        rows_->each_flywheel([this](std::size_t f, int row, Scalar<D> y) { spin_[f] -= step_[row] * y; });
        for (std::size_t r = 0; r < lambda_.size(); ++r) lambda_[r] += step_[r];
    }

    void improve_by_qr() {
        const std::size_t bodies = F * work_.size();
        Eigen::VectorXd w(bodies + spin_.size()), lambda;
        for (std::size_t b = 0; b < work_.size(); ++b) std::copy(work_[b].begin(), work_[b].end(), &w[F * b]);
        for (std::size_t f = 0; f < spin_.size(); ++f) w[bodies + f] = spin_[f];
        qr_.solve(w, -Eigen::Map<const Eigen::VectorXd>(rhs_.data(), rhs_.size()), lambda);
        for (std::size_t b = 0; b < work_.size(); ++b) work_[b] = matrix_at<F>(&w[F * b]);
        for (std::size_t f = 0; f < spin_.size(); ++f) spin_[f] = w[bodies + f];
        for (std::size_t r = 0; r < lambda_.size(); ++r) lambda_[r] += step_[r] = lambda[r];
    }

    // Takes back what light bodies were lent (see light_body.hpp): each pass moves them as the last one's change asks.
    // `least` is the energy below which nothing matters, of the forces or of the motion.
    bool settle(bool shifted, Scalar<D> least) {
        const double no_digits = model_.thresholds.no_digits, half_digits = model_.thresholds.half_digits;
        Scalar<D> before = std::numeric_limits<double>::infinity();
        for (Light<D>& light : light_) light.moved.setZero();
        for (int pass = 0; pass < model_.thresholds.most_passes; ++pass) {
            Scalar<D> change = 0.0, size = least;  // squares
            for (Light<D>& light : light_) {
                Column<F, Scalar<D>> now = work_[light.body];
                half(light.body).backward(now);
                light.change = now - light.moved;
                light.moved = now;
                change += light.change.dot(scaled(light.lent, light.change));
                size += now.dot(scaled(light.lent, now));
            }
            if (change <= no_digits * no_digits * size) return true;
            if (!(change < 0.5 * before)) return change <= half_digits * half_digits * size;
            before = change;
            // What is shifted keeps a residual, which must not be taken for an error: it begins anew, without forces.
            if (shifted) {
                for (Column<F, Scalar<D>>& w : work_) w.setZero();
                spin_.assign(spin_.size(), 0.0);
                lambda_.assign(lambda_.size(), 0.0);
            }
            for (const Light<D>& light : light_) {
                Column<F, Scalar<D>> back = scaled(light.lent, shifted ? light.moved : light.change);
                half(light.body).forward(back);
                work_[light.body] += back;
            }
            improve();
        }
        return false;
    }

    Scalar<D> energy() const {
        Scalar<D> sum = 0.0;
        for (const Column<F, Scalar<D>>& w : work_) sum += w.squaredNorm();
        return sum + of_flywheels();
    }

    const Model<D>& model_;
    const EliminationOrder<D>& order_;
    const Compliance<D>& compliance_;
    std::unique_ptr<DelassusMatrix<D>> rows_, before_;  // of those held, and before these: often the next
    std::unique_ptr<DelassusMatrix<D>> all_, even_;
    HingedBodies<D> hinged_;
    std::vector<int> left_out_, left_out_before_;
    std::vector<Light<D>> light_;
    std::vector<Column<F, Scalar<D>>> work_;
    std::vector<Scalar<D>> rhs_, step_, lambda_;
    std::vector<Scalar<D>> spin_;  // √I s' of the flywheels, as work_ of the bodies
    DenseQr qr_;
    bool by_qr_ = false;
};

}  // namespace mbproj
