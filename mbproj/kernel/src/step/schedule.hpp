// When steps end and samples are due: on the grid of fixed steps, or where error control takes them; and at breaks.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "model/settings.hpp"
#include "step/step_size_control.hpp"
#include "step/stepper.hpp"

namespace mbproj {

// The end and the size of a step; whether it ends on the grid, a sample is due there, and it ends at a break; and
// whether the run's end has limited it: a longer run might make another step.
struct Target {
    double t, h;
    bool on_grid, due, at_break, shaped;
};

// A fixed step whose equations are not solved is made in halves, and these in halves again. The parts of a step are numbered as
// the nodes of a binary tree: 1 is the whole, 2n and 2n + 1 are the halves of n.
struct StepParts {
    long at = 1;  // the current part

    // Whether it ends where the whole does.
    bool is_last() const { return (at & (at + 1)) == 0; }
    // Where it ends, as a part of the whole.
    double end() const {
        long count = 1;
        while (2 * count <= at) count *= 2;
        return (static_cast<double>(at - count) + 1.0) / static_cast<double>(count);
    }
    // Whether it was halved less than so many times.
    bool below(int halvings) const { return at < 1L << halvings; }
    void halve() { at *= 2; }
    // The current part is made: the next one is as long as the halves allow that are made.
    void go_on() {
        while (at > 1 && at % 2 == 1) at /= 2;
        if (at > 1) ++at;
    }
};

// Fixed steps whose equations Newton's method has not solved, by their cause: the same body's accelerations, or the
// same force. How many they are, and where the first one starts, s.
struct Halved {
    Unsolved cause;
    double first;
    long times;
};

// Notes one more that starts at t.
void note_halved(std::vector<Halved>& halved, const Unsolved& cause, double t);

// Where a run with fixed steps is: the steps of the grid that are made, and the part of the next.
struct Grid {
    long steps = 0;
    StepParts part;
};

class Schedule {
public:
    Schedule(const Steps& steps, Grid& grid);
    // A run goes on at t, where the grid says: the samples up to t are made.
    void resume(double t);
    // Whether the run waits for values from outside, before it passes the breaks up to t or goes on from these.
    bool asks(double t) const;
    // Calls the actions of controllers, in their order, at passed breaks where they have not acted yet.
    template <class Act> bool act(const Act& act) {
        for (; acted_ < passed_; ++acted_)
            for (const int action : steps_.breaks[acted_].actions)
                if (!act(action)) return false;
        return true;
    }
    // The end of the next step from t; with error control its size is at most h.
    Target target(double t, double h) const {
        return steps_.fixed() ? part_of(on_grid(t), t) : follows() ? along(t) : within(t, h);
    }
    // With error control: steps end where those of another run did, whatever their error. The last ends the run. False
    // where they do not fit.
    bool follow(std::vector<double> ends);
    bool follows() const { return !followed_.empty(); }
    // Whether to record where steps end, for another run that follows them.
    bool keeps_ends = false;
    const std::vector<double>& ends() const { return ends_; }
    // Divides a fixed step of size h from t into halves. False where they would be too short.
    bool halve(double t, double h, int most);
    // A step from t to a time within, with error control.
    Target to(double t, double time) const;
    // The resolution of times near t, and on the way to the next sample.
    double grain(double t) const {
        return std::numeric_limits<double>::epsilon() * std::max(std::abs(t), steps_.interval());
    }
    // The step to a target is taken.
    void reach(const Target& target);
    bool finished() const {
        return steps_.fixed() ? grid_.steps == steps_.count : next_sample_ == steps_.samples.count;
    }

    // Samples that lie inside a step, one by one.
    void enter(const Target& target) { inside_ = std::max(next_sample_, first_from(target.t)); }
    bool inside() const { return next_sample_ < inside_; }
    double take() { return steps_.sample(next_sample_++); }

    // Whether time resolves a step of size h: `shortest` is the shortest.
    bool resolves(double t, double h) const { return !(h < shortest(t)); }
    double shortest(double t) const { return 16.0 * grain(t); }

    // Passes the breaks up to t.
    void pass_break(double t) {
        while (next_break() <= t + beside(t)) ++passed_;
    }
    // Whether the run's end is where steps must end next.
    bool is_before_end() const { return !(next_break() < steps_.end()); }
    // The time from t to the next break or the end of the run.
    double left(double t) const { return std::min(next_break(), steps_.end()) - t; }
    bool is_after_break() const { return passed_ > 0; }
    TimeWindow window() const;

private:
    double beside(double t) const { return 16.0 * grain(t); }
    double next_break() const {
        return passed_ < steps_.breaks.size() ? steps_.breaks[passed_].time : std::numeric_limits<double>::infinity();
    }

    // The time of step k is t0 + k h, so that it does not drift. The last may be shorter; one with a break in it is split.
    Target on_grid(double t) const;

    // The current part of a fixed step, from t on.
    Target part_of(const Target& whole, double t) const;

    // At most h, and no farther than to the next break or the end.
    Target within(double t, double h) const;

    // To the next end of a step of the run that is followed, or to a break before it.
    Target along(double t) const;

    // The first sample that is not before t.
    std::size_t first_from(double t) const;
    // The first of all samples that is after t.
    std::size_t first_after(double t) const;
    bool is_due(std::size_t sample, double t) const {
        return sample < steps_.samples.count && steps_.sample(sample) == t;
    }

    const Steps& steps_;
    Grid& grid_;
    std::size_t next_sample_ = 0, inside_ = 0;  // samples up to `inside_` lie in the step that was just accepted
    std::size_t passed_ = 0, acted_ = 0;        // breaks
    std::vector<double> followed_, ends_;       // ends of steps: of another run, and its own
};

}  // namespace mbproj
