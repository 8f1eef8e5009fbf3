// The path by extrapolation (Gragg 1965, Bulirsch and Stoer 1966), in pieces in which each stop keeps sliding or sticking.
#include "contact/impulse_path.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "contact/coulomb_problem.hpp"
#include "contact/rows.hpp"
#include "model/decompositions.hpp"

namespace mbproj {

namespace {

using Index = Eigen::Index;
using Vector = Eigen::VectorXd;
using DenseMatrix = Eigen::MatrixXd;
using Goal = std::function<double(const Vector&)>;
using Rows = std::vector<Index>;

// A stop that pushes with friction: its rows of tangents, and the largest friction per dp.
struct Rough {
    Rows tangents;
    double most;
    bool slides = false;
};

// y = (rates, impulses, works, what was given back less what may be) over p; rates of size 1.
class Path {
public:
    Path(const DenseMatrix& B, const Vector& push, const Vector& e, const Rubbing& rubbing,
         const std::vector<bool>& moves, const Thresholds& thresholds)
        : B_(B), push_(push), squares_(e.cwiseAbs2()), thresholds_(thresholds), size_(B.rows()), stops_(push.size()),
          rests_(thresholds.same_written), given_(Vector::Zero(size_)) {
        given_.head(stops_) = push;
        for (Index i = 0; i < stops_; ++i) {
            Rough rough{{}, 0.0};
            for (Index k = 0; k < rubbing.size(); ++k) {
                if (rubbing.by[of(k)] != i || !moves[of(stops_ + k)]) continue;
                rough.tangents.push_back(stops_ + k);
                rough.most = rubbing.coefficient[of(k)] * push[i];
            }
            if (rough.most > thresholds_.no_digits * push[i]) rough_.push_back(rough);
        }
    }

    double power(const Vector& y) const { return push_.dot(y.head(stops_)); }
    double given_back(const Vector& y) const { return y[3 * size_]; }
    Vector start(const Vector& u) const {
        Vector y = Vector::Zero(3 * size_ + 1);
        y.head(size_) = u;
        return y;
    }

    // Follows y to where the goal rises through zero; false where it does not, with y where the motion ends.
    bool follow(const Goal& goal, Vector& y) {
        const auto most_pieces = 8 * (rough_.size() + 1);
        const double moved = thresholds_.no_push * push_.dot(B_.topLeftCorner(stops_, stops_) * push_);
        if (goal(y) >= 0.0) return true;
        for (std::size_t piece = 0; piece < most_pieces; ++piece) {
            if (!begin_piece(y)) return false;
            if (!any_slides() && !(push_.dot((B_ * given_).head(stops_)) > moved)) return false;
            bool arrived = false;
            if (!follow_piece(goal, y, arrived)) return false;
            if (arrived) return true;
            for (const Rough& each : rough_) {  // the remaining sliding stops at once
                if (!each.slides || size(y, each) > rests_) continue;
                const Vector left = least_squares(B_(each.tangents, each.tangents), -y(each.tangents));
                for (std::size_t k = 0; k < each.tangents.size(); ++k)
                    y[size_ + each.tangents[k]] += left[static_cast<Index>(k)];
                y.head(size_) += B_(Eigen::all, each.tangents) * left;
            }
        }
        return false;
    }

private:
    static double size(const Vector& y, const Rough& at) { return y(at.tangents).norm(); }
    bool any_slides() const {
        return std::any_of(rough_.begin(), rough_.end(), [](const Rough& each) { return each.slides; });
    }

    // Decides which stops slide from here on, and which stick, with the friction `given_`. One that begins to slide gets a speed
    // that is next to nothing.
    bool begin_piece(Vector& y) {
        held_.clear();
        given_.tail(size_ - stops_).setZero();
        for (Rough& each : rough_) {
            const double speed = size(y, each);
            each.slides = speed > rests_;
            if (each.slides)
                given_(each.tangents) = -each.most / speed * y(each.tangents);
            else
                held_.insert(held_.end(), each.tangents.begin(), each.tangents.end());
        }
        if (held_.empty()) return true;
        const Vector a = (B_ * given_)(held_);
        given_(held_) = least_squares(B_(held_, held_), -a);
        if (!exceeds()) return keep_piece(), true;
        Vector found;
        if (!limited(a, found)) return false;
        given_(held_) = found;
        const Vector change = B_ * given_;
        const double none = thresholds_.no_push * change.norm();
        held_.clear();
        for (Rough& each : rough_) {
            if (each.slides) continue;
            const double gains = change(each.tangents).norm();
            each.slides = gains > none && given_(each.tangents).norm() > (1.0 - thresholds_.slips) * each.most;
            if (each.slides)
                y(each.tangents) = 2.0 * rests_ / gains * change(each.tangents);
            else
                held_.insert(held_.end(), each.tangents.begin(), each.tangents.end());
        }
        if (!held_.empty()) {  // those that stick do not give way at all
            const Vector more = least_squares(B_(held_, held_), -(B_ * given_)(held_));
            given_(held_) += more;
        }
        return keep_piece(), true;
    }
    void keep_piece() { began_with_ = B_ * given_; }
    // Whether friction that sticks exceeds its cone.
    bool exceeds() const {
        return std::any_of(rough_.begin(), rough_.end(), [this](const Rough& each) {
            return !each.slides && given_(each.tangents).norm() > (1.0 + thresholds_.slips) * each.most;
        });
    }
    // The friction of stops at rest within their cones, at changes a without it.
    bool limited(const Vector& a, Vector& found) const {
        std::vector<Cone> cones;
        for (const Rough& each : rough_) {
            if (each.slides) continue;
            const auto first = std::find(held_.begin(), held_.end(), each.tangents[0]) - held_.begin();
            cones.push_back({-1, {}, each.most, {}});
            for (std::size_t k = 0; k < each.tangents.size(); ++k)
                cones.back().tangents.push_back(static_cast<int>(of(first) + k));
        }
        Vector rate;
        return coulomb_problem(B_(held_, held_), a, cones, thresholds_, found, rate);
    }

