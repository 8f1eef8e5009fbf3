// Finds the size of the step that ends at a meeting. It makes steps of other sizes, so that the time has the order of
// the method.
#pragma once

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "contact/gap_cubic.hpp"

namespace mbproj {

// A step of size h ends where margin number `which` is met, or -1 where none is after all. Not `made` where a step on
// the way could not be made. `slope`: the derivative of this margin by h, where it is known.
struct Meeting {
    double h = 0.0;
    int which = -1;
    bool made = true;
    double slope = std::numeric_limits<double>::quiet_NaN();
};

// Searches margins after steps of some size. They are not negative before a meeting, and are compared in parts of their
// `slack`, by which they may be below zero; below the part `zero` of it they are met.
class MeetingSearch {
public:
    using Margins = std::vector<ValueAndRate>;

    MeetingSearch(std::vector<double> slack, double zero, double near_miss)
        : slack_(std::move(slack)), zero_(zero), near_miss_(near_miss) {}

    // The first meeting in a step of size h, with margins `first` and `last` at its ends. at(h, margins) makes another
    // step; false where it fails. Newton's method from what is `expected` mostly gets there; else `parts` of the step,
    // ascending, are looked at first.
    template <class At> Meeting first(const At& at, const Margins& first, const Margins& last,
                                      const std::vector<double>& parts, double h, double grain,
                                      const Meeting& expected = {}) {
        Margins below = last;
        const bool gap = expected.which >= 0 && std::isfinite(last[expected.which].rate);
        double guess = expected.h + (gap ? 0.0 : 0.5 * grain), high = -1.0;
        for (int tried = 0; tried < most_polished && expected.which >= 0 && guess > grain && guess < h; ++tried) {
            if (!at(guess, below)) return failed();
            if (worst(below) != expected.which) break;
            const ValueAndRate& met = below[expected.which];
            if (is_met(met, expected.slope, expected.which, grain)) return {guess, expected.which};
            const double change = -met.value / (gap ? met.rate : expected.slope);
            guess += change + (gap && std::abs(change) > grain ? 0.0 : 0.5 * grain);  // rather below zero
        }
        if (!look(at, last, parts, h, grain, below, high)) return failed();
        if (high < 0.0 && !is_below(last)) return {h, -1};
        if (high < 0.0) high = h, below = last;
        int which = worst(below);
        guess = high * (std::isfinite(first[which].rate) ? GapCubic(first[which], below[which], high).last_fall()
                        : first[which].value > 0.0 ? first[which].value / (first[which].value - below[which].value)
                                                   : 0.5);
        double low = 0.0;
        Margins above = first;
        if (!(first[which].value > slack_[which])) {
            low = guess;
            while (true) {
                // A gap that begins closed and falls is met at once. One that rests may open first: its forces decide.
                if (!(low > grain) || first[which].rate * low < -slack_[which]) return {0.0, which};
                low *= 0.5;
                if (!at(low, above)) return failed();
                if (is_below(above)) {
                    high = low, below = above;
                    which = worst(above);
                    if (!(first[which].value > slack_[which])) continue;
                    low = 0.0, above = first;
                    break;
                } else if (above[which].value > 0.0) {
                    break;
                }
            }
        }
        return root(at, low, above, high, below, guess, which, grain);
    }

private:
    static constexpr int most_tries = 80, most_polished = 4;
    static constexpr double nearby = 0.1, least_nearby = 0.005;  // parts of a step
    static Meeting failed() { return {0.0, -1, false}; }

    // Makes steps to `parts` of the whole one until a margin is below its bound, at the size `high`; else, where the
    // least of them is small beside that at the end, to places nearby: looks that are off beside a swing have seen a
    // force pass its bound where it does not. False where a step fails.
    template <class At> bool look(const At& at, const Margins& last, const std::vector<double>& parts, double h,
                                  double grain, Margins& below, double& high) {
        double lowest = std::numeric_limits<double>::infinity(), least_at = h;
        const auto look_at = [&](double size) {
            if (high >= 0.0 || !(size > grain && size < h)) return true;
            if (!at(size, below)) return false;
            const int which = worst(below);
            if (const double value = below[which].value / slack_[which]; value < lowest)
                lowest = value, least_at = size;
            if (is_below(below)) high = size;
            return true;
        };
        for (const double part : parts)
            if (!look_at(part * h)) return false;
        const int end = worst(last);
        for (double part = nearby; lowest < near_miss_ * last[end].value / slack_[end] && part > least_nearby;
             part *= 0.5)
            if (const double middle = least_at; !look_at(middle - part * h) || !look_at(middle + part * h))
                return false;
        return true;
    }

    // Whether a margin is zero, or would be within what time resolves: `slope` is its rate where it has none. It is not above
    // zero then, but for a gap, which counts as closed.
    bool is_met(const ValueAndRate& margin, double slope, int which, double grain) const {
        const bool gap = std::isfinite(margin.rate);
        const double off = std::abs(margin.value), slack = slack_[which], rate = gap ? margin.rate : slope;
        return off <= zero_ * slack || (margin.value <= (gap ? 0.5 * slack : 0.0) && off <= grain * std::abs(rate));
    }
    bool is_below(const Margins& margins) const;
    int worst(const Margins& margins) const;

    // The size at which the least margin crosses zero, between sizes where it is above and below: Newton's method where
    // it has a rate, else a parabola through three of its values (Chandrupatla 1997). The root stays between both ends,
    // and no guess is nearer to an end than half a grain: once one end is at the root, the other soon is.
    template <class At> Meeting root(const At& at, double low, Margins above, double high, const Margins& below,
                                     double guess, int which, double grain) {
        double y_low = above[which].value, y_high = below[which].value, old = high, y_old = y_high, wide = high - low;
        Margins there;
        for (int tried = 0; tried < most_tries && high - low > grain; ++tried) {
            if (!(low < guess && guess < high)) guess = between(low, y_low, high, y_high, old, y_old);
            if (tried % 6 == 5 && high - low > 0.5 * std::exchange(wide, high - low)) guess = 0.5 * (low + high);
            guess = std::clamp(guess, low + 0.5 * grain, high - 0.5 * grain);
            if (!at(guess, there)) return failed();
            if (const int other = worst(there); other != which && there[other].value < -slack_[other]) {
                which = other;
                y_low = y_old = above[which].value, old = low;
            }
            const double value = there[which].value;
            if (is_met(there[which], std::nan(""), which, grain)) return {guess, which};
            double &end = value > 0.0 ? low : high, &y_end = value > 0.0 ? y_low : y_high;
            old = std::exchange(end, guess), y_old = std::exchange(y_end, value);
            if (value > 0.0) above = there;
            guess -= value / there[which].rate;
        }
        return {high, which};
    }

    // The zero of the parabola x(y) through three points, if it is between the ends; else the zero of the line.
    static double between(double low, double y_low, double high, double y_high, double old, double y_old);

    const std::vector<double> slack_;
    const double zero_, near_miss_;
};

}  // namespace mbproj
