// What is left when the leaves are gone: S = G W⁻¹ Gᵀ over the joints of the loops, with the articulated inertias of the
// core's bodies as W, and its block-sparse Cholesky factor.
#pragma once

#include <numeric>

#include <Eigen/Cholesky>

#include "articulated.hpp"
#include "block_cholesky.hpp"
#include "topology.hpp"

namespace mbproj {

// W⁻¹ = Z Zᵀ of a core body: of a bare one from the constant root of its inertia, of an articulated one by factorisation.
template <int D> class HalfInverse {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;

    void bare(double mass, const Rotation<D>& A, const Matrix<S::turns, S::turns>& inverse_root) {
        is_bare_ = true;
        translation_ = 1.0 / std::sqrt(mass);
        if constexpr (D == 3) rotation_.noalias() = inverse_root * A.transpose();
        else rotation_ = inverse_root;
    }
    bool articulated(const Inertia<D>& M) {
        is_bare_ = false;
        Matrix<F, F> full;
        full.template topLeftCorner<D, D>() = M.A;
        full.template topRightCorner<D, S::turns>() = M.B;
        full.template bottomLeftCorner<S::turns, D>() = M.B.transpose();
        full.template bottomRightCorner<S::turns, S::turns>() = M.C;
        factor_.compute(full);
        return factor_.info() == Eigen::Success;
    }
    // Zᵀ x.
    void forward(Column<F>& x) const {
        if (is_bare_) {
            x.template head<D>() *= translation_;
            x.template tail<S::turns>() = rotation_ * x.template tail<S::turns>().eval();
        } else {
            factor_.matrixL().solveInPlace(x);
        }
    }
    // Z x.
    void backward(Column<F>& x) const {
        if (is_bare_) {
            x.template head<D>() *= translation_;
            x.template tail<S::turns>() = rotation_.transpose() * x.template tail<S::turns>().eval();
        } else {
            factor_.matrixU().solveInPlace(x);
        }
    }

private:
    bool is_bare_ = true;
    double translation_ = 0.0;
    Matrix<S::turns, S::turns> rotation_;
    Eigen::LLT<Matrix<F, F>> factor_;
};

// A pivot of S below this part of its diagonal entry asks for a second solution on the residual.
constexpr double ill_conditioned = 1e-4;

template <int D> class Core {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;
    using Rows = Matrix<F, F>;  // a joint's rows on one body, as columns Y = Zᵀ Gᵀ, of which as many count as it has rows

    Core(const Model<D>& model, const Topology<D>& topology) : model_(model), topology_(topology) {
        std::vector<int> place(model.size(), -1), sizes;
        for (std::size_t b = 0; b < topology.core_bodies.size(); ++b) place[topology.core_bodies[b]] = static_cast<int>(b);
        std::vector<std::vector<int>> touching(topology.core_bodies.size());
        for (std::size_t j = 0; j < topology.core_joints.size(); ++j) {
            const Joint& joint = model.joints[topology.core_joints[j]];
            sizes.push_back(joint.rows);
            for (const int body : joint.bodies) {
                touching[place[body]].push_back(static_cast<int>(incidences_.size()));
                incidences_.push_back({static_cast<int>(j), place[body], Rows::Zero()});
            }
        }
        std::vector<std::pair<int, int>> couplings;
        for (const auto& joints : touching)
            for (const int a : joints)
                for (const int b : joints) couplings.push_back({incidences_[a].joint, incidences_[b].joint});
        cholesky_ = BlockCholesky(sizes, couplings);
        for (const auto& joints : touching)
            for (std::size_t a = 0; a < joints.size(); ++a)
                for (std::size_t b = 0; b <= a; ++b) add_product(joints[a], joints[b]);
        halves_.resize(topology.core_bodies.size());
        work_.resize(halves_.size());
        rhs_.resize(std::accumulate(sizes.begin(), sizes.end(), 0));
    }

    HalfInverse<D>& half(int b) { return halves_[b]; }

    // S and its factor at a pose; returns the joint whose rows depend on the others, or -1.
    int factor(const Pose<D>& pose, double smallest) {
        Matrix<F, F> G;
        for (Incidence& at : incidences_) {
            const Joint& joint = model_.joints[topology_.core_joints[at.joint]];
            jacobian<D>(model_, pose, joint, topology_.core_bodies[at.body], G);
            for (int r = 0; r < joint.rows; ++r) {
                Column<F> y = G.row(r).transpose();
                halves_[at.body].forward(y);
                at.Y.col(r) = y;
            }
        }
        cholesky_.clear();
        for (const Product& product : products_) {
            const Incidence &a = incidences_[product.a], &b = incidences_[product.b];
            const int rows = size(a.joint), columns = size(b.joint);
            double* target = cholesky_.at(product.offset);
            const bool diagonal = product.a == product.b;  // of which the lower half counts
            for (int r = 0; r < rows; ++r)
                for (int c = 0; c < (diagonal ? r + 1 : columns); ++c)
                    target[r * columns + c] += a.Y.col(r).dot(b.Y.col(c));
        }
        const int failed = cholesky_.factor(smallest);
        return failed < 0 ? -1 : topology_.core_joints[failed];
    }

    // δ of the core's bodies from their forces f, with G δ = c; the multipliers stay for `multipliers`.
    template <class Forces, class Twists> void solve(const Forces& f, const double* c, Twists& delta) {
        for (std::size_t b = 0; b < halves_.size(); ++b) {
            work_[b] = f[topology_.core_bodies[b]];
            halves_[b].forward(work_[b]);
        }
        for (std::size_t j = 0; j < topology_.core_joints.size(); ++j) {
            const Joint& joint = model_.joints[topology_.core_joints[j]];
            for (int r = 0; r < joint.rows; ++r) rhs_[cholesky_.row(static_cast<int>(j)) + r] = -c[joint.row + r];
        }
        lambda_.assign(rhs_.size(), 0.0);
        improve();
        // S squares the condition of Y. Where a pivot shows that to matter, a second time on what is left, which is
        // computed from Y itself, gives the digits back (Björck 1996, sect. 6.6.5: corrected seminormal equations).
        if (cholesky_.smallest_pivot() < ill_conditioned) improve();
        for (std::size_t b = 0; b < halves_.size(); ++b) {
            halves_[b].backward(work_[b]);
            delta[topology_.core_bodies[b]] = work_[b];
        }
    }

    // λ of the core's joints, of the last solve, at their rows.
    void multipliers(double* lambda) const {
        for (std::size_t j = 0; j < topology_.core_joints.size(); ++j) {
            const Joint& joint = model_.joints[topology_.core_joints[j]];
            for (int r = 0; r < joint.rows; ++r) lambda[joint.row + r] = lambda_[cholesky_.row(static_cast<int>(j)) + r];
        }
    }

    const BlockCholesky& cholesky() const { return cholesky_; }

private:
    struct Incidence {
        int joint, body;  // of the core
        Rows Y;
    };
    struct Product {  // incidences a and b share a body: YᵀY goes to this block of S
        int a, b;
        std::size_t offset;
    };

    // λ += S⁻¹ (Yᵀ w - c), and w less Y times that, with -c in `rhs_`.
    void improve() {
        step_ = rhs_;
        for (const Incidence& at : incidences_)
            for (int r = 0, row = cholesky_.row(at.joint); r < size(at.joint); ++r)
                step_[row + r] += at.Y.col(r).dot(work_[at.body]);
        cholesky_.solve(step_.data());
        for (const Incidence& at : incidences_)
            for (int r = 0, row = cholesky_.row(at.joint); r < size(at.joint); ++r)
                work_[at.body] -= step_[row + r] * at.Y.col(r);
        for (std::size_t r = 0; r < lambda_.size(); ++r) lambda_[r] += step_[r];
    }

    int size(int joint) const { return model_.joints[topology_.core_joints[joint]].rows; }
    void add_product(int a, int b) {
        const auto target = cholesky_.target(incidences_[a].joint, incidences_[b].joint);
        products_.push_back(target.transposed ? Product{b, a, target.offset} : Product{a, b, target.offset});
    }

    const Model<D>& model_;
    const Topology<D>& topology_;
    std::vector<Incidence> incidences_;
    std::vector<Product> products_;
    std::vector<HalfInverse<D>> halves_;
    std::vector<Column<F>> work_;
    std::vector<double> rhs_, step_, lambda_;
    BlockCholesky cholesky_;
};

}  // namespace mbproj
