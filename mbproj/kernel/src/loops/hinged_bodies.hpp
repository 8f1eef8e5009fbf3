// The loops' bodies that move by hinges, in a solution: δ = X δ_parent + N z + p, where the right-hand sides of the hinge
// give p and the loops give z.
#pragma once

#include "loops/delassus_matrix.hpp"

namespace mbproj {

template <int D> class HingedBodies final {
public:
    static constexpr int F = Size<D>::freedoms;

    HingedBodies(const Model<D>& model, const DelassusMatrix<D>& rows)
        : model_(model), rows_(rows), bodies_(rows.hinges.size()) {}

    // Bodies are numbered as `rows.hinges`.
    void set_inertia(int h, const Inertia<D>& M) { bodies_[h].M = M; }

    // What right-hand sides ask of the hinges alone.
    void move(const double* c) {
        for (std::size_t h = 0; h < bodies_.size(); ++h) bodies_[h].p = rows_.hinges[h].particular(model_, c);
    }
    // Zᵀ of the force on a body, less what p takes of it; the rest goes to the force on its parent, where it has one.
    void push(int h, const InverseRoot<D>& half, Column<F>& force, Column<F>* on_parent) {
        Body& body = bodies_[h];
        body.f = force;
        half.forward(force, body.p);
        if (!on_parent) return;
        Column<F> rest = body.f - body.M * body.p;
        half.remove(force, rest);
        *on_parent += rows_.hinges[h].felt(rest);
    }
    // From Zᵀ of it the motion of a body, with that of its parent, where it has one.
    void release(int h, const InverseRoot<D>& half, Column<F>& twist, const Column<F>* of_parent) {
        half.backward(twist);
        twist += bodies_[h].p;
        if (of_parent) {
            Column<F> with_it = rows_.hinges[h].carried(*of_parent);
            half.hold(with_it);
            twist += with_it;
        }
        bodies_[h].delta = twist;
    }
    // x += sign G p, of the loops' rows.
    void add_particular(double* x, double sign) const {
        rows_.each_hinged_gradient([&](int h, int row, const auto& g) { x[row] += sign * g.dot(bodies_[h].p); });
    }
    // λ of the hinges, from those of the rows of S, of the last solution.
    void multipliers(const std::vector<double>& of_rows, double* lambda) {
        for (Body& body : bodies_) body.wrench = body.M * body.delta - body.f;
        rows_.each_hinged_gradient([&](int h, int row, const auto& g) { bodies_[h].wrench += of_rows[row] * g; });
        for (std::size_t h = 0; h < bodies_.size(); ++h) rows_.hinges[h].multipliers(model_, bodies_[h].wrench, lambda);
    }

private:
    struct Body {
        Inertia<D> M;
        Column<F> f, p, delta, wrench;  // of the last, what the hinge exerts
    };

    const Model<D>& model_;
    const DelassusMatrix<D>& rows_;
    std::vector<Body> bodies_;
};

}  // namespace mbproj
