// Where rows of G are dependent, many λ balance the same forces, Gᵀλ. The smallest is the part of any of them in the range of G:
// λ = G x with GᵀG x = Gᵀλ. The rows of the loops' joints are scaled by their lengths, so that torques and forces compare. GᵀG
// couples bodies as joints do: it is sparse, and its factor costs as much as that of S.
#pragma once

#include <limits>

#include "kinematics/constraint_rows.hpp"
#include "solver/block_cholesky.hpp"
#include "solver/elimination_order.hpp"

namespace mbproj {

template <class D> class MinimumNormMultipliers final {
public:
    static constexpr int F = Size<D>::freedoms;

    MinimumNormMultipliers(const Model<D>& model, const EliminationOrder<D>& order) : model_(model), order_(order) {
        std::vector<int> place(model.size(), -1);
        for (std::size_t b = 0; b < order.loop_bodies.size(); ++b) place[order.loop_bodies[b]] = static_cast<int>(b);
        std::vector<std::pair<int, int>> couplings, of_incidences;
        for (const int joint : order.loop_joints) {
            // A flywheel's row balances only its torque; a compliant row is not a row of C.
            if (model.holds_flywheel(joint) || model.is_compliant(joint)) continue;
            const int first = static_cast<int>(incidences_.size());
            for (const int body : model.joints[joint].bodies) incidences_.push_back({joint, place[body], {}});
            for (int a = first; a < static_cast<int>(incidences_.size()); ++a)
                for (int b = first; b <= a; ++b) {
                    couplings.push_back({incidences_[a].body, incidences_[b].body});
                    of_incidences.push_back({a, b});
                }
        }
        cholesky_ = BlockCholesky(std::vector<int>(order.loop_bodies.size(), F), couplings, 0);
        for (const auto& [a, b] : of_incidences) {
            const auto target = cholesky_.target(incidences_[a].body, incidences_[b].body);
            products_.push_back(target.transposed ? Product{b, a, target.offset} : Product{a, b, target.offset});
        }
    }

    // Replaces λ, at the model's rows, by the smallest that balances the same forces. GᵀG is singular along the free motions,
    // which change no λ; it is factored with `shift` on its diagonal. Each pass then leaves the part shift / (σ² + shift) along a
    // singular vector of G: next to nothing, unless rows are almost dependent. Where round-off exceeds the shift there is no
    // factor, and the shift grows. False where that does not help.
    bool spread(const Pose<D>& pose, double shift, double* lambda) {
        for (Incidence& at : incidences_) set_gradients(pose, at);
        for (fill(shift); cholesky_.factor(0.0) >= 0; fill(shift))
            if (!((shift *= 10.0) < 1.0)) return false;
        left_.assign(model_.constraints.rows, 0.0);
        for (const Incidence& at : incidences_)
            for (int r = row(at), end = r + model_.joints[at.joint].rows; r < end; ++r)
                left_[r] = lambda[r] * model_.row_scale[r];
        smallest_.assign(left_.size(), 0.0);
        double before = std::numeric_limits<double>::infinity();
        for (int pass = 0; pass < model_.thresholds.most_passes; ++pass) {
            const double change = move();
            if (!(change > model_.thresholds.no_digits * size() && change < 0.5 * before)) break;
            before = change;
        }
        for (const Incidence& at : incidences_)
            for (int r = row(at), end = r + model_.joints[at.joint].rows; r < end; ++r)
                lambda[r] = smallest_[r] / model_.row_scale[r];
        return true;
    }

private:
    // A joint and one of its bodies, by its number in the loops: a column for each row of the joint.
    struct Incidence {
        int joint, body;
        Matrix<F, F> G;
    };
    struct Product {  // G_a G_bᵀ goes to this block
        int a, b;
        std::size_t offset;
    };

    int row(const Incidence& at) const { return model_.joints[at.joint].row; }

    void set_gradients(const Pose<D>& pose, Incidence& at) const {
        const Joint& joint = model_.joints[at.joint];
        jacobian<D>(model_, pose, joint, order_.loop_bodies[at.body], at.G.transpose());
        for (int r = 0; r < joint.rows; ++r) {
            const double scale = 1.0 / model_.row_scale[joint.row + r];
            for (int k = 0; k < F; ++k) at.G(k, r) *= k < D::axes ? scale * model_.length : scale;
        }
    }

    void fill(double shift) {
        cholesky_.clear();
        for (const Product& product : products_) {
            const Incidence &a = incidences_[product.a], &b = incidences_[product.b];
            double* target = cholesky_.at(product.offset);
            for (int i = 0; i < F; ++i)
                for (int j = 0; j < F; ++j)
                    for (int r = 0; r < model_.joints[a.joint].rows; ++r) target[F * i + j] += a.G(i, r) * b.G(j, r);
        }
        for (int b = 0; b < static_cast<int>(order_.loop_bodies.size()); ++b)
            for (int k = 0; k < F; ++k) {
                double& square = cholesky_.at(cholesky_.target(b, b).offset)[k * (F + 1)];
                square += shift * (1.0 + square);
            }
    }

    // Moves the part of the remainder that lies in the range of G to the smallest λ; returns the largest change.
    double move() {
        x_.assign(F * order_.loop_bodies.size(), 0.0);
        for (const Incidence& at : incidences_)
            for (int r = 0; r < model_.joints[at.joint].rows; ++r)
                for (int k = 0; k < F; ++k) x_[F * at.body + k] += at.G(k, r) * left_[row(at) + r];
        cholesky_.solve(x_.data());
        change_.assign(left_.size(), 0.0);
        for (const Incidence& at : incidences_)
            for (int r = 0; r < model_.joints[at.joint].rows; ++r)
                for (int k = 0; k < F; ++k) change_[row(at) + r] += at.G(k, r) * x_[F * at.body + k];
        double most = 0.0;
        for (std::size_t r = 0; r < left_.size(); ++r) {
            smallest_[r] += change_[r];
            left_[r] -= change_[r];
            most = max(most, abs(change_[r]));
        }
        return most;
    }
    double size() const {
        double most = 0.0;
        for (const double part : smallest_) most = max(most, abs(part));
        return most;
    }

    const Model<D>& model_;
    const EliminationOrder<D>& order_;
    std::vector<Incidence> incidences_;
    std::vector<Product> products_;
    BlockCholesky cholesky_;
    std::vector<double> left_, smallest_, change_, x_;  // λ for scaled rows, and the argument of G
};

}  // namespace mbproj
