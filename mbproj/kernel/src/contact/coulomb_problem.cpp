// Coulomb's law by a semismooth Newton method (Alart and Curnier 1991), from large compliances to small ones.
#include "contact/coulomb_problem.hpp"
#include "contact/rows.hpp"

#include <cmath>

#include "model/decompositions.hpp"

namespace mbproj {

namespace {

using DenseMatrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Index = Eigen::Index;

constexpr int first_digits = 2, last_digits = 13;  // compliances of 10^-2 to 10^-13 of a row's own mobility
constexpr int most_steps = 60;                     // of Newton's method for one compliance

// The law in the rows that push or hold. `spread` gives all forces from theirs: sliding friction follows a push.
class Law {
public:
    Law(const DenseMatrix& B, const Vector& b, const std::vector<Cone>& cones) {
        std::vector<Index> rows;
        const auto add = [&](Index row) { return rows.push_back(row), static_cast<Index>(rows.size()) - 1; };
        for (const Cone& cone : cones) {
            Contact own{cone.push < 0 ? -1 : add(cone.push), {}, cone.most};
            if (cone.slides.empty())
                for (const int k : cone.tangents) own.tangents.push_back(add(k));
            contacts_.push_back(own);
        }
        rows_ = rows;
        spread_ = DenseMatrix::Zero(b.size(), static_cast<Index>(rows.size()));
        for (std::size_t i = 0; i < rows.size(); ++i) spread_(rows[i], static_cast<Index>(i)) = 1.0;
        for (std::size_t c = 0; c < cones.size(); ++c)
            for (std::size_t i = 0; i < cones[c].slides.size(); ++i)
                spread_(cones[c].tangents[i], contacts_[c].push) = cones[c].slides[i];
        b_ = b(rows_);
        B_ = B(rows_, Eigen::all) * spread_;
        mobility_ = B.diagonal()(rows_);
    }

    Index size() const { return b_.size(); }
    Vector spread(const Vector& forces) const { return spread_ * forces; }
    Vector accelerations(const Vector& forces, double give) const {
        return b_ + B_ * forces + give * mobility_.cwiseProduct(forces);
    }

    // The residual r of the law at these forces, in units of force, and its slope. `pace` multiplies accelerations.
    void at(const Vector& forces, double give, double pace, Vector& r, DenseMatrix& slope) const {
        const Vector a = accelerations(forces, give);
        DenseMatrix A = B_;
        A.diagonal() += give * mobility_;
        r.resize(size()), slope = DenseMatrix::Identity(size(), size());
        for (const Contact& contact : contacts_) {
            double bound = contact.most;
            Eigen::RowVectorXd bound_slope = Eigen::RowVectorXd::Zero(size());
            if (const Index n = contact.push; n >= 0) {
                const double step = pace / mobility_[n], wanted = forces[n] - step * a[n];
                bound = 0.0;
                if (wanted > 0.0) {
                    bound = contact.most * wanted;
                    bound_slope = -contact.most * step * A.row(n);
                    bound_slope[n] += contact.most;
                    r[n] = step * a[n], slope.row(n) = step * A.row(n);
                } else {
                    r[n] = forces[n];
                }
            }
            if (!contact.tangents.empty()) hold(contact.tangents, bound, bound_slope, A, forces, a, pace, r, slope);
        }
    }

private:
    struct Contact {
        Index push;
        std::vector<Index> tangents;
        double most;
    };

    // The rows of a friction at rest, with a bound that depends on the forces.
    void hold(const std::vector<Index>& rows, double bound, const Eigen::RowVectorXd& bound_slope, const DenseMatrix& A,
              const Vector& forces, const Vector& a, double pace, Vector& r, DenseMatrix& slope) const {
        const double step = pace / mobility_(rows).maxCoeff();
        const Vector wanted = forces(rows) - step * a(rows);
        DenseMatrix wanted_slope = -step * A(rows, Eigen::all);
        for (std::size_t i = 0; i < rows.size(); ++i) wanted_slope(static_cast<Index>(i), rows[i]) += 1.0;
        const double size = wanted.norm();
        if (size <= bound) {
            r(rows) = step * a(rows), slope(rows, Eigen::all) = step * A(rows, Eigen::all);
        } else if (bound <= 0.0) {
            r(rows) = forces(rows);
        } else {
            const Vector way = wanted / size;
            r(rows) = forces(rows) - bound * way;
            slope(rows, Eigen::all) -=
                way * bound_slope + bound / size * (wanted_slope - way * (way.transpose() * wanted_slope));
        }
    }

    std::vector<Contact> contacts_;
    std::vector<Index> rows_;
    DenseMatrix B_, spread_;
    Vector b_, mobility_;
};

// Newton's method for one compliance, from `forces` on; steps that do not improve are halved. One more step follows the first
// that is good enough.
bool solve(const Law& law, double give, double pace, const Thresholds& thresholds, Vector& forces) {
    constexpr int most_halvings = 9;
    Vector r, r_trial, trial;
    DenseMatrix slope, slope_trial;
    law.at(forces, give, pace, r, slope);
    for (int step = 0; step < most_steps; ++step) {
        const bool there = r.norm() <= thresholds.no_push * std::min(1.0, pace) * largest(forces);
        const Vector change = least_squares(slope, -r);
        for (int halvings = 0; halvings <= most_halvings; ++halvings) {
            trial = forces + std::ldexp(1.0, -halvings) * change;
            law.at(trial, give, pace, r_trial, slope_trial);
            if (there || r_trial.norm() < r.norm()) break;
        }
        if (!trial.allFinite()) return there;
        if (!there || r_trial.norm() < r.norm()) forces = trial;
        if (there) return true;
        r = r_trial, slope.swap(slope_trial);
    }
    return false;
}

}  // namespace

bool coulomb_problem(const DenseMatrix& B, const Vector& b, const std::vector<Cone>& cones,
                     const Thresholds& thresholds, Vector& y, Vector& a) {
    const Law law(B, b, cones);
    y = Vector::Zero(b.size()), a = b;
    if (law.size() == 0) return true;
    // No pace serves all: random bodies on 2 to 6 feet (tests/friction/planes/test_contact_problem.py) need one or another.
    for (const int stride : {3, 1})
        for (const double pace : {10.0, 1.0, 100.0, 0.1}) {
            Vector forces = Vector::Zero(law.size());
            bool found = true;
            for (int digits = first_digits; found; digits = std::min(digits + stride, last_digits)) {
                found = solve(law, std::pow(10.0, -digits), pace, thresholds, forces);
                if (digits == last_digits) break;
            }
            if (!found) continue;
            y = law.spread(forces);
            a = b + B * y;
            return true;
        }
    return false;
}

}  // namespace mbproj
