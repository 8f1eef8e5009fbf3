// Looks for the end of contacts and frictions within a step: gaps that close, or that open again, contacts that would
// pull, sliding that comes to rest, friction that holds no longer. Such a step is made again, to there
// (step/contact_events.cpp); the contact policy decides what happens then.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "contact/gap_cubic.hpp"
#include "solver/equations.hpp"

namespace mbproj {

// A condition that ends a step: sign (s - bound) below -slack, s one of the stops' coordinates. Or, `of_rate`, sign s',
// plus another rate with its sign, plus `idle`, below -slack. A rate within the slack over a step of at least
// `rests_over`, s, is at rest, which ends a step, too. `begins`: a friction at rest begins to slide.
struct WatchedGap {
    int stop;
    double sign, slack;
    bool of_rate;
    int other;
    double other_sign, rests_over = std::numeric_limits<double>::infinity(), idle = 0.0;
    bool begins = false;

    // The value or the rate below which the condition is met.
    double least() const { return of_rate ? -slack - idle : -slack; }
};

// A condition that ends a step: bound + part · load + sign λ below -slack, λ the multiplier of a row. The load is that
// of a bearing, or 0 for -1, or the multiplier `by`. With another row, -|λ| of both replaces sign λ. The value of a
// program, if any, multiplies bound and part.
struct WatchedRow {
    int row;
    double sign, slack, bound, part;
    int bearing, other, program = -1, by = -1;
};

// A step as the cubic through both ends with their slopes.
struct CubicStep {
    double h;
    const Eigen::VectorXd &y, &slope, &y_new, &slope_new;

    // The state at the part x of the step.
    void at(double x, Eigen::VectorXd& inside) const {
        const double a = x * x * (3.0 - 2.0 * x);
        inside = (1.0 - a) * y + a * y_new + h * x * (1.0 - x) * ((1.0 - x) * slope - x * slope_new);
    }
};

class StopWatch {
public:
    explicit StopWatch(Equations& equations)
        : equations_(equations), model_(equations.mechanism()), stops_(model_.stops), inside_(model_.layout.size()) {}

    // Sets what is watched. Forces are evaluated at least every `spacing` seconds, and inside each step.
    void watch(std::vector<WatchedGap> gaps, std::vector<WatchedRow> rows, double spacing);
    bool any() const { return !gaps_.empty() || !rows_.empty(); }

    // The longest step, at most h, from y with this slope, in which sliding in a plane changes by no more than a part
    // of its speed. At rest its direction changes at once, which no step may pass unseen.
    double longest(const Eigen::VectorXd& y, const Eigen::VectorXd& slope, double h);

    // Looks at the start of a run, with whole turns of the joints' coordinates.
    void begin(const std::vector<long>& turns) { set_gaps(turns, false, before_); }

    // Whether a step has met something, with the multipliers at its end. `parts`: the parts of the step at which
    // something may be met before its end.
    bool met(const CubicStep& step, const std::vector<long>& turns, const std::vector<double>& lambda);
    // The coordinate that has been at rest over the last step, of size h; -1 for none.
    int rests(double h) const;
    // The next step begins at the end of the last.
    void pass() { before_.swap(now_); }
    const std::vector<double>& parts() const { return parts_; }

    // The watched values at a state: gaps, then forces, without rates. `slacks`: how far each may be below zero.
    void margins(const std::vector<long>& turns, const std::vector<double>& lambda,
                 std::vector<ValueAndRate>& found) const;
    // The watched values at the start of the last step, where forces are not known.
    std::vector<ValueAndRate> first_margins() const;
    std::vector<double> slacks() const;
    const std::vector<WatchedGap>& gaps() const { return gaps_; }
    const std::vector<WatchedRow>& rows() const { return rows_; }

