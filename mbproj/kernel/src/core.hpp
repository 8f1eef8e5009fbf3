// What is left when the leaves are gone: S = G W⁻¹ Gᵀ over the joints of the loops, with the articulated inertias of the
// core's bodies as W, and its block-sparse Cholesky factor.
#pragma once

#include <numeric>

#include "block_cholesky.hpp"
#include "dense_qr.hpp"
#include "half_inverse.hpp"
#include "independent_rows.hpp"
#include "light_body.hpp"
#include "topology.hpp"

namespace mbproj {

// A pivot of S below this part of its diagonal entry asks for further solutions on the residual, so many at most, until
// they change λ by less than that part.
constexpr double ill_conditioned = 1e-4, refined_part = 1e-13;
constexpr int most_refining = 8;
// Of the largest entry of S: what makes a positive matrix of dependent rows, and is refined away.
constexpr double smallest_shift = 1e-9;

template <int D> class Core {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;
    using Rows = Matrix<F, F>;  // a joint's rows on one body, as columns Y = Zᵀ Gᵀ, of which as many count as it has rows

    Core(const Model<D>& model, const Topology<D>& topology) : model_(model), topology_(topology) {
        halves_.resize(topology.core_bodies.size());
        work_.resize(halves_.size());
        for (std::size_t b = 0; b < topology.core_bodies.size(); ++b)
            if (model.bodies[topology.core_bodies[b]].is_light) {
                light_.emplace_back();
                light_.back().body = static_cast<int>(b);
            }
        hold_all();
    }

    HalfInverse<D>& half(int b) { return halves_[b]; }
    // What light bodies are lent: nothing where their inertia is not theirs (GOPM's metric).
    void lend(const Column<F>& lent) {
        for (Light<D>& light : light_) light.lent = lent;
    }

    // S + shift and its factor at a pose; returns the joint whose rows depend on the others, or -1.
    int factor(const Pose<D>& pose, double smallest, double shift = 0.0) {
        fill(pose);
        if (shift > 0.0) cholesky_.shift(shift);
        by_qr_ = false;
        const int failed = cholesky_.factor(smallest);
        return failed < 0 ? -1 : held_[failed].joint;
    }

    // The factor of Y in place of that of S; false where it would be too large.
    bool factor_by_qr(const Pose<D>& pose) {
        if (rhs_.size() > most_dense_rows) return false;
        fill(pose);
        Eigen::MatrixXd Y = Eigen::MatrixXd::Zero(F * halves_.size(), rhs_.size());
        for (const Incidence& at : incidences_)
            for (int r = 0, row = cholesky_.row(at.held); r < held_[at.held].count; ++r)
                Y.template block<F, 1>(F * at.body, row + r) = at.Y.col(r);
        qr_.factor(Y);
        return by_qr_ = true;
    }

    // Leaves out of the factors to come the rows that depend on the others at this pose, up to a distance of √smallest, or
    // none again. How many; overwrites the factor.
    int leave_out(const Pose<D>& pose, double smallest) {
        fill_evenly(pose);
        const auto independent = cholesky_.independent_rows(smallest);
        std::vector<char> dependent(rhs_.size(), 1);
        for (std::size_t h = 0; h < held_.size(); ++h)
            for (const int r : independent[h]) dependent[cholesky_.row(static_cast<int>(h)) + r] = 0;
        const auto count = std::count(dependent.begin(), dependent.end(), 1);
        cholesky_.leave_out(count ? std::move(dependent) : std::vector<char>());
        return static_cast<int>(count);
    }
    void leave_none_out() { cholesky_.leave_out({}); }

    // All rows, with so much of the largest entry of S on its diagonal: then `solve_smallest` finds the smallest λ.
    void factor_smallest(const Pose<D>& pose) {
        hold_all();
        fill(pose);
        cholesky_.shift(smallest_shift * cholesky_.largest());
        by_qr_ = false;
        cholesky_.factor(0.0);
    }

    // Keeps only rows that are independent at a pose: those whose distance from the span of the rows before them exceeds
    // √smallest, where all bodies weigh the same and lengths count in the mechanism's own. How many are left out.
    int select(const Pose<D>& pose, double smallest) {
        hold_all();
        fill_evenly(pose);
        const auto independent = cholesky_.independent_rows(smallest);
        std::vector<Held> kept;
        int left_out = 0;
        for (std::size_t h = 0; h < held_.size(); ++h) {
            left_out += held_[h].count - static_cast<int>(independent[h].size());
            if (independent[h].empty()) continue;
            Held held{held_[h].joint, static_cast<int>(independent[h].size()), {}};
            std::copy(independent[h].begin(), independent[h].end(), held.rows);
            kept.push_back(held);
        }
        held_ = std::move(kept);
        arrange();
        return left_out;
    }

    // δ of the core's bodies from their forces f, with G δ = c; the multipliers stay for `multipliers`. False where the
    // motion of a light body does not settle: then it moves no mass. A shifted factor is applied as it is.
    template <class Forces, class Twists> bool solve(const Forces& f, const double* c, Twists& delta, bool shifted = false) {
        for (std::size_t b = 0; b < halves_.size(); ++b) {
            work_[b] = f[topology_.core_bodies[b]];
            halves_[b].forward(work_[b]);
        }
        for (std::size_t h = 0; h < held_.size(); ++h) {
            const Joint& joint = model_.joints[held_[h].joint];
            for (int r = 0; r < held_[h].count; ++r)
                rhs_[cholesky_.row(static_cast<int>(h)) + r] = -c[joint.row + held_[h].rows[r]];
        }
        lambda_.assign(rhs_.size(), 0.0);
        step_.resize(rhs_.size());
        improve();
        if (cholesky_.smallest_pivot() < ill_conditioned && !shifted) refine();
        const bool settled = light_.empty() || settle(shifted);
        for (std::size_t b = 0; b < halves_.size(); ++b) {
            halves_[b].backward(work_[b]);
            delta[topology_.core_bodies[b]] = work_[b];
        }
        return settled;
    }

    // λ of the core's joints, of the last solve, at their rows; 0 in rows that are left out.
    void multipliers(double* lambda) const {
        for (const int j : topology_.core_joints) {
            const Joint& joint = model_.joints[j];
            std::fill(lambda + joint.row, lambda + joint.row + joint.rows, 0.0);
        }
        for (std::size_t h = 0; h < held_.size(); ++h) {
            const Joint& joint = model_.joints[held_[h].joint];
            for (int r = 0; r < held_[h].count; ++r)
                lambda[joint.row + held_[h].rows[r]] = lambda_[cholesky_.row(static_cast<int>(h)) + r];
        }
    }

    const BlockCholesky& cholesky() const { return cholesky_; }

private:
    // A joint, and which of its rows count.
    struct Held {
        int joint, count;
        int rows[F];
    };
    struct Incidence {
        int held, body;  // of the core
        Rows Y;
    };
    struct Product {  // incidences a and b share a body: YᵀY goes to this block of S
        int a, b;
        std::size_t offset;
    };

    void hold_all() {
        held_.clear();
        for (const int j : topology_.core_joints) {
            Held held{j, model_.joints[j].rows, {}};
            std::iota(held.rows, held.rows + held.count, 0);
            held_.push_back(held);
        }
        arrange();
    }

    // The structure of S for the rows that are held.
    void arrange() {
        std::vector<int> place(model_.size(), -1), sizes;
        for (std::size_t b = 0; b < topology_.core_bodies.size(); ++b) place[topology_.core_bodies[b]] = static_cast<int>(b);
        std::vector<std::vector<int>> touching(topology_.core_bodies.size());
        incidences_.clear();
        products_.clear();
        for (std::size_t h = 0; h < held_.size(); ++h) {
            sizes.push_back(held_[h].count);
            for (const int body : model_.joints[held_[h].joint].bodies) {
                touching[place[body]].push_back(static_cast<int>(incidences_.size()));
                incidences_.push_back({static_cast<int>(h), place[body], Rows::Zero()});
            }
        }
        std::vector<std::pair<int, int>> couplings;
        for (const auto& joints : touching)
            for (const int a : joints)
                for (const int b : joints) couplings.push_back({incidences_[a].held, incidences_[b].held});
        rhs_.resize(std::accumulate(sizes.begin(), sizes.end(), 0));
        cholesky_ = BlockCholesky(std::move(sizes), couplings);
        for (const auto& joints : touching)
            for (std::size_t a = 0; a < joints.size(); ++a)
                for (std::size_t b = 0; b <= a; ++b) add_product(joints[a], joints[b]);
    }

    void add_product(int a, int b) {
        const auto target = cholesky_.target(incidences_[a].held, incidences_[b].held);
        products_.push_back(target.transposed ? Product{b, a, target.offset} : Product{a, b, target.offset});
    }

    // Y and S at a pose.
    void fill(const Pose<D>& pose) {
        Matrix<F, F> G;
        for (Incidence& at : incidences_) {
            const Held& held = held_[at.held];
            jacobian<D>(model_, pose, model_.joints[held.joint], topology_.core_bodies[at.body], G);
            for (int r = 0; r < held.count; ++r) {
                Column<F> y = G.row(held.rows[r]).transpose();
                halves_[at.body].forward(y);
                at.Y.col(r) = y;
            }
        }
        cholesky_.clear();
        for (const Product& product : products_) {
            const Incidence &a = incidences_[product.a], &b = incidences_[product.b];
            const int rows = held_[a.held].count, columns = held_[b.held].count;
            double* target = cholesky_.at(product.offset);
            const bool diagonal = product.a == product.b;  // of which the lower half counts
            for (int r = 0; r < rows; ++r)
                for (int c = 0; c < (diagonal ? r + 1 : columns); ++c)
                    target[r * columns + c] += a.Y.col(r).dot(b.Y.col(c));
        }
    }

    // The same with bodies that all weigh the same, lengths in the mechanism's own.
    void fill_evenly(const Pose<D>& pose) {
        for (std::size_t b = 0; b < halves_.size(); ++b)
            halves_[b].bare(1.0 / (model_.length * model_.length), pose[topology_.core_bodies[b]].rotation,
                            Matrix<S::turns, S::turns>::Identity());
        fill(pose);
    }

    // S squares the condition of Y. Where a pivot shows that to matter, further solutions on what is left, which is computed
    // from Y itself, give the digits back (Björck 1996, sect. 6.6.5: corrected seminormal equations).
    void refine() {
        double before = std::numeric_limits<double>::infinity();
        for (int pass = 0; pass < most_refining; ++pass) {
            improve();
            double change = 0.0, size = 0.0;
            for (std::size_t r = 0; r < lambda_.size(); ++r) {
                change = std::max(change, std::abs(step_[r]));
                size = std::max(size, std::abs(lambda_[r]));
            }
            if (!(change > refined_part * size && change < 0.5 * before)) return;
            before = change;
        }
    }

    // λ += S⁻¹ (Yᵀ w - c), and w less Y times that, with -c in `rhs_`.
    void improve() {
        if (by_qr_) return improve_by_qr();
        step_ = rhs_;
        for (const Incidence& at : incidences_)
            for (int r = 0, row = cholesky_.row(at.held); r < held_[at.held].count; ++r)
                step_[row + r] += at.Y.col(r).dot(work_[at.body]);
        cholesky_.solve(step_.data());
        for (const Incidence& at : incidences_)
            for (int r = 0, row = cholesky_.row(at.held); r < held_[at.held].count; ++r)
                work_[at.body] -= step_[row + r] * at.Y.col(r);
        for (std::size_t r = 0; r < lambda_.size(); ++r) lambda_[r] += step_[r];
    }

    void improve_by_qr() {
        Eigen::VectorXd w(F * work_.size()), lambda;
        for (std::size_t b = 0; b < work_.size(); ++b) w.template segment<F>(F * b) = work_[b];
        qr_.solve(w, -Eigen::Map<const Eigen::VectorXd>(rhs_.data(), rhs_.size()), lambda);
        for (std::size_t b = 0; b < work_.size(); ++b) work_[b] = w.template segment<F>(F * b);
        for (std::size_t r = 0; r < lambda_.size(); ++r) lambda_[r] += step_[r] = lambda[r];
    }

    // Takes back what light bodies were lent (see light_body.hpp): each pass moves them as the last one's change asks.
    bool settle(bool shifted) {
        double before = std::numeric_limits<double>::infinity();
        for (Light<D>& light : light_) light.moved.setZero();
        for (int pass = 0; pass < most_settling; ++pass) {
            double change = 0.0, size = 0.0;  // squares
            for (Light<D>& light : light_) {
                Column<F> now = work_[light.body];
                halves_[light.body].backward(now);
                light.change = now - light.moved;
                light.moved = now;
                change += light.change.dot(light.lent.cwiseProduct(light.change));
                size += now.dot(light.lent.cwiseProduct(now));
            }
            if (change <= settled_part * size) return true;
            if (!(change < 0.5 * before)) return change <= settled_enough * size || change <= settled_at_rest * motion();
            before = change;
            // What is shifted keeps a residual, which must not be taken for an error: it begins anew, without forces.
            if (shifted) {
                for (Column<F>& w : work_) w.setZero();
                lambda_.assign(lambda_.size(), 0.0);
            }
            for (const Light<D>& light : light_) {
                Column<F> back = light.lent.cwiseProduct(shifted ? light.moved : light.change);
                halves_[light.body].forward(back);
                work_[light.body] += back;
            }
            improve();
        }
        return false;
    }

    // The motion of all bodies in the metric of what is lent, squared.
    double motion() const {
        double sum = 0.0;
        for (std::size_t b = 0; b < halves_.size(); ++b) {
            Column<F> now = work_[b];
            halves_[b].backward(now);
            sum += now.dot(light_.front().lent.cwiseProduct(now));
        }
        return sum;
    }

    const Model<D>& model_;
    const Topology<D>& topology_;
    std::vector<Held> held_;
    std::vector<Incidence> incidences_;
    std::vector<Product> products_;
    std::vector<HalfInverse<D>> halves_;
    std::vector<Light<D>> light_;
    std::vector<Column<F>> work_;
    std::vector<double> rhs_, step_, lambda_;
    BlockCholesky cholesky_;
    DenseQr qr_;
    bool by_qr_ = false;
};

}  // namespace mbproj