    // The impulses per dp at these rates. Sticking friction follows that of stops that turn while they slide.
    void give(const Vector& y) {
        bool turned = false;
        for (const Rough& each : rough_) {
            if (!each.slides) continue;
            const Vector now = -each.most / size(y, each) * y(each.tangents);
            turned = turned || (each.tangents.size() > 1 && now != given_(each.tangents));
            given_(each.tangents) = now;
        }
        if (!turned || held_.empty()) return;
        const Vector more = least_squares(B_(held_, held_), (began_with_ - B_ * given_)(held_));
        given_(held_) += more;
    }
    Vector slope(const Vector& y) {
        give(y);
        Vector found(3 * size_ + 1);
        const Vector rate = y.head(size_);
        found << B_ * given_, given_, rate.cwiseProduct(given_), 0.0;
        for (Index i = 0; i < stops_; ++i)
            found[3 * size_] += push_[i] * (rate[i] > 0.0 ? rate[i] : squares_[i] * rate[i]);
        return found;
    }

    // y after a step of size h, and an estimate of its error: Gragg's midpoint method with 2, 4, ... parts, extrapolated. A step
    // in which sliding reverses has an infinite error: it has passed the state of rest. So has one after which friction that
    // sticks exceeds its cone.
    Vector after(const Vector& y, double h, double& error) {
        constexpr int columns = 6;
        Vector found[columns];
        bool turns = false;
        const auto change = [&](const Vector& at) {
            for (const Rough& each : rough_)
                turns = turns || (each.slides && !(at(each.tangents).dot(y(each.tangents)) > 0.0));
            return slope(at);
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

    // Follows y to the goal, or to where sliding or sticking ends. False where neither comes.
    bool follow_piece(const Goal& goal, Vector& y, bool& arrived) {
        constexpr int most_steps =
            1000;  // where one stop slides by next to nothing beside others, its direction is stiff
        const double least = thresholds_.no_digits;
        double h = 0.1, error = 0.0;
        for (int step = 0; step < most_steps; ++step) {
            const Vector next = after(y, h, error);
            const bool slips = exceeds();
            if (!(error <= thresholds_.rounding * std::max(1.0, next.cwiseAbs().maxCoeff())) || (slips && h > least)) {
                h *= 0.5;
                continue;
            }
            if (goal(y) < 0.0 && goal(next) >= 0.0) return y = at_goal(goal, y, next, h), arrived = true;
            h *= 2.0, y = next;
            if (slips) return true;
            for (const Rough& each : rough_)
                if (each.slides && size(y, each) <= rests_) return true;
        }
        return false;
    }
    // The goal within a step from y to `end`, by the Illinois method, with halvings for a goal that is almost a square there.
    Vector at_goal(const Goal& goal, const Vector& y, const Vector& end, double h) {
        double low = 0.0, high = h, below = goal(y), above = goal(end), error = 0.0;
        Vector found = end;
        int side = 0;
        for (int tried = 0; tried < 150 && high - low > thresholds_.rounding * h && above != 0.0; ++tried) {
            const double chord = high - above * (high - low) / (above - below);
            const double middle = tried % 3 == 2 ? 0.5 * (low + high) : chord;
            const Vector there = after(y, middle, error);
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

    const DenseMatrix& B_;
    const Vector push_, squares_;
    const Thresholds& thresholds_;
    const Index size_, stops_;
    const double rests_;  // slower sliding rests; much more than the errors of a step, which turn it
    std::vector<Rough> rough_;
    Vector given_, began_with_;  // impulses per dp now, and B times those with which the piece began
    Rows held_;                  // the tangents that stick
};

}  // namespace

bool follow_impulse(const DenseMatrix& B, const Vector& u, const Vector& push, const Vector& restitution,
                    const Rubbing& rubbing, const std::vector<bool>& moves, const Thresholds& thresholds,
                    Vector& impulse, Vector& work) {
    const Index size = u.size(), stops = push.size();
    // Rows of one mobility along normals, so that angles and lengths compare, and a motion of size 1.
    Vector scale = Vector::Ones(size);
    for (Index i = 0; i < stops; ++i)
        if (B(i, i) > 0.0) scale[i] = 1.0 / std::sqrt(B(i, i));
    for (Index k = 0; k < rubbing.size(); ++k) scale[stops + k] = scale[rubbing.by[of(k)]];
    const DenseMatrix unit = scale.asDiagonal() * B * scale.asDiagonal();
    const double speed = u.cwiseProduct(scale).norm();
    const Vector wanted = push.cwiseQuotient(scale.head(stops)) / speed;
    Path path(unit, wanted, restitution, rubbing, moves, thresholds);
    Vector y = path.start(u.cwiseProduct(scale) / speed);
    if (!path.follow([&](const Vector& at) { return path.power(at); }, y)) return false;
    if ((restitution.array() > 0.0).any())  // the round-off of nothing that is to be given back would be a bounce
        path.follow([&](const Vector& at) { return path.given_back(at); }, y);
    impulse = y.segment(size, size).cwiseProduct(scale) * speed;
    work = y.segment(2 * size, size) * (speed * speed);
    return true;
}

}  // namespace mbproj
