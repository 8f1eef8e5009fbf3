// The solution for bodies of the loops that move by hinges: δ = X δ_parent + N z + p. The right-hand sides of the hinge
// give p, the loops give z.
#pragma once

#include "solver/delassus_matrix.hpp"

namespace mbproj {

template <class D> class HingedBodies final {
public:
    static constexpr int F = Size<D>::freedoms;

    HingedBodies(const Model<D>& model, const DelassusMatrix<D>& rows)
        : model_(model), rows_(rows), bodies_(rows.hinges.size()) {}

    // Sets the inverse roots of these bodies from their articulated inertias, and adds the articulated inertias to
    // their parents. False where a free motion has no inertia.
    bool set_inertias(std::vector<Inertia<D>>& inertias, std::vector<InverseRoot<D>>& halves) {
        for (std::size_t h = 0; h < bodies_.size(); ++h) {
            const LoopHinge<D>& hinge = rows_.hinges[h];
            const Inertia<D>& M = inertias[hinge.child()];
            InverseRoot<D>& half = halves[rows_.layout().place(hinge.child())];
            if (!half.hinged(hinge, M)) return false;
            bodies_[h].M = M;
            if (hinge.parent() == model_.size()) continue;
            Inertia<D> left = M;
            half.remove(left);
            inertias[hinge.parent()].add(hinge.at_parent(left));
        }
        return true;
    }

    // Sets the motions p that right-hand sides require of the hinges alone.
    void move(const double* c) {
        for (std::size_t h = 0; h < bodies_.size(); ++h) bodies_[h].p = rows_.hinges[h].particular(model_, c);
    }
    // Zᵀ of the force on a body, without the inertia force of p; the rest is added to the force on its parent, if any.
    void push(int h, const InverseRoot<D>& half, Column<F>& force, Column<F>* on_parent) {
        Body& body = bodies_[h];
        body.f = force;
        half.forward(force, body.p);
        if (!on_parent) return;
        Column<F> rest = body.f - body.M * body.p;
        half.remove(force, rest);
        *on_parent += rows_.hinges[h].at_parent(rest);
    }
    // The motion of a body from its solution in Z, with the motion of its parent, if any.
    void release(int h, const InverseRoot<D>& half, Column<F>& twist, const Column<F>* of_parent) {
        half.backward(twist);
        twist += bodies_[h].p;
        if (of_parent) {
            Column<F> with_it = rows_.hinges[h].with_parent(*of_parent);
            half.hold(with_it);
            twist += with_it;
        }
        bodies_[h].delta = twist;
    }
    // x += sign G p in the loops' rows.
    void add_particular(double* x, double sign) const {
        rows_.each_hinged_gradient([&](int h, int row, const auto& g) { x[row] += sign * g.dot(bodies_[h].p); });
    }
    // λ of the hinges in the last solution, from the multipliers of the rows of S.
    void multipliers(const std::vector<double>& of_rows, double* lambda) {
        for (Body& body : bodies_) body.wrench = body.M * body.delta - body.f;
        rows_.each_hinged_gradient([&](int h, int row, const auto& g) { bodies_[h].wrench += of_rows[row] * g; });
        for (std::size_t h = 0; h < bodies_.size(); ++h) rows_.hinges[h].multipliers(model_, bodies_[h].wrench, lambda);
    }

private:
    struct Body {
        Inertia<D> M;
        Column<F> f, p, delta, wrench;  // of the last solution; `wrench` is that of the hinge
    };

    const Model<D>& model_;
    const DelassusMatrix<D>& rows_;
    std::vector<Body> bodies_;
};

}  // namespace mbproj
