// The path by extrapolation (Gragg 1965, Bulirsch and Stoer 1966), in pieces of sliding and of sticking.
#include "laws/impulse_path.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include "algebra/decompositions.hpp"

namespace mbproj {

namespace {

using Vector = Eigen::VectorXd;
using Goal = std::function<double(const Vector&)>;

// y = (rates, impulses, works) over p, with B(0, 0) = 1 and rates of size 1.
class Path {
public:
    Path(const Eigen::MatrixXd& B, double coefficient, const Thresholds& thresholds)
        : B_(B), coefficient_(coefficient), thresholds_(thresholds), size_(B.rows()), tangents_(B.rows() - 1),
          sticking_(-released(B.col(0).tail(tangents_))) {}

    // Follows y to where the goal rises through zero; false where it does not.
    bool follow(const Goal& goal, Vector& y) const {
        constexpr int most_pieces = 8;
        const double rests = thresholds_.stop_rests;
        if (goal(y) >= 0.0) return true;
        for (int piece = 0; piece < most_pieces; ++piece) {
            bool slides = tangent(y).norm() > rests;
            if (!slides && sticking_.norm() > coefficient_) tangent(y) = 2.0 * rests * beginning(), slides = true;
            bool arrived = false;
            if (!follow_piece(goal, slides, y, arrived)) return false;
            if (arrived) return true;
            const Vector left = -released(tangent(y));  // the remaining sliding stops at once
            y.segment(size_ + 1, tangents_) += left;
            y.head(size_) += B_.rightCols(tangents_) * left;
        }
        return false;
    }

private:
    using Index = Eigen::Index;

    Eigen::VectorBlock<Vector> tangent(Vector& y) const { return y.segment(1, tangents_); }
    // x with B_tt x = given: the impulses along the tangents that cause these rates.
    Vector released(const Vector& given) const {
        return least_squares(B_.bottomRightCorner(tangents_, tangents_), given);
    }

    Vector slope(const Vector& y, bool slides) const {
        Vector f = Vector::Ones(size_), found(3 * size_);
        const Vector rate = y.head(size_), along = rate.tail(tangents_);
        f.tail(tangents_) = sticking_;
        if (slides) f.tail(tangents_) = -coefficient_ / along.norm() * along;
        found << B_ * f, f, rate.cwiseProduct(f);
        return found;
    }

    // y after a step of size h, and an estimate of its error: Gragg's midpoint method with 2, 4, ... parts,
    // extrapolated. A step in which sliding reverses has an infinite error: it has passed the state of rest.
    Vector after(const Vector& y, double h, bool slides, double& error) const {
        constexpr int columns = 6;
        Vector found[columns];
        bool turns = false;
        const Vector along = y.segment(1, tangents_);
        const auto change = [&](const Vector& at) {
            turns = turns || (slides && !(at.segment(1, tangents_).dot(along) > 0.0));
            return slope(at, slides);
        };
        for (int k = 0; k < columns; ++k) {
            const int parts = 2 * (k + 1);
            const double part = h / parts;
            Vector before = y, now = y + part * change(y);
            for (int i = 1; i < parts; ++i) {
                const Vector next = before + 2.0 * part * change(now);
                before = now, now = next;
            }
            Vector value = 0.5 * (before + now + part * change(now));
            for (int j = 1; j <= k; ++j) {
                const double ratio = static_cast<double>(k + 1) / (k + 1 - j);
                const Vector better = value + (value - found[j - 1]) / (ratio * ratio - 1.0);
                found[j - 1] = value, value = better;
            }
            found[k] = value;
        }
        error = turns ? std::numeric_limits<double>::infinity()
                      : (found[columns - 1] - found[columns - 2]).cwiseAbs().maxCoeff();
        return found[columns - 1];
    }

