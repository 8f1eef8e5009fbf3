// The time loop of four cases at once. Each lane has its own time, step and samples; one that comes to its end takes the next case.
// A lane that needs anything rare leaves: its case is run again by itself, from its start.
#pragma once

#include <chrono>

#include "ensembles/ensemble.hpp"
#include "ensembles/lanes.hpp"
#include "ensembles/packed_angles.hpp"
#include "ensembles/packed_projection.hpp"
#include "ensembles/packed_stages.hpp"
#include "stepping/flush_to_zero.hpp"

namespace mbproj {

template <class D> class PackedRuns final : public Ensemble {
public:
    using P = With<D, Pack>;
    using Vector = std::vector<Pack>;

    // The first of these cases fits.
    PackedRuns(std::vector<Case<D>> cases, const Tableau& tableau, const ProjectionSettings& projection)
        : cases_(std::move(cases)), model_(cases_.front().model), equations_(model_.model()),
          projection_(equations_, projection), angles_(equations_), stages_(tableau, equations_, model_.scale()),
          settings_(projection), y_(cases_.front().y.begin(), cases_.front().y.end()), y_new_(y_), slope_(y_), copy_(y_),
          copy_slope_(y_), lambda_(model_.model().all_multipliers()), copy_lambda_(lambda_), found_(cases_.size()) {}

    bool advance(double seconds) override {
        const FlushToZero flush;
        const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
        for (;;) {
            for (int made = 0; made < steps_between_looks; ++made) {
                fill_lanes();
                if (running_.none()) return true;
                Lanes::set(running_);
                step();
                running_ &= Lanes::in();
            }
            if (std::chrono::steady_clock::now() > until) return false;
        }
    }
    std::vector<std::optional<CaseRun>> take() override { return std::move(found_); }

private:
    static constexpr int steps_between_looks = 16;  // at the clock

    const Case<D>& case_of(const Lane& lane) const { return cases_[lane.number]; }
    const Steps& steps_of(int lane) const { return case_of(lanes_[lane]).steps; }
    template <class Visit> void each_lane(const Mask& those, Visit&& visit) {
        for (int k = 0; k < pack_width; ++k)
            if (those[k]) visit(k, lanes_[k]);
    }
    template <class Number> Pack of_lanes(Number&& number) const {
        Pack found;
        for (int k = 0; k < pack_width; ++k) found.set(k, number(k));
        return found;
    }

    // Lanes that are free take the next cases, as long as there are any.
    void fill_lanes() {
        for (;;) {
            Mask begins = false;
            for (int k = 0; k < pack_width; ++k) {
                if (running_[k]) continue;
                while (next_ < cases_.size() && !takes(cases_[next_])) ++next_;
                if (next_ == cases_.size()) break;
                load(k, next_++);
                begins.set(k, true);
            }
            if (begins.none()) return;
            Lanes::set(begins);
            begin();
            running_ |= Lanes::in();
        }
    }
    bool takes(const Case<D>& next) const {
        return next.steps.breaks.empty() && next.steps.fixed() == cases_.front().steps.fixed() &&
               model_.takes(next.model);
    }
    void load(int k, std::size_t number) {
        Lane& lane = lanes_[k];
        lane.number = number;
        const Case<D>& own = case_of(lane);
        model_.load(k, own.model);
        equations_.renew(k, own.model.rows.pivots);
        for (std::size_t i = 0; i < y_.size(); ++i) y_[i].set(k, own.y[i]);
        lane.schedule.emplace(own.steps);
        lane.control.emplace(stages_.error_order(), own.model.thresholds);
        lane.t = own.steps.start;
        lane.counters = {};
        lane.samples = {};
        angles_.set_turns(k, own.turns);
        for (PackedPeak* peak : {&position_, &velocity_}) peak->clear(k);
        here_.smallest.set(k, 1.0), here_.largest.set(k, 0.0);
    }

    // See TimeLoop::begin.
    void begin() {
        equations_.set_pose(y_.data());
        equations_.set_velocities(y_.data(), true);
        watch(of_lanes([&](int k) { return lanes_[k].t; }));
        angles_.start();
        stand(equations_.start());
        equations_.slope_at(y_.data(), slope_.data(), lambda_.data());
        take_over(stages_.first(), slope_);
        choose_steps();
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            ++lane.counters.evaluations;
            record(k, lane.t, y_, stages_.first(), lambda_, lane.h, angles_.values(k));
        });
    }
    void choose_steps() {
        if (cases_.front().steps.fixed())
            return each_lane(Lanes::in(), [&](int k, Lane& lane) { lane.h = steps_of(k).step; });
        Mask chosen = false;
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            lane.h = steps_of(k).first;
            chosen.set(k, !(lane.h > 0.0));
        });
        const OnlyLanes only(chosen);
        if (chosen.none()) return;
        const Pack longest = of_lanes([&](int k) { return chosen[k] ? lanes_[k].schedule->left(lanes_[k].t) : 1.0; });
        const Pack found = stages_.first_step(y_, tolerance(), longest);
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            ++lane.counters.evaluations;
            lane.h = std::max(found[k], lane.schedule->shortest(lane.t));
        });
    }
    Pack tolerance() const {
        return of_lanes([&](int k) { return steps_of(k).tolerance; });
    }

    // One attempt of each lane. See TimeLoop::step and StepTrial.
    void step() {
        const bool fixed = cases_.front().steps.fixed();
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            if (!fixed && !lane.schedule->resolves(lane.t, lane.h)) return Lanes::leave(k);
            lane.to = lane.schedule->target(lane.t, lane.h);
        });
        const Pack h = of_lanes([&](int k) { return lanes_[k].to.h; });
        stages_.attempt(y_, h, here_, y_new_);
        Pack error = 0.0;
        if (!fixed) error = stages_.error(y_, y_new_, h, tolerance());
        const Mask passes = fixed ? Mask(true) : Mask(error <= 1.0);
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            lane.counters.evaluations += stages_.attempt_cost() + (fixed ? 0 : 1);
            if (passes[k]) return;
            ++lane.counters.rejected_steps;
            lane.h = lane.control->after_rejected(error[k], lane.to.h);
        });
        const OnlyLanes only(passes);
        if (Lanes::in().none()) return;
        accept();
        look_inside(h);
        finish(fixed, error);
    }

    void accept() {
        const Thresholds& from = model_.model().thresholds;
        const PackedPassed& passed = stages_.passed();
        Lanes::keep(~((passed.smallest < from.passing) & (passed.smallest < from.nearing * passed.largest)));
        for (const Pack& number : y_new_) Lanes::keep(isfinite(number));
        bool due = false;
        Mask projects = false;
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            lane.schedule->enter(lane.to);
            ++lane.counters.evaluations;
            projects.set(k, projection_.is_due(++lane.counters.steps));
            due = due || lane.to.due;
        });
        const Pack t = of_lanes([&](int k) { return lanes_[k].to.t; });
        const Pack h = t - of_lanes([&](int k) { return lanes_[k].t; });
        const PackedProjected done = projection_.after_step(y_new_.data(), projects);
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            lane.counters.projections += projects[k] && (settings_.position || settings_.velocity);
            lane.counters.projection_iterations += done.position_passes.of[k];
            lane.counters.velocity_iterations += done.velocity_passes.of[k];
        });
        const Pack length = model_.model().length, way = done.speed_change * h;
        Lanes::keep(~((done.velocity_change > from.branch_change) & (way > from.at_rest * length)));
        Lanes::keep(~((done.velocity_change > from.lost_velocity) & (way > from.lost_way * length)));
        keep_closed();
        equations_.set_velocities(y_new_.data(), true);
        angles_.advance(h);
        watch(t);
        stand(equations_.start());
        equations_.slope_at(y_new_.data(), slope_.data(), due ? lambda_.data() : nullptr);
        for (const Pack& number : slope_) Lanes::keep(isfinite(number));
    }

    // Samples that lie inside the steps: see TimeLoop::sample_inside.
    void look_inside(const Pack& h) {
        const auto inside = [&] {
            Mask found = false;
            each_lane(Lanes::in(), [&](int k, Lane& lane) { found.set(k, lane.schedule->inside()); });
            return found;
        };
        Mask left = inside();
        if (left.none()) return;
        {
            const OnlyLanes only(left);
            each_lane(left, [&](int, Lane& lane) { lane.counters.evaluations += stages_.extend_cost(); });
            stages_.extend(y_, h);
        }
        for (left = inside(); left.any(); left = inside()) {
            const OnlyLanes only(left);
            Pack time = 0.0, theta = 0.5;
            each_lane(left, [&](int k, Lane& lane) {
                ++lane.counters.evaluations;
                time.set(k, lane.schedule->take());
                theta.set(k, (time[k] - lane.t) / lane.to.h);
            });
            stages_.at(y_, h, theta, copy_);
            projection_.anywhere(copy_.data());
            keep_closed();
            equations_.factor(Metric::mass);
            equations_.set_velocities(copy_.data(), false);
            equations_.slope_at(copy_.data(), copy_slope_.data(), copy_lambda_.data());
            each_lane(Lanes::in(), [&](int k, Lane& lane) {
                const double whole = lane.to.t - lane.t;
                record(k, time[k], copy_, copy_slope_, copy_lambda_, lane.to.h,
                       angles_.inside(k, (time[k] - lane.t) / whole, whole));
            });
        }
    }

    // The steps that were made are taken over.
    void finish(bool fixed, const Pack& error) {
        take_over(y_, y_new_);
        take_over(stages_.first(), slope_);
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            if (!fixed) lane.h = lane.control->after_accepted(error[k], lane.to.h);
            lane.t = lane.to.t;
            if (lane.to.due) record(k, lane.t, y_, stages_.first(), lambda_, lane.to.h, angles_.values(k));
            lane.schedule->reach(lane.to);
            if (lane.schedule->finished()) end(k, lane);
        });
    }
    void end(int k, Lane& lane) {
        lane.counters.factorisations = equations_.factorisations.of[k];
        found_[lane.number] = CaseRun{lane.t,
                                      lane.to.h,
                                      numbers_of(y_, k),
                                      angles_.turns(k),
                                      lane.counters,
                                      {position_.of(k), position_.of(k), velocity_.of(k)},
                                      std::move(lane.samples)};
        running_.set(k, false);
    }

    // Of the poses where the next steps begin.
    void stand(const Pack& nearness) {
        PackedPassed here;
        here.see(nearness);
        here_ = {where(Lanes::in(), here.smallest, here_.smallest), where(Lanes::in(), here.largest, here_.largest)};
    }
    // Lanes in which a joint is open by more than round-off leaves of it leave.
    void keep_closed() {
        const Pack* C = equations_.constraint();
        for (int r = 0; r < model_.model().constraints.rows; ++r)
            Lanes::keep(abs(C[r]) / model_.model().row_scale[r] <= model_.model().thresholds.lost_limit);
    }
    void watch(const Pack& t) {
        position_.watch(equations_.constraint(), model_.model().constraints.rows, t);
        velocity_.watch(equations_.C_dot(), model_.model().constraints.rows, t);
    }
    void record(int k, double t, const Vector& y, const Vector& slope, const Vector& lambda, double h,
                const std::vector<double>& angles) {
        lanes_[k].counters.factorisations = equations_.factorisations.of[k];
        lanes_[k].samples.template add<D>(t, vector_of(y, k), vector_of(slope, k), model_.model().size(),
                                          numbers_of(lambda, k), model_.model().constraints.rows, h, angles,
                                          lanes_[k].counters);
    }

    const std::vector<Case<D>> cases_;
    PackedModel<D> model_;
    PackedEquations<P> equations_;
    PackedProjection<P> projection_;
    PackedAngles<P> angles_;
    PackedStages<P> stages_;
    const ProjectionSettings& settings_;
    std::array<Lane, pack_width> lanes_;
    Mask running_ = false;
    std::size_t next_ = 0;
    Vector y_, y_new_, slope_, copy_, copy_slope_, lambda_, copy_lambda_;  // `copy_`: of samples inside steps
    PackedPassed here_;                                                   // the poses where steps begin
    PackedPeak position_, velocity_;
    std::vector<std::optional<CaseRun>> found_;
};

template <class D> std::unique_ptr<Ensemble>
ensemble_of(std::vector<Case<D>> cases, const Tableau& tableau, const ProjectionSettings& projection) {
    if (cases.empty() || !fits_packs(tableau) || !fits_packs(projection) || !fits_packs(cases.front().model))
        return nullptr;
    Lanes::set(true);  // what is decided of all lanes alike, by the first case
    return std::make_unique<PackedRuns<D>>(std::move(cases), tableau, projection);
}

}  // namespace mbproj
