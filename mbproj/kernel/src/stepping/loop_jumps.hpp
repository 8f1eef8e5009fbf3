// Instantaneous changes: of functions of time at a break, of a law's branch, of contacts. Slopes are evaluated anew.
#pragma once

#include "stepping/loop_parts.hpp"

namespace mbproj {

template <class D> class LoopJumps : public LoopParts<D> {
protected:
    using Parts = LoopParts<D>;
    using Parts::Parts;

    [[gnu::noinline, gnu::cold]] bool meet_stop() {
        return change_contacts([this] { return stops_.meet(counted_.turns); });
    }
    // Velocities may jump, and with them branches of forces. False where the run stops, also where nothing can be decided.
    template <class Change> bool change_contacts(const Change& change) {
        bool met = true;
        if (!stepper_.before_jump(now_.t, now_.y)) return stop_at(now_.t), false;
        const bool goes_on = jump([&] { met = change(); });
        if (!met) stop({Status::undecided, now_.t});
        if (!met || !goes_on) return false;
        stops_.set_start(now_.t, now_.y, counted_.turns);
        turns_.take_speeds(counted_);
        go_on();
        return true;
    }

    void cross_break() {  // from here on functions of time are evaluated after the break
        if (is_asked()) return;
        equations_.set_window({});  // as in the current slope
        if (!stepper_.before_jump(now_.t, now_.y)) return stop_at(now_.t);
        equations_.set_window(schedule_.window());
        const bool goes_on = jump([this] {
            schedule_.pass_break(now_.t);
            equations_.set_window(schedule_.window());
            this->act();
        });
        if (goes_on) acted_ ? go_on() : stop_at(now_.t);
    }
    // Makes an instantaneous change: switches whose arguments jump with it take the branch at the new argument.
    template <class Change> bool jump(const Change& change) {
        if (trial_.locates()) events().before_jump(now_.t, now_.y, schedule_.window());
        change();
        if (trial_.locates()) events().after_jump(now_.t, now_.y, schedule_.window());
        return renew() && (!trial_.locates() || !events().any_free() || change_branches([this] { events().turn(); }));
    }

    // Changes the branch of a switch at its crossing. False where the run stops.
    bool cross_event() {
        const Crossing crossing = *trial_.crossing();
        trial_.crossing().reset();
        int often = -1;
        const bool passes = change_branches(
            [&] { often = events().cross(crossing, now_.t, schedule_.grain(now_.t), steps_.interval()); });
        if (often >= 0) return stop(Outcome::pushed_back(now_.t, often)), false;
        return passes;
    }

    template <class Change> bool change_branches(const Change& change) {  // false where the motion leads back
        events().glance_before(now_.t, now_.y, stepper_.first(), now_.h, schedule_.window());
        if (!stepper_.before_jump(now_.t, now_.y)) return stop_at(now_.t), false;
        change();
        do {
            if (!renew()) return false;
            events().glance_after(now_.t, now_.y, stepper_.first(), now_.h, schedule_.window());
        } while (events().passes_over_back(now_.t));
        return events().pushed_back() < 0 || (stop(Outcome::pushed_back(now_.t, events().pushed_back())), false);
    }

    bool renew() {  // the slope at the state, and a new balance
        begin_balance();
        ++now_.counters.evaluations;
        return stepper_.after_jump(now_.t, now_.y, stepper_.first(), nullptr) || (stop_at(now_.t), false);
    }

    using Parts::begin_balance, Parts::steps_, Parts::equations_, Parts::stepper_, Parts::schedule_, Parts::now_;
    using Parts::counted_, Parts::stops_, Parts::is_asked, Parts::acted_, Parts::stop, Parts::stop_at, Parts::events;
    using Parts::trial_, Parts::turns_, Parts::go_on;
};

}  // namespace mbproj