    // Follows y to the goal, or to where sliding comes to rest. False where neither comes.
    bool follow_piece(const Goal& goal, bool slides, Vector& y, bool& arrived) const {
        double h = 0.1, p = 0.0, error = 0.0;
        while (p < 1.0 / thresholds_.same_written) {
            const Vector next = after(y, h, slides, error);
            if (!(error <= thresholds_.rounding * std::max(1.0, next.cwiseAbs().maxCoeff()))) {
                if (!((h *= 0.5) > 0.0)) return false;
                continue;
            }
            if (goal(y) < 0.0 && goal(next) >= 0.0) return y = at_goal(goal, y, next, h, slides), arrived = true;
            p += h, h *= 2.0, y = next;
            if (slides && tangent(y).norm() <= thresholds_.stop_rests) return true;
        }
        return false;
    }
    // The goal within a step from y to `end`, by the Illinois method.
    Vector at_goal(const Goal& goal, const Vector& y, const Vector& end, double h, bool slides) const {
        double low = 0.0, high = h, below = goal(y), above = goal(end), error = 0.0;
        Vector found = end;
        int side = 0;
        for (int tried = 0; tried < 60 && high - low > thresholds_.rounding * h && above != 0.0; ++tried) {
            const double middle = high - above * (high - low) / (above - below);
            const Vector there = after(y, middle, slides, error);
            const double value = goal(there);
            if (value >= 0.0) {
                high = middle, above = value, found = there;
                if (std::exchange(side, 1) == 1) below *= 0.5;
            } else {
                low = middle, below = value;
                if (std::exchange(side, -1) == -1) above *= 0.5;
            }
        }
        return found;
    }

    // The direction in which sliding begins where sticking is impossible: sliding grows along it.
    Vector beginning() const {
        if (tangents_ == 1) return Vector::Constant(1, B_(1, 0) < 0.0 ? -1.0 : 1.0);
        constexpr int directions = 360;
        const auto way = [](double angle) { return Eigen::Vector2d(std::cos(angle), std::sin(angle)); };
        const auto change = [&](double angle) {
            return Eigen::Vector2d(B_.col(0).tail(2) - coefficient_ * B_.bottomRightCorner(2, 2) * way(angle));
        };
        const auto across = [&](double angle) {
            const Eigen::Vector2d own = way(angle), moved = change(angle);
            return own[0] * moved[1] - own[1] * moved[0];
        };
        for (int k = 0; k < directions; ++k) {
            double low = 2.0 * M_PI * k / directions, high = 2.0 * M_PI * (k + 1) / directions;
            const bool is_below = across(low) <= 0.0;
            if (is_below == (across(high) <= 0.0)) continue;
            for (int halving = 0; halving < 50; ++halving) {
                const double middle = 0.5 * (low + high);
                ((across(middle) <= 0.0) == is_below ? low : high) = middle;
            }
            if (way(low).dot(change(low)) > 0.0) return way(low);
        }
        return way(0.0);
    }

    const Eigen::MatrixXd& B_;
    const double coefficient_;
    const Thresholds& thresholds_;
    const Index size_, tangents_;
    const Vector sticking_;
};

}  // namespace

bool follow_impulse(const Eigen::MatrixXd& B, const Vector& u, double coefficient, double restitution,
                    const Thresholds& thresholds, Vector& impulse, Vector& work) {
    const Eigen::Index size = u.size();
    const double speed = u.norm(), mobility = B(0, 0);
    const Eigen::MatrixXd unit = B / mobility;
    const Path path(unit, coefficient, thresholds);
    Vector y = Vector::Zero(3 * size);
    y.head(size) = u / speed;
    if (!path.follow([](const Vector& at) { return at[0]; }, y)) return false;
    const double given_back = (1.0 - restitution * restitution) * y[2 * size];
    const auto is_given = [&](const Vector& at) { return at[2 * size] - given_back; };
    if (restitution > 0.0 && !path.follow(is_given, y)) return false;
    impulse = y.segment(size, size) * (speed / mobility);
    work = y.tail(size) * (speed * speed / mobility);
    return true;
}

}  // namespace mbproj
