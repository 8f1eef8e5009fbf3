// The Delassus matrix S = YᵀY of the rows of the loops' joints. Each row has a column of Y = Zᵀ Gᵀ, with W⁻¹ = Z Zᵀ.
// Some rows are held; the others are left out because they follow from these.
#pragma once

#include <utility>

#include "solver/dependent_by_level.hpp"
#include "solver/inverse_root.hpp"
#include "solver/row_layout.hpp"

namespace mbproj {

template <class D> class DelassusMatrix final {
public:
    using S = Size<D>;
    static constexpr int F = S::freedoms;
    using JointRows = typename RowLayout<D>::JointRows;
    using Incidence = typename RowLayout<D>::Incidence;
    using Flywheel = typename RowLayout<D>::Flywheel;

    DelassusMatrix(const Model<D>& model, const EliminationOrder<D>& order, const Compliance<D>& compliance,
                   LoopRows which)
        : halves(order.loop_bodies.size()), hinges(order.loop_hinges), model_(model), order_(order),
          compliance_(compliance), layout_(model, order, which), slips_(model.slips()) {
        leave_out({});
    }

    std::vector<InverseRoot<D>> halves;  // of the loops' bodies
    std::vector<LoopHinge<D>> hinges;
    BlockCholesky cholesky;
    // Whether flywheels have their inertia, as in the metric of the masses. In other metrics they are not coupled to the bodies.
    bool flywheels_turn = true;
    // Whether compliant rows are active, as in a stage of an implicit step. A row is R J, with -1 for a flywheel of inertia 1, so
    // that S has R J W⁻¹ Jᵀ Rᵀ + 1 for any D = RᵀR.
    bool complies = false;

    const RowLayout<D>& layout() const { return layout_; }
    const std::vector<JointRows>& held() const { return layout_.held(); }
    const std::vector<Incidence>& incidences() const { return layout_.incidences(); }
    const std::vector<Flywheel>& flywheels() const { return layout_.flywheels(); }
    int count() const { return layout_.count(); }
    double y(const Flywheel& flywheel) const {
        return (flywheel.is_compliant ? complies : flywheels_turn) ? flywheel.y : 0.0;
    }
    // Turns right-hand sides of J into those of the rows R J; 0 where compliant rows are not active.
    void scale(double* rhs) const {
        for (const int h : layout_.compliant()) {
            double* part = rhs + cholesky.row(h);
            if (complies)
                compliance_.turn(held()[h].joint, held()[h].count, part);
            else
                std::fill(part, part + held()[h].count, 0.0);
        }
    }

    // Sets the hinges at a pose; returns the joint whose rows are dependent there, or -1.
    int set_hinges(const Pose<D>& pose) {
        for (LoopHinge<D>& hinge : hinges)
            if (!hinge.set_pose(model_, pose)) return hinge.joint();
        return -1;
    }
    // The joint of a block of S; for a weld, the hinge of the body that is divided into pieces.
    int joint_of(int block) const {
        if (block < layout_.joints()) return held()[block].joint;
        for (const Incidence& at : incidences())
            if (at.held == block) return hinges[layout_.hinge_of(at.body)].joint();
        return -1;
    }
    // Calls visit(row of S, row of the model) for all rows of joints that are held.
    template <class Visit> void each_row(Visit&& visit) const {
        for (int h = 0; h < layout_.joints(); ++h)
            for (int r = 0, row = cholesky.row(h); r < held()[h].count; ++r)
                visit(row + r, model_.joints[held()[h].joint].row + held()[h].rows[r]);
    }
    // Calls visit(body of the loops or piece, row of S, column of Y).
    template <class Visit> void each_column(Visit&& visit) const {
        for (const Incidence& at : incidences())
            for (int r = 0; r < at.count; ++r) visit(at.piece, at.row + r, at.Y.col(r));
    }
    // x += Yᵀw, and w -= Y x, with w of the loops' bodies and pieces of bodies.
    void add_products(const std::vector<Column<F>>& w, double* x) const {
        for (const Incidence& at : incidences()) {
            const Column<F>& own = w[at.piece];
            double* to = x + at.row;
            if (at.has_one_entry)
                for (int r = 0; r < at.count; ++r) to[r] = multiply_add(at.Y(0, r), own[0], to[r]);
            else
                for (int r = 0; r < at.count; ++r) to[r] += at.Y.col(r).dot(own);
        }
    }
    void subtract_products(const double* x, std::vector<Column<F>>& w) const {
        for (const Incidence& at : incidences()) {
            const double* from = x + at.row;
            Column<F> own = w[at.piece];
            if (at.has_one_entry)
                for (int r = 0; r < at.count; ++r) own[0] = multiply_add(-from[r], at.Y(0, r), own[0]);
            else
                for (int r = 0; r < at.count; ++r) own.add_multiple(-from[r], at.Y.col(r));
            w[at.piece] = own;
        }
    }
    // Calls visit(flywheel, row of S, its entry of Y).
    template <class Visit> void each_flywheel(Visit&& visit) const {
        for (std::size_t f = 0; f < flywheels().size(); ++f) visit(f, flywheels()[f].row, y(flywheels()[f]));
    }
    // Calls visit(number of the hinge, row of S, gradient) for all rows that act on hinged bodies; of G, or of R J.
    template <class Visit> void each_hinged_gradient(Visit&& visit) const {
        for (const Incidence& at : incidences())
            if (at.hinged >= 0)
                for (int r = 0, hinge = layout_.hinge_of(at.body); r < at.count; ++r)
                    visit(hinge, at.row + r, gradients_[at.hinged].col(r));
    }

    // Y and S at a pose, with a shift on the diagonal entries of C's rows.
    void fill(const Pose<D>& pose, double shift = 0.0) {
        cholesky.clear();
        Matrix<F, F> G;  // one column for each row
        for (Incidence& at : layout_.incidences())
            if (at.hinged >= 0) fill_hinged(pose, at, gradients_[at.hinged], passed_on_[at.hinged]);
        for (Incidence& at : layout_.incidences())
            if (at.hinged < 0 && !at.is_weld) fill_incidence(pose, held()[at.held], at, G);
        for (const auto& product : layout_.products()) add_product(product);
        if (shift > 0.0) penalise(shift);
        for (const Flywheel& f : flywheels()) *cholesky.at(f.offset) += y(f) != 0.0 ? f.y * f.y : 1.0;
    }

    // Y and S where all bodies have the same mass, with lengths in parts of the mechanism's.
    void fill_evenly(const Pose<D>& pose) {
        for (std::size_t b = 0; b < halves.size(); ++b)
            halves[b].bare(1.0 / (model_.length * model_.length), pose[order_.loop_bodies[b]].rotation,
                           Matrix<S::turns, S::turns>::Identity());
        const bool turn = std::exchange(flywheels_turn, false), comply = std::exchange(complies, false);
        fill(pose);
        flywheels_turn = turn;
        complies = comply;
    }

    // For each joint that is held, the rows that are independent at the pose of the last `fill_evenly`: their distance from the
    // span of the rows before exceeds √smallest. Hinges that come first keep all their rows. Stops once more than `most` rows are
    // dependent. Overwrites S.
    std::vector<std::vector<int>> independent_rows(double smallest, int most) {
        auto rows = cholesky.independent_rows(smallest, model_.thresholds.tied, most);
        rows.erase(rows.begin(), rows.begin() + layout_.first());
        return rows;
    }

    // Whether some rows are at velocity level: these count as dependent before others do.
    bool has_levels() const { return !slips_.empty(); }
    // The dependent rows, by the model's numbers, ascending within a joint; too many rows where there are more than `most`.
    std::vector<int> dependent_rows(double smallest, int most) {
        if (has_levels()) return dependent_by_level(*this, slips_, model_, smallest);
        const auto independent = independent_rows(smallest, most);
        std::vector<int> found;
        for (std::size_t h = 0; h < independent.size(); ++h) {
            const Joint& joint = model_.joints[held()[h].joint];
            for (int r = 0; r < joint.rows; ++r)
                if (!std::binary_search(independent[h].begin(), independent[h].end(), r))
                    found.push_back(joint.row + r);
        }
        return found;
    }

    // Leaves all rows but these out of the next factors, or none. Returns their number.
    int leave_out_all_but(const std::vector<std::vector<int>>& rows) {
        std::vector<char> dependent(count(), 0);
        for (int h = 0; h < layout_.joints(); ++h) {
            std::fill_n(dependent.begin() + cholesky.row(h), held()[h].count, 1);
            for (const int r : rows[h]) dependent[cholesky.row(h) + r] = 0;
        }
        const auto count = std::count(dependent.begin(), dependent.end(), 1);
        cholesky.leave_out(count ? std::move(dependent) : std::vector<char>());
        return static_cast<int>(count);
    }

    // See `RowLayout::leave_out`.
    void leave_out(const std::vector<int>& rows) {
        if (auto others = layout_.leave_out(rows)) {
            cholesky = std::move(*others);
            gradients_.assign(layout_.hinged(), Matrix<F, F>::Zero());
            passed_on_ = gradients_;
        }
    }

private:
    // Adds YᵀY of incidences a and b to its block of S; the lower half where a is b. The columns are copied, so that
    // the compiler keeps them in registers.
    void add_product(const typename RowLayout<D>::Product& product) {
        const Incidence &a = incidences()[product.a], &b = incidences()[product.b];
        double* target = cholesky.at(product.offset);
        for (int r = 0; r < a.count; ++r, target += b.count) {
            const int columns = product.a == product.b ? r + 1 : b.count;
            const Column<F> y = a.Y.col(r);
            if (a.has_one_entry)
                for (int c = 0; c < columns; ++c) target[c] = multiply_add(y[0], b.Y(0, c), target[c]);
            else
                for (int c = 0; c < columns; ++c) target[c] += y.dot(b.Y.col(c));
        }
    }

    void penalise(double shift) {
        for (int h = 0; h < layout_.joints(); ++h) {
            double* block = cholesky.at(cholesky.target(h, h).offset);
            if (const int count = held()[h].count;
                !model_.holds_flywheel(held()[h].joint) && !model_.is_compliant(held()[h].joint))
                for (int r = 0; r < count; ++r) block[r * (count + 1)] += shift;
        }
    }

    // Fills columns of Y; G becomes the gradients of all rows of the joint, one column each.
    void fill_incidence(const Pose<D>& pose, const JointRows& held, Incidence& at, Matrix<F, F>& G) const {
        if (at.acts)
            fill_gradients(pose, held.joint, at.body, G);
        else
            G.setZero();
        for (int r = 0; r < at.count; ++r) {
            Column<F> y = G.col(held.rows[r]);
            for (int k = 0; k < 2 && at.passed_on[k] >= 0; ++k) y += passed_on_[at.passed_on[k]].col(r);
            halves[at.body].forward(y);
            at.Y.col(r) = y;
        }
    }
    // Fills columns of Y of a hinged body, which has all rows of its joints. `passed_on`: gradients on the parent.
    void fill_hinged(const Pose<D>& pose, Incidence& at, Matrix<F, F>& G, Matrix<F, F>& passed_on) {
        const LoopHinge<D>& hinge = hinges[layout_.hinge_of(at.body)];
        fill_gradients(pose, held()[at.held].joint, at.body, G);
        const InverseRoot<D>& half = halves[at.body];
        const double root = layout_.root(at.body);
        for (int r = 0; r < at.count; ++r) {
            const Column<F> g = G.col(r);
            double square = 0.0;
            for (int k = 0; k < half.width(); ++k) {
                const double y = root * half.entry(k, g);
                at.Y(k, r) = y;
                square = multiply_add(y, y, square);
            }
            cholesky.hide(at.row + r, max(0.0, half.free_square(g) - square));
            if (hinge.parent() == model_.size()) continue;
            Column<F> left = g;
            half.remove(at.Y.col(r), left);
            passed_on.col(r) = hinge.at_parent(left);
        }
    }
    void fill_gradients(const Pose<D>& pose, int joint, int body, Matrix<F, F>& G) const {
        const bool is_compliant = model_.is_compliant(joint);
        if ((!flywheels_turn && model_.holds_flywheel(joint)) || (is_compliant && !complies)) return G.setZero();
        jacobian<D>(model_, pose, model_.joints[joint], order_.loop_bodies[body], G.transpose());
        if (is_compliant) compliance_.turn(joint, model_.joints[joint].rows, G);
    }

    const Model<D>& model_;
    const EliminationOrder<D>& order_;
    const Compliance<D>& compliance_;
    RowLayout<D> layout_;
    const std::vector<char> slips_;  // by row of the model; empty where no row is at velocity level
    std::vector<Matrix<F, F>> gradients_,
        passed_on_;  // of rows on hinged bodies, and of the same rows on their parents
};

}  // namespace mbproj
