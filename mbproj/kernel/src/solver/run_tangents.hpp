// The derivatives of a run's states. The run reports each step, and its equations are solved once more.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solver/equations_of_motion.hpp"
#include "solver/model_structure.hpp"
#include "solver/state_tangents.hpp"

namespace mbproj {

// Follows a run step by step. Several directions are computed together, as many as a dual number has.
template <class D> class RunTangents final : private Answers {
public:
    // `numbers` (count, size), row by row: slopes of the model's numbers along each direction. No `obstacle`.
    RunTangents(const Model<D>& model, const Tableau& tableau, const ProjectionSettings& projection,
                std::vector<Break> breaks, const double* numbers, int count, std::size_t size)
        : model_(model), tableau_(tableau), projection_(projection), breaks_(std::move(breaks)),
          equations_(model_, projection_), count_(count) {
        for (int first = 0; first < count; first += Dual::directions)
            parts_.push_back(std::make_unique<StateTangents<D>>(
                model_, tableau_, metric(), static_cast<Answers&>(*this), numbers + first * size, count_of(first)));
    }

    // Why slopes of such a run are not known; empty where they are.
    static std::string obstacle(const Model<D>& model, const Tableau& tableau, const ProjectionSettings& projection) {
        const Correction correction = projection.correction;
        const bool known =
            correction == Correction::mass || correction == Correction::coordinates || correction == Correction::none;
        if (!known || projection.threshold >= 0.0 || projection.paper_test)
            return "projection is one whose slopes are not known";
        if (tableau.is_implicit()) return "tableau is not that of explicit steps";
        if (!model.stops.bound.empty() || !model.bearings.empty() || !model.actions.empty() || !model.switches.empty())
            return "model has contacts, friction that goes by loads, controllers, or functions with branches";
        if (tableau.kinematic && model.layout.states.size > 0) return "model has states beside a motion that is given";
        return {};
    }

    bool start(double t, const double* y, const double* slopes) {
        begin(t, y);
        if (!equations_.start()) return false;
        for (std::size_t part = 0; part < parts_.size(); ++part)
            if (!parts_[part]->start(t, y, slopes + part * Dual::directions * y_.size())) return false;
        return true;
    }
    // For a motion that joints and motions alone determine: starts at y at t.
    bool stand(double t, const double* y) {
        if (y_.empty()) begin(t, y);
        std::copy(y, y + y_.size(), y_.begin());
        equations_.set_pose(t, y);
        if (!equations_.start()) return false;
        for (const auto& part : parts_)
            if (!part->stand(t, y)) return false;
        return true;
    }
    // Follows a step from the current state, at t, over h to y at `end`. Adds the slopes at `count` times `at` inside
    // it to `found`; the states there are the rows of `inside`.
    bool follow(double t, double h, double end, const double* y, std::size_t count, const double* at,
                const double* inside, std::vector<double>& found) {
        const bool due = projection_.corrects() && ++steps_ % projection_.every == 0;
        const StepMade step{t, h, end, window(t, end), due && projection_.position, due && projection_.velocity};
        StepMade within = step;
        within.position = projection_.corrects() && projection_.position;
        within.velocity = projection_.corrects() && projection_.velocity;
        std::vector<std::vector<std::vector<Dual>>> slopes(parts_.size());
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            equations_.set_window(step.window);
            equations_.set_pose(t, y_.data());
            parts_[p]->begin();
            if (!equations_.start() || !parts_[p]->follow(step, y)) return false;
            equations_.set_window(step.window);
            if (count && !parts_[p]->extend(step)) return false;
            slopes[p].resize(count);
            for (std::size_t k = 0; k < count; ++k)
                if (!parts_[p]->inside(within, at[k], inside + k * y_.size(), slopes[p][k])) return false;
        }
        for (std::size_t k = 0; k < count; ++k)
            write([&](std::size_t part) -> const auto& { return slopes[part][k]; }, found);
        std::copy(y, y + y_.size(), y_.begin());
        return true;
    }
    // Writes the slope of the state for each direction, row by row.
    void write(std::vector<double>& found) const {
        write([this](std::size_t part) -> const auto& { return parts_[part]->state(); }, found);
    }
    int count() const { return count_; }
    std::size_t size() const { return model_.layout.size(); }

private:
    using S = Size<D>;

    void begin(double t, const double* y) {
        y_.assign(y, y + model_.layout.size());
        equations_.set_pose(t, y);
        equations_.start_teeth();
    }
    template <class StateOf> void write(const StateOf& state_of, std::vector<double>& found) const {
        for (int k = 0; k < count_; ++k)
            for (const Dual& number : state_of(k / Dual::directions))
                found.push_back(number.tangent[k % Dual::directions]);
    }
    int count_of(int first) const { return std::min(count_ - first, static_cast<int>(Dual::directions)); }

    Metric metric() const {
        return projection_.correction == Correction::coordinates ? Metric::coordinates : Metric::mass;
    }

    // The window between the breaks that enclose the step, for functions of time.
    TimeWindow window(double t, double end) const {
        TimeWindow found;
        for (const Break& each : breaks_) {
            if (each.left < t) found.first = each.right;
            if (each.right > end) return found.last = each.left, found;
        }
        return found;
    }

    bool slope(double t, const double* y, double* slope, double* lambda) override {
        return equations_.derivative(t, y, slope, lambda);
    }
    bool close(double t, const double* y) override {
        equations_.set_window({});
        equations_.set_pose(t, y);
        return equations_.factor(metric());
    }
    bool respond(const double* forces, const double* rhs, double* changes, double* lambda) override {
        KktSolver<D>& solver = equations_.solver();
        for (int b = 0; b < model_.size(); ++b, forces += S::freedoms)
            solver.set_force(b, matrix_at<D::axes>(forces), matrix_at<S::turns>(forces + D::axes));
        if (!solver.solve(rhs, lambda)) return false;
        for (int b = 0; b < model_.size(); ++b, changes += S::freedoms) {
            matrix_at<D::axes>(changes) = solver.shift(b);
            matrix_at<S::turns>(changes + D::axes) = solver.turn(b);
        }
        return true;
    }

    const Model<D> model_;
    const Tableau tableau_;
    const ProjectionSettings projection_;
    const std::vector<Break> breaks_;
    EquationsOfMotion<D> equations_;
    const int count_;
    std::vector<std::unique_ptr<StateTangents<D>>> parts_;
    std::vector<double> y_;
    long steps_ = 0;
};

// The numbers of a model in the order in which their slopes are given.
template <class D> std::vector<double> numbers_of(const Model<D>& model) {
    std::vector<double> found;
    each_number(model, model.loads.get(), [&found](double number) { found.push_back(number); });
    return found;
}

}  // namespace mbproj
