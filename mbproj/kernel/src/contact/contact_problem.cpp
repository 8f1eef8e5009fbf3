// The contact problem by Newton's method, damped where a step does not improve.
#include "contact/contact_problem.hpp"
#include "contact/rows.hpp"

#include <cmath>

#include "model/decompositions.hpp"
#include "model/semidefinite.hpp"

namespace mbproj {

namespace {

using DenseMatrix = Eigen::MatrixXd;
using Numbers = Eigen::VectorXd;
using Rows = std::vector<Eigen::Index>;

// P(u) and its derivative.
class Projection {
public:
    Projection(const std::vector<Cone>& cones, Eigen::Index size)
        : y(Numbers::Zero(size)), slope(DenseMatrix::Zero(size, size)), cones_(cones) {}

    void of(const Numbers& u) {
        y.setZero();
        slope.setZero();
        for (const Cone& cone : cones_) {
            if (cone.push < 0)
                limit(u, cone);
            else if (cone.slides.size() || cone.tangents.empty())
                push(u, cone);
            else
                within(u, cone);
        }
    }

    Numbers y;
    DenseMatrix slope;

private:
    static double size(const Numbers& u, const Cone& cone) {
        double sum = 0.0;
        for (const int k : cone.tangents) sum += u[k] * u[k];
        return std::sqrt(sum);
    }
    void push(const Numbers& u, const Cone& cone) {
        if (!(u[cone.push] > 0.0)) return;
        y[cone.push] = u[cone.push];
        slope(cone.push, cone.push) = 1.0;
        for (std::size_t i = 0; i < cone.slides.size(); ++i) {
            y[cone.tangents[i]] = u[cone.push] * cone.slides[i];
            slope(cone.tangents[i], cone.push) = cone.slides[i];
        }
    }
    void stick(const Numbers& u, const Cone& cone) {
        for (const int k : cone.tangents) y[k] = u[k], slope(k, k) = 1.0;
    }
    // Adds the slope of a force of constant size along u_t, which turns with u.
    void turn(const Numbers& u, const Cone& cone, double size, double force) {
        for (const int i : cone.tangents)
            for (const int j : cone.tangents)
                slope(i, j) += force / size * ((i == j ? 1.0 : 0.0) - u[i] / size * (u[j] / size));
    }
    // A force of at most a given size.
    void limit(const Numbers& u, const Cone& cone) {
        const double wanted = size(u, cone);
        if (wanted <= cone.most) return stick(u, cone);
        for (const int k : cone.tangents) y[k] = cone.most * (u[k] / wanted);
        turn(u, cone, wanted, cone.most);
    }
    // The cone of Coulomb, |y_t| <= most y_n.
    void within(const Numbers& u, const Cone& cone) {
        const double pushed = u[cone.push], wanted = size(u, cone), most = cone.most, edges = 1.0 + most * most;
        if (wanted <= most * pushed) {
            y[cone.push] = pushed;
            slope(cone.push, cone.push) = 1.0;
            return stick(u, cone);
        }
        const double edge = (pushed + most * wanted) / edges;
        if (!(edge > 0.0)) return;
        const auto along = [&](int k) { return k == cone.push ? 1.0 : most * (u[k] / wanted); };
        Rows rows(cone.tangents.begin(), cone.tangents.end());
        rows.push_back(cone.push);
        for (const auto i : rows) y[i] = edge * along(static_cast<int>(i));
        for (const auto i : rows)
            for (const auto j : rows) slope(i, j) = along(static_cast<int>(i)) * along(static_cast<int>(j)) / edges;
        turn(u, cone, wanted, most * edge);
    }

    const std::vector<Cone>& cones_;
};

Rows held_by(const std::vector<Cone>& cones) {
    Rows held;
    for (const Cone& cone : cones) {
        if (cone.push >= 0) held.push_back(cone.push);
        if (cone.slides.empty()) held.insert(held.end(), cone.tangents.begin(), cone.tangents.end());
    }
    return held;
}

// The largest work along u of forces within the cones, with pushes of at most `most`.
double most_along(const Numbers& u, const std::vector<Cone>& cones, double most) {
    Projection beyond(cones, u.size());
    beyond.of(u);
    double sum = 0.0;
    for (const Cone& cone : cones) {
        double along = 0.0, squares = 0.0, sliding = cone.push < 0 ? 0.0 : u[cone.push];
        for (const int k : cone.tangents) along += u[k] * beyond.y[k], squares += u[k] * u[k];
        for (std::size_t i = 0; i < cone.slides.size(); ++i) sliding += cone.slides[i] * u[cone.tangents[i]];
        if (cone.push < 0)
            sum += cone.most * std::sqrt(squares);
        else if (cone.slides.empty())
            sum += most * std::sqrt(along + u[cone.push] * beyond.y[cone.push]);
        else
            sum += most * std::max(sliding, 0.0);
    }
    return sum;
}

}  // namespace

bool contact_problem(const DenseMatrix& B, const Numbers& b, const std::vector<Cone>& cones,
                     const Thresholds& thresholds, Numbers& y) {
    constexpr int most_passes = 100, most_tries = 20;  // of Newton's method; of passes that may not improve
    const Rows held = held_by(cones);
    const double scale = largest(b(held));
    y = Numbers::Zero(b.size());
    if (scale == 0.0) return true;
    Rows wanted;
    SemidefiniteCholesky cholesky;
    cholesky.factor(B(held, held), thresholds.no_push);
    for (const auto k : cholesky.rows()) wanted.push_back(held[k]);
    std::sort(wanted.begin(), wanted.end());
    const DenseMatrix rows = B(wanted, Eigen::all), own = B(wanted, wanted), spread = B(Eigen::all, wanted);
    const Numbers b_wanted = b(wanted);
    const auto left_over = [&](const Numbers& y) { return Numbers(b_wanted + rows * y); };

    Numbers w = solved(rows * spread, -b_wanted);  // as if all forces were within their cones
    Projection at(cones, b.size()), trial(cones, b.size());
    const double largest_push = 1e2 * largest(spread * w);
    at.of(spread * w);
    Numbers off = left_over(at.y);
    double damping = 0.0;
    bool leaps = false;
    for (int pass = 0, tries = most_tries; pass < most_passes; ++pass) {
        if (largest(off) <= thresholds.no_push * scale) {
            y = at.y;
            return largest((b + B * y)(held)) <= std::sqrt(thresholds.no_push) * scale;
        }
        // The residual is the gradient of a convex function. Where the function has no minimum, the residual becomes a
        // direction along which forces would have to do more work than they can (Farkas).
        if (b_wanted.dot(off) > most_along(-spread * off, cones, largest_push)) return false;
        const DenseMatrix left = rows * at.slope * spread;
        Numbers w_trial, off_trial;
        while (true) {
            w_trial = w + least_squares(left + damping * own, -off);
            trial.of(spread * w_trial);
            off_trial = left_over(trial.y);
            if (off_trial.norm() < off.norm() || leaps) break;
            damping = std::max(10.0 * damping, thresholds.rounding);
            if (damping > thresholds.damped_to) {  // no short step improves: some long ones leave this point
                damping = std::sqrt(thresholds.rounding);
                leaps = true;
                if (--tries == 0) return false;
            }
        }
        leaps = false;
        w = w_trial, off = off_trial;
        std::swap(at.y, trial.y), at.slope.swap(trial.slope);
        damping = damping > thresholds.rounding ? 0.1 * damping : 0.0;
    }
    return false;
}

}  // namespace mbproj