    // Whether a force is beyond its bound within a step of size h, with multipliers `last` at its end; solve(part, λ) computes
    // those inside it. A body at rest has long steps by error control, so that a force `swings` within one.
    template <class Solve>
    bool gives_way_inside(double h, bool swings, const std::vector<double>& last, const Solve& solve) {
        if (rows_.empty()) return false;
        std::vector<double> lambda(last.size());
        const auto look = [&](double x) { return solve(x, lambda) ? forces(lambda) : std::vector<double>{}; };
        const int spans = std::max(1, static_cast<int>(std::min(std::ceil(h / spacing_), 1e6)));
        const std::vector<double> end = forces(last);
        std::vector<double> from = swings ? look(0.0) : std::vector<double>{}, to;
        for (int at = 1; at <= spans; ++at, from = to) {
            const double x_to = static_cast<double>(at) / spans;
            to = at < spans ? look(x_to) : end;
            if (gives_way_between(from, to, x_to - 1.0 / spans, x_to, model_.thresholds.most_halves, look) ||
                (at < spans && gives_way_at(x_to, to)))
                return note_lower(0.125 / spans, look), true;
        }
        return false;
    }

private:
    // The margin of a watched rate is the rate itself, whose derivative is not known.
    void only_rates(std::vector<ValueAndRate>& found) const;
    bool is_below(const std::vector<ValueAndRate>& at) const;
    bool gives_way(const std::vector<double>& lambda) const;
    double force(const WatchedRow& each, const std::vector<double>& lambda) const;

    // The margins of the watched forces at a state.
    std::vector<double> forces(const std::vector<double>& lambda) const;
    // Whether one of them is below its bound at the part x of a step, which is noted.
    bool gives_way_at(double x, const std::vector<double>& margins);
    // Whether a force may pass its bound between the ends of a span, as its bend there tells.
    bool may_give_way(const std::vector<double>& from, const std::vector<double>& inside,
                      const std::vector<double>& to) const;
    // Looks inside a span, and in its parts where a force may pass its bound. The golden section meets a swing at another of
    // its phases than the ends.
    template <class Look> bool gives_way_between(const std::vector<double>& from, const std::vector<double>& to,
                                                 double x, double x_to, int halves, const Look& look) {
        const double middle = x + golden * (x_to - x);
        const std::vector<double> inside = look(middle);
        if (gives_way_at(middle, inside)) {
            if (halves > 0) gives_way_between(from, inside, x, middle, halves - 1, look);  // it may have before, too
            return true;
        }
        return halves > 0 && !from.empty() &&
               (halves == model_.thresholds.most_halves || may_give_way(from, inside, to)) &&
               (gives_way_between(from, inside, x, middle, halves - 1, look) ||
                gives_way_between(inside, to, middle, x_to, halves - 1, look));
    }
    // Notes where a force that is below its bound is lower than where that was first seen: there a step finds it even
    // where looks at the extension are off.
    template <class Look> void note_lower(double d, const Look& look) {
        const double first = parts_.back();
        double x = first, lowest = worst(look(x));
        for (double next = x + d; next < 1.0; d *= 2.0, next += d) {
            const double below = worst(look(next));
            if (!(below < lowest)) break;
            x = next, lowest = below;
        }
        if (x > first) parts_.push_back(x);
    }
    // The least margin over its bound; infinity where the forces are not known.
    double worst(const std::vector<double>& margins) const;
    static constexpr double golden = 0.6180339887498949;

    // Whether something falls below its bound on the cubics through two looks, at the parts x and x_to of a step, h apart.
    bool below(const std::vector<ValueAndRate>& from, const std::vector<ValueAndRate>& to, double h, double x,
               double x_to);

    // Whether a gap closes and opens again between two looks at the parts x and x_to of a step, which its cubic may not
    // show. Where the middle is not on the cubic, looks at each half, at most `halves` times.
    bool closes_inside(const CubicStep& step, const std::vector<long>& turns, const std::vector<ValueAndRate>& from,
                       const std::vector<ValueAndRate>& to, double x, double x_to, int halves);

    // At the state in place, or at the one seen beside it.
    void set_gaps(const std::vector<long>& turns, bool beside, std::vector<ValueAndRate>& found) const;

    Equations& equations_;
    const Mechanism& model_;
    const Stops& stops_;
    std::vector<WatchedGap> gaps_;
    std::vector<WatchedRow> rows_;
    double spacing_ = 1.0;
    std::vector<ValueAndRate> before_, now_;
    std::vector<double> parts_;
    Eigen::VectorXd inside_;
};

}  // namespace mbproj
