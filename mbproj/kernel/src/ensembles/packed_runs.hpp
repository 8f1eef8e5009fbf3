// The time loop of several cases at once. Each lane has its own time, step and samples; one that comes to its end takes the
// next case. A lane that needs anything rare leaves: its case goes on by itself, from where the step began.
#pragma once

#include <chrono>

#include "ensembles/packed_parts.hpp"
#include "stepping/flush_to_zero.hpp"

namespace mbproj {

template <class D> class PackedRuns final : public Ensemble<D>, PackedParts<D> {
public:
    using Parts = PackedParts<D>;
    using typename Parts::Vector;

    // The first of these cases fits.
    PackedRuns(std::vector<Case<D>> cases, const Tableau& tableau, const ProjectionSettings& projection)
        : Parts(std::move(cases), tableau, projection), copy_(y_), copy_slope_(y_), copy_lambda_(lambda_) {}

    bool advance(double seconds) override {
        const FlushToZero flush;
        const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
        for (;;) {
            for (int made = 0; made < steps_between_looks; ++made) {
                fill_lanes();
                if (running_.none()) return true;
                Lanes::set(running_);
                this->note_begin();
                step();
                this->hand_over(running_ & ~Lanes::in());
                cross_breaks(crossing_ & running_);
            }
            if (std::chrono::steady_clock::now() > until) return false;
        }
    }
    std::vector<std::optional<CaseRun<D>>> take() override { return std::move(found_); }

private:
    static constexpr int steps_between_looks = 16;  // at the clock

    // Lanes that are free take the next cases, as long as there are any.
    void fill_lanes() {
        for (;;) {
            Mask begins = false;
            for (int k = 0; k < pack_width; ++k)
                if (!running_[k] && this->next() < cases_.size()) this->load(k), begins.set(k, true);
            if (begins.none()) return;
            Lanes::set(begins);
            begin();
            running_ |= Lanes::in();
            Mask after_break = false;
            each_lane(Lanes::in(), [&](int k, Lane& lane) { after_break.set(k, lane.schedule->is_after_break()); });
            cross_breaks(after_break);
        }
    }

    // See TimeLoop::begin. A lane that leaves here runs by itself from its start.
    void begin() {
        equations_.forget_teeth();
        const Pack t = this->times();
        equations_.set_pose(t, y_.data());
        equations_.set_velocities(y_.data(), true);
        this->watch(t);
        angles_.start(y_);
        equations_.set_pose(t, y_.data());
        equations_.start_teeth();
        this->stand(equations_.start());
        equations_.slope_at(y_.data(), slope_.data(), lambda_.data());
        take_over(stages_.first(), slope_);
        if (fixed_)
            each_lane(Lanes::in(), [&](int k, Lane& lane) { lane.h = this->steps_of(k).step; });
        else
            this->choose_steps();
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            ++lane.counters.evaluations;
            this->record(k, lane.t, y_, stages_.first(), lambda_, lane.h, angles_.values(k));
        });
        this->set_windows(Lanes::in());
    }

    // One attempt of each lane. See TimeLoop::step and StepTrial.
    void step() {
        crossing_ = false;
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            if (!fixed_ && !lane.schedule->resolves(lane.t, lane.h)) return Lanes::leave(k);
            lane.to = lane.schedule->target(lane.t, lane.h);
        });
        const Pack h = this->of_lanes([&](int k) { return lanes_[k].to.h; });
        const Pack end = this->of_lanes([&](int k) { return lanes_[k].to.t; });
        stages_.attempt(this->times(), y_, h, here_, y_new_);
        Pack error = 0.0;
        if (!fixed_) error = stages_.error(end, y_, y_new_, h, this->tolerance());
        const Mask passes = fixed_ ? Mask(true) : Mask(error <= 1.0);
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            lane.counters.evaluations += stages_.attempt_cost() + (fixed_ ? 0 : 1);
            if (passes[k]) return;
            ++lane.counters.rejected_steps;
            lane.h = lane.control->after_rejected(error[k], lane.to.h);
        });
        const OnlyLanes only(passes);
        if (Lanes::in().none()) return;
        const auto set_windows_of_samples = [&](bool breaks_too) {  // samples at a break belong to that time itself
            each_lane(Lanes::in(), [&](int k, Lane& lane) {
                if (lane.to.at_break) equations_.set_window(k, breaks_too ? lane.schedule->window() : TimeWindow{});
            });
        };
        set_windows_of_samples(false);
        accept(end);
        set_windows_of_samples(true);
        sample_inside(h);
        finish(error);
    }

    void accept(const Pack& t) {
        const Thresholds& from = model_.thresholds;
        const PackedPassed& passed = stages_.passed();
        Lanes::keep(~((passed.smallest < from.passing) & (passed.smallest < from.nearing * passed.largest)));
        keep_finite(y_new_);
        bool due = false;
        Mask projects = false;
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            lane.schedule->enter(lane.to);
            ++lane.counters.evaluations;
            projects.set(k, projection_.is_due(++lane.counters.steps));
            due = due || lane.to.due;
        });
        const Pack h = t - this->times();
        angles_.lead(equations_, t, y_new_);
        const PackedProjected done = projection_.after_step(t, y_new_.data(), projects);
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            lane.counters.projections += projects[k] && (settings_.position || settings_.velocity);
            lane.counters.projection_iterations += done.position_passes.of[k];
            lane.counters.velocity_iterations += done.velocity_passes.of[k];
        });
        const Pack length = model_.length, way = done.speed_change * h;
        Lanes::keep(~((done.velocity_change > from.branch_change) & (way > from.at_rest * length)));
        Lanes::keep(~((done.velocity_change > from.lost_velocity) & (way > from.lost_way * length)));
        this->keep_closed();
        equations_.set_velocities(y_new_.data(), true);
        angles_.advance(h, y_, y_new_);
        this->watch(t);
        this->stand(equations_.start());
        equations_.slope_at(y_new_.data(), slope_.data(), due ? lambda_.data() : nullptr);
        keep_finite(slope_);
    }

    // Samples that lie inside the steps: see TimeLoop::sample_inside.
    void sample_inside(const Pack& h) {
        const auto inside = [&] {
            Mask found = false;
            each_lane(Lanes::in(), [&](int k, Lane& lane) { found.set(k, lane.schedule->inside()); });
            return found;
        };
        Mask left = inside();
        if (left.none()) return;
        const Pack t = this->times();
        {
            const OnlyLanes only(left);
            each_lane(left, [&](int, Lane& lane) { lane.counters.evaluations += stages_.extend_cost(); });
            stages_.extend(t, y_, h);
        }
        for (left = inside(); left.any(); left = inside()) {
            const OnlyLanes only(left);
            Pack time = t, theta = 0.5;
            each_lane(left, [&](int k, Lane& lane) {
                ++lane.counters.evaluations;
                time.set(k, lane.schedule->take());
                theta.set(k, (time[k] - lane.t) / lane.to.h);
            });
            stages_.at(y_, h, theta, copy_);
            angles_.lead(equations_, time, copy_);
            projection_.anywhere(time, copy_.data());
            this->keep_closed();
            equations_.factor(Metric::mass);
            equations_.set_velocities(copy_.data(), false);
            equations_.slope_at(copy_.data(), copy_slope_.data(), copy_lambda_.data());
            each_lane(Lanes::in(), [&](int k, Lane& lane) {
                const double whole = lane.to.t - lane.t;
                this->record(k, time[k], copy_, copy_slope_, copy_lambda_, lane.to.h,
                             angles_.inside(k, (time[k] - lane.t) / whole, whole, copy_));
            });
        }
    }

    // Takes over the steps that were made.
    void finish(const Pack& error) {
        take_over(y_, y_new_);
        take_over(stages_.first(), slope_);
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            if (!fixed_) lane.h = lane.control->after_accepted(error[k], lane.to.h);
            lane.t = lane.to.t;
            if (lane.to.due) this->record(k, lane.t, y_, stages_.first(), lambda_, lane.to.h, angles_.values(k));
            lane.schedule->reach(lane.to);
            if (lane.schedule->finished()) return this->end(k, lane);
            crossing_.set(k, lane.to.at_break);
        });
    }

    // From here on functions of time are evaluated after the break: see TimeLoop::cross_break. The case of a lane that
    // leaves here runs by itself from its start.
    void cross_breaks(const Mask& those) {
        if (those.none()) return;
        Lanes::set(those);
        each_lane(those, [&](int, Lane& lane) {
            lane.schedule->pass_break(lane.t);
            ++lane.counters.evaluations;
        });
        this->set_windows(those);
        equations_.set_pose(this->times(), y_.data());
        equations_.factor(Metric::mass);
        equations_.set_velocities(y_.data(), false);
        equations_.slope_at(y_.data(), slope_.data());
        take_over(stages_.first(), slope_);
        if (!fixed_) {
            each_lane(those, [&](int, Lane& lane) { lane.control->forget(); });
            this->choose_steps();
        }
        running_ &= Lanes::in() | ~those;
    }

    using Parts::fixed_, Parts::lanes_, Parts::running_, Parts::cases_, Parts::y_, Parts::y_new_, Parts::slope_;
    using Parts::lambda_, Parts::here_, Parts::found_, Parts::each_lane, Parts::keep_finite;
    using Parts::model_, Parts::equations_, Parts::projection_, Parts::angles_, Parts::stages_, Parts::settings_;
    Mask crossing_ = false;                   // breaks at which the steps that were just made end
    Vector copy_, copy_slope_, copy_lambda_;  // of samples inside steps
};

template <class D> std::unique_ptr<Ensemble<D>> ensemble_of(std::vector<Case<D>> cases, const Tableau& tableau,
                                                            const ProjectionSettings& projection) {
    if (cases.empty() || !fits_packs(tableau) || !fits_packs(projection) || !fits_packs(cases.front().model))
        return nullptr;
    Lanes::set(true);  // for decisions by the first case, alike for all lanes
    return std::make_unique<PackedRuns<D>>(std::move(cases), tableau, projection);
}

}  // namespace mbproj
