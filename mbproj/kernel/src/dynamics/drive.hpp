// What the motions prescribe at a time: the value, rate and acceleration of each.
#pragma once

#include "model/model.hpp"
#include "model/settings.hpp"

namespace mbproj {

template <int D> class Drive final {
public:
    explicit Drive(const Model<D>& model) : model_(model), found_(model.driven.size()) {}

    std::size_t size() const { return found_.size(); }
    bool empty() const { return found_.empty(); }
    const Series& operator[](std::size_t k) const { return found_[k]; }
    // Where motion k puts its coordinate.
    double prescribed(std::size_t k) const { return model_.driven[k].start + found_[k].x; }

    // At t. Accelerations, which may jump, are seen from within the window; positions and rates are continuous, and belong
    // to t itself, so that joints close to round-off. False where one is not finite.
    bool set(double t, const TimeWindow& window) {
        bool finite = true;
        for (std::size_t k = 0; k < found_.size(); ++k) {
            found_[k] = at(k, t);
            if (const double seen = window.seen(t); seen != t) found_[k].dd = at(k, seen).dd;
            finite = finite && found_[k].finite();
        }
        return finite;
    }

private:
    Series at(std::size_t k, double t) const {
        const Series time[3] = {{t, 1.0, 0.0}, {}, {}};
        return model_.programs.run(model_.driven[k].program, time);
    }

    const Model<D>& model_;
    std::vector<Series> found_;
};

}  // namespace mbproj
