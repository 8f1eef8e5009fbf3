// The parts of the time loop of several cases: how a case enters a lane, leaves it, and comes to its end there.
#pragma once

#include "ensembles/ensemble.hpp"
#include "ensembles/lanes.hpp"
#include "ensembles/packed_angles.hpp"
#include "ensembles/packed_projection.hpp"
#include "ensembles/packed_stages.hpp"

namespace mbproj {

template <class D> class PackedParts {
public:
    using P = With<D, Pack>;
    using Vector = std::vector<Pack>;

    PackedParts(const PackedParts&) = delete;
    PackedParts& operator=(const PackedParts&) = delete;

protected:
    // The first of these cases fits.
    PackedParts(std::vector<Case<D>> cases, const Tableau& tableau, const ProjectionSettings& projection)
        : cases_(std::move(cases)), packed_(cases_.front().model), model_(packed_.model()), equations_(model_),
          projection_(equations_, projection), angles_(equations_), stages_(tableau, equations_, packed_.scale()),
          settings_(projection), fixed_(cases_.front().steps.fixed()),
          y_(cases_.front().y.begin(), cases_.front().y.end()), y_new_(y_), slope_(y_),
          lambda_(model_.all_multipliers()), found_(cases_.size()) {}
    ~PackedParts() = default;

    const Steps& steps_of(int lane) const { return cases_[lanes_[lane].number].steps; }
    template <class Visit> void each_lane(const Mask& those, Visit&& visit) {
        for (int k = 0; k < pack_width; ++k)
            if (those[k]) visit(k, lanes_[k]);
    }
    template <class Number> Pack of_lanes(Number&& number) const {
        Pack found;
        for (int k = 0; k < pack_width; ++k) found.set(k, number(k));
        return found;
    }
    Pack times() const {
        return of_lanes([&](int k) { return lanes_[k].t; });
    }

    // The number of the next case that packs compute, or the number of cases.
    std::size_t next() {
        const auto takes = [&](const Case<D>& next) {
            const auto acts = [](const Break& each) { return each.asks || !each.actions.empty(); };
            return std::none_of(next.steps.breaks.begin(), next.steps.breaks.end(), acts) &&
                   next.steps.fixed() == fixed_ && packed_.takes(next.model);
        };
        while (next_ < cases_.size() && !takes(cases_[next_])) ++next_;
        return next_;
    }
    // A lane takes the next case.
    void load(int k) {
        Lane& lane = lanes_[k];
        lane.number = next_++;
        const Case<D>& own = cases_[lane.number];
        packed_.load(k, own.model);
        equations_.renew(k, own.model.rows.pivots);
        for (std::size_t i = 0; i < y_.size(); ++i) y_[i].set(k, own.y[i]);
        lane.schedule.emplace(own.steps);
        lane.control.emplace(stages_.error_order(), own.model.thresholds);
        lane.t = own.steps.start;
        lane.counters = {}, lane.samples = {};
        angles_.set_turns(k, own.turns);
        peaks_.clear(k);
        here_.smallest.set(k, 1.0), here_.largest.set(k, 0.0);
    }

    // Records where the lanes begin a step.
    void note_begin() {
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            lane.counters.factorisations = equations_.factorisations.of[k];
            lane.begin = {lane.h, lane.control->save(), lane.counters, lane.samples.t.size()};
        });
        angles_.begin();
        peaks_before_ = peaks_;
    }
    // Frees lanes that have left in the current step; their cases go on by themselves from its start.
    void hand_over(const Mask& left) {
        each_lane(left, [&](int k, Lane& lane) {
            lane.samples.shorten(lane.begin.samples);
            Mark<D> mark;
            mark.t = lane.t, mark.h = lane.begin.h, mark.y = vector_of(y_, k);
            mark.grid = lane.schedule->grid(), mark.part = lane.schedule->parts().at();
            angles_.write_begin(k, mark.counted);
            mark.control = lane.begin.control, mark.counters = lane.begin.counters;
            mark.peaks = peaks_before_.of(k, static_cast<int>(model_.driven.size()));
            found_[lane.number] = CaseRun<D>{std::move(mark), false, std::move(lane.samples)};
        });
        running_ &= ~left;
    }
    void end(int k, Lane& lane) {
        Mark<D> mark;
        mark.t = lane.t, mark.h = lane.to.h, mark.y = vector_of(y_, k);
        angles_.write_end(k, mark.counted);
        mark.counters = lane.counters, mark.counters.factorisations = equations_.factorisations.of[k];
        mark.peaks = peaks_.of(k, static_cast<int>(model_.driven.size()));
        found_[lane.number] = CaseRun<D>{std::move(mark), true, std::move(lane.samples)};
        running_.set(k, false);
    }

    Pack tolerance() const {
        return of_lanes([&](int k) { return steps_of(k).tolerance; });
    }
    // Chooses the next steps of the lanes that are in as first steps, at most to where steps must end.
    void choose_steps() {
        const Mask in = Lanes::in();
        if (in.none()) return;
        const Pack longest = of_lanes([&](int k) { return in[k] ? lanes_[k].schedule->left(lanes_[k].t) : 1.0; });
        const Pack found = stages_.first_step(times(), y_, tolerance(), longest);
        each_lane(Lanes::in(), [&](int k, Lane& lane) {
            ++lane.counters.evaluations;
            lane.h = std::max(found[k], lane.schedule->shortest(lane.t));
        });
    }
    void set_windows(const Mask& those) {
        each_lane(those, [&](int k, Lane& lane) { equations_.set_window(k, lane.schedule->window()); });
    }

    // Records the nearness of the poses where the next steps begin.
    void stand(const Pack& nearness) {
        PackedPassed here;
        here.record(nearness);
        here_ = {where(Lanes::in(), here.smallest, here_.smallest), where(Lanes::in(), here.largest, here_.largest)};
    }
    static void keep_finite(const Vector& numbers) {
        Mask finite = true;
        for (const Pack& number : numbers) finite &= isfinite(number);
        Lanes::keep(finite);
    }
    // Lanes leave in which a joint is open by more than a projection leaves by round-off.
    void keep_closed() {
        const Pack* C = equations_.constraint();
        for (int r = 0; r < model_.constraints.rows; ++r)
            Lanes::keep(abs(C[r]) / model_.row_scale[r] <= model_.thresholds.lost_limit);
    }
    void watch(const Pack& t) {
        peaks_.watch(equations_.constraint(), equations_.C_dot(), model_.constraints.rows,
                     static_cast<int>(model_.driven.size()), t);
    }
    void record(int k, double t, const Vector& y, const Vector& slope, const Vector& lambda, double h,
                const std::vector<double>& angles) {
        lanes_[k].counters.factorisations = equations_.factorisations.of[k];
        lanes_[k].samples.template add<D>(t, vector_of(y, k), vector_of(slope, k), model_.size(), numbers_of(lambda, k),
                                          model_.constraints.rows, h, angles, lanes_[k].counters);
    }

    const std::vector<Case<D>> cases_;
    PackedModel<D> packed_;
    const Model<P>& model_;
    PackedEquations<P> equations_;
    PackedProjection<P> projection_;
    PackedAngles<P> angles_;
    PackedStages<P> stages_;
    const ProjectionSettings& settings_;
    const bool fixed_;
    std::array<Lane, pack_width> lanes_;
    Mask running_ = false;
    std::size_t next_ = 0;
    Vector y_, y_new_, slope_, lambda_;
    PackedPassed here_;  // of the poses where steps begin
    PackedPeaks peaks_, peaks_before_;
    std::vector<std::optional<CaseRun<D>>> found_;
};

}  // namespace mbproj
