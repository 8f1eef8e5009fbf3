// The loops, which remain after the leaves are eliminated: S = G W⁻¹ Gᵀ over their joints, with articulated inertias W, and its
// block-sparse Cholesky factor.
#pragma once

#include <memory>
#include <optional>

#include "model/decompositions.hpp"
#include "solver/hinged_bodies.hpp"
#include "solver/light_body.hpp"
#include "solver/refinement.hpp"

namespace mbproj {

template <class D> class LoopSolver final {
public:
    static constexpr int F = Size<D>::freedoms;

    LoopSolver(const Model<D>& model, const EliminationOrder<D>& order, const Compliance<D>& compliance)
        : model_(model), order_(order), compliance_(compliance),
          rows_(std::make_unique<DelassusMatrix<D>>(model, order, compliance, LoopRows::reduced)),
          hinged_(model, *rows_), work_(order.loop_bodies.size()) {
        for (std::size_t b = 0; b < work_.size(); ++b)
            if (model.bodies[order.loop_bodies[b]].is_light) light_.emplace_back().body = static_cast<int>(b);
    }

    InverseRoot<D>& half(int b) { return rows_->halves[b]; }
    // Sets the hinges by which bodies move, at a pose; returns the joint whose rows are dependent there, or -1.
    int set_hinges(const Pose<D>& pose) { return rows_->set_hinges(pose); }
    // See HingedBodies.
    bool set_hinged(std::vector<Inertia<D>>& inertias) { return hinged_.set_inertias(inertias, rows_->halves); }
    bool is_hinged(int b) const { return rows_->layout().hinge_of(b) >= 0; }
    // Sets the inertia lent to light bodies: 0 in a metric without the bodies' inertia (GOPM's), and 0 for flywheels.
    void set_lent_inertia(const Column<F>& lent) {
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

    // Factors Y in place of S; false where that would be too large.
    bool factor_by_qr(const Pose<D>& pose) {
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
        return true;
    }
    bool by_qr() const { return by_qr_; }
    // Leaves out these rows of the model, ascending, from now on, and holds all other rows of the loops' joints.
    void leave_out(const std::vector<int>& rows) {
        if (!before_) before_ = std::make_unique<DelassusMatrix<D>>(model_, order_, compliance_, LoopRows::reduced);
        std::swap(rows_, before_);
        std::swap(left_out_, left_out_before_);
        if (left_out_ == rows) return;
        left_out_ = rows;
        rows_->leave_out(rows);
    }
    const std::vector<int>& left_out() const { return left_out_; }

    // Leaves the rows that depend on the others at this pose, up to a distance of √smallest, out of the next factors.
    // Returns their number.
    int leave_out_dependent(const Pose<D>& pose, double smallest) {
        even().fill_evenly(pose);
        return rows_->leave_out_all_but(even_->independent_rows(smallest, even_->count()));
    }
    void leave_none_out() { rows_->cholesky.leave_out({}); }
    // The smallest pivot where all bodies have the same mass.
    double even_pivot(const Pose<D>& pose) {
        even().fill_evenly(pose);
        return even_->cholesky.factor(0.0), even_->cholesky.smallest_pivot();
    }

    // Exactly `redundant` rows without which the rows of a pose are best-conditioned; nothing where more rows are dependent
    // there.
    std::optional<std::vector<int>> rows_to_leave_out(const Pose<D>& pose, int redundant) {
        const Thresholds& from = model_.thresholds;
        BlockCholesky& S = all().cholesky;
        all().fill_evenly(pose);
        S.keep();
        double left = std::numeric_limits<double>::infinity();
        for (double smallest = from.choice_from; smallest > from.no_digits; smallest *= 0.5) {
            if (smallest >= left) continue;  // the same rows as in the pass before
            S.restore();
            if (auto rows = all().dependent_rows(smallest, redundant); static_cast<int>(rows.size()) == redundant)
                return rows;
            if (!all().has_levels()) left = S.largest_left();
        }
        return std::nullopt;
    }
    // The rows that depend on the others at a pose, up to a distance of √smallest.
    std::vector<int> dependent_rows(const Pose<D>& pose, double smallest) {
        all().fill_evenly(pose);
        return all().dependent_rows(smallest, all().count());
    }

    // δ of the loops' bodies from their forces f, with G δ = c; the multipliers are kept for `multipliers`. False where the
    // motion of a light body does not converge: then it has no inertia. A shifted factor is applied without refinement.
    template <class Forces, class Twists>
    bool solve(const Forces& f, const double* c, Twists& delta, bool shifted = false) {
        push(f, c);
        spin_.assign(rows_->flywheels().size(), 0.0);
        rhs_.assign(rows_->count(), 0.0);
        rows_->each_row([&](int own, int of_model) { rhs_[own] = -c[of_model]; });
        rows_->scale(rhs_.data());
        hinged_.add_particular(rhs_.data(), 1.0);
        const double driven = light_.empty() ? 0.0 : energy();
        lambda_.assign(rhs_.size(), 0.0);
        step_.resize(rhs_.size());
        improve();
        if (!shifted) refine();
        const bool settled = light_.empty() || settle(shifted, max(driven, energy()));
        release(delta);
        return settled;
    }

    // Σ I s'² of the flywheels in the last solve, where δ is a velocity.
    auto of_flywheels() const { return std::inner_product(spin_.begin(), spin_.end(), spin_.begin(), 0.0); }
    // λ of the loops' joints and of the hinges by which bodies move, of the last solve, at their rows; 0 in rows left out.
    void multipliers(double* lambda) {
        for (const int j : order_.loop_joints) {
            const Joint& joint = model_.joints[j];
            std::fill(lambda + joint.row, lambda + joint.row + joint.rows, 0.0);
        }
        rows_->each_row([&](int own, int of_model) { lambda[of_model] = lambda_[own]; });
        hinged_.multipliers(lambda_, lambda);
    }
    // The largest distance, in rows left out at this pose, of a violation from the value that the other rows imply.
    double contradiction(const double* violation) {
        std::vector<double> own(rows_->count());
        double least = std::numeric_limits<double>::infinity();
        rows_->each_row([&](int row, int of_model) {
            own[row] = violation[of_model];
            least = min(least, model_.row_scale[of_model]);
        });
        hinged_.move(violation);
        hinged_.add_particular(own.data(), -1.0);
        return cholesky().contradiction(own.data()) / least;
    }

    const BlockCholesky& cholesky() const { return rows_->cholesky; }
    // The usual pivots of the rows held, or none: see BlockCholesky.
    void expect(const std::vector<double>& usual) { rows_->cholesky.expect(usual); }

private:
    // Zᵀ f of the loops' bodies and pieces, without the parts that their hinges take.
    template <class Forces> void push(const Forces& f, const double* c) {
        hinged_.move(c);
        work_.resize(rows_->layout().pieces());
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b) work_[b] = f[order_.loop_bodies[b]];
        for (std::size_t h = 0; h < rows_->hinges.size(); ++h) {
            const int b = child(h);
            hinged_.push(static_cast<int>(h), half(b), work_[b], parent(h));
            if (const double root = rows_->layout().root(b); root > 1.0) work_[b] /= root;
        }
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b)
            if (!is_hinged(static_cast<int>(b))) half(b).forward(work_[b]);
        for (std::size_t p = order_.loop_bodies.size(); p < work_.size(); ++p)
            work_[p] = work_[rows_->layout().body_of(p)];
    }
    // The motions of the bodies; that of a divided body is the mean of its pieces' motions, which differ by round-off.
    template <class Twists> void release(Twists& delta) {
        for (std::size_t p = order_.loop_bodies.size(); p < work_.size(); ++p)
            work_[rows_->layout().body_of(p)] += work_[p];
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b)
            if (!is_hinged(static_cast<int>(b))) half(b).backward(work_[b]);
        for (std::size_t h = 0; h < rows_->hinges.size(); ++h) {
            const int b = child(h);
            if (const double root = rows_->layout().root(b); root > 1.0) work_[b] /= root;
            hinged_.release(static_cast<int>(h), half(b), work_[b], parent(h));
        }
        for (std::size_t b = 0; b < order_.loop_bodies.size(); ++b) delta[order_.loop_bodies[b]] = work_[b];
    }
    // The child of a hinge among the loops' bodies, and its parent's entry of `work_`, or nothing for the ground.
    int child(std::size_t h) const { return rows_->layout().place(rows_->hinges[h].child()); }
    Column<F>* parent(std::size_t h) {
        const int body = rows_->hinges[h].parent();
        return body == model_.size() ? nullptr : &work_[rows_->layout().place(body)];
    }

    // All rows, for the search for dependent ones.
    DelassusMatrix<D>& all() {
        if (!all_) all_ = std::make_unique<DelassusMatrix<D>>(model_, order_, compliance_, LoopRows::all);
        return *all_;
    }
    // The rows that are held, with the same mass for all bodies; the current factor does not change.
    DelassusMatrix<D>& even() {
        if (!even_) even_ = std::make_unique<DelassusMatrix<D>>(model_, order_, compliance_, LoopRows::hinges_first);
        even_->leave_out(left_out_);
        return *even_;
    }

    void refine() {
        const auto again = [this] { improve(); };
        const auto pivot = cholesky().smallest_pivot();  // S has the square of Y's condition number
        const auto is_ill = pivot * pivot < model_.thresholds.half_digits;
        if (is_ill) mbproj::refine(model_.thresholds, step_, lambda_, again);
    }

    // λ += S⁻¹ (Yᵀ w - c), and subtracts Y times the change from w; `rhs_` holds -c.
    void improve() {
        if (by_qr_) return improve_by_qr();
        step_ = rhs_;
        rows_->add_products(work_, step_.data());
        rows_->each_flywheel([this](std::size_t f, int row, double y) { step_[row] += y * spin_[f]; });
        cholesky().solve(step_.data());
        rows_->subtract_products(step_.data(), work_);
        rows_->each_flywheel([this](std::size_t f, int row, double y) { spin_[f] -= step_[row] * y; });
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

    // Takes back the inertia lent to light bodies (light_body.hpp): each pass moves them by the force of the last
    // change. `least`, the energy of the forces or of the motion, adds to theirs as the measure of a change.
    bool settle(bool shifted, double least) {
        const double no_digits = model_.thresholds.no_digits, half_digits = model_.thresholds.half_digits;
        double before = std::numeric_limits<double>::infinity();
        for (Light<D>& light : light_) light.moved.setZero();
        for (int pass = 0; pass < model_.thresholds.most_passes; ++pass) {
            double change = 0.0, size = least;  // squares
            for (Light<D>& light : light_) {
                Column<F> now = work_[light.body];
                half(light.body).backward(now);
                light.change = now - light.moved;
                light.moved = now;
                change += light.change.dot(scaled(light.lent, light.change));
                size += now.dot(scaled(light.lent, now));
            }
            if (change <= no_digits * no_digits * size) return true;
            if (!(change < 0.5 * before)) return change <= half_digits * half_digits * size;
            before = change;
            // A shifted factor leaves a residual that is no error: the solution starts again, without forces.
            if (shifted) {
                for (Column<F>& w : work_) w.setZero();
                spin_.assign(spin_.size(), 0.0);
                lambda_.assign(lambda_.size(), 0.0);
            }
            for (const Light<D>& light : light_) {
                Column<F> back = scaled(light.lent, shifted ? light.moved : light.change);
                half(light.body).forward(back);
                work_[light.body] += back;
            }
            improve();
        }
        return false;
    }

    double energy() const {
        double sum = 0.0;
        for (const Column<F>& w : work_) sum += w.squaredNorm();
        return sum + of_flywheels();
    }

    const Model<D>& model_;
    const EliminationOrder<D>& order_;
    const Compliance<D>& compliance_;
    std::unique_ptr<DelassusMatrix<D>> rows_,
        before_;  // of the rows held, and of those held before, which often return
    std::unique_ptr<DelassusMatrix<D>> all_, even_;
    HingedBodies<D> hinged_;
    std::vector<int> left_out_, left_out_before_;
    std::vector<Light<D>> light_;
    std::vector<Column<F>> work_;
    std::vector<double> rhs_, step_, lambda_;
    std::vector<double> spin_;  // √I s' of the flywheels, as work_ of the bodies
    PivotedQr qr_;
    bool by_qr_ = false;
};

}  // namespace mbproj
