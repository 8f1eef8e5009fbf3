// Rows that couple coordinates. A pose gives them up to whole teeth or threads, which follow from counted turns. The
// definitions are those of mbproj.equations.turning.
#pragma once

#include "kinematics/coordinate.hpp"

namespace mbproj {

template <class D> class Couplings final {
public:
    explicit Couplings(const Model<D>& model) : model_(model) {}

    // Stores the sums at the start of a run, from which teeth are counted. `expected` are the joints' coordinates with
    // counted turns; `C` is to the nearest tooth.
    void start(const Pose<D>& pose, const std::vector<Scalar<D>>& expected, const Scalar<D>* C) {
        start_.clear();
        for (const Coupling& coupling : model_.couplings) {
            start_.push_back(coupling.rolls ? rolled(coupling, pose, expected, C[coupling.row])
                                            : sum(coupling, pose, expected) - C[coupling.row]);
        }
    }
    // Shifts rows of C by whole teeth: to the tooth in mesh, or to the nearest tooth before the start.
    void count(const Pose<D>& pose, const std::vector<Scalar<D>>& expected, Scalar<D>* C) const {
        for (std::size_t c = 0; c < model_.couplings.size(); ++c) {
            const Coupling& coupling = model_.couplings[c];
            Scalar<D>& row = C[coupling.row];
            if (coupling.rolls && !start_.empty()) {
                row += whole(coupling, pose, expected, row) - start_[c];
                continue;
            }
            if (coupling.period == 0.0) continue;
            row -= coupling.period * nearbyint(row / coupling.period);
            if (start_.empty()) continue;
            const Scalar<D> apart = sum(coupling, pose, expected) - start_[c] - row;
            row += coupling.period * nearbyint(apart / coupling.period);
        }
    }

private:
    // A roller's row with its laps and turns: 0 where it is 0 up to round-off, as after rolling from the scene's pose.
    Scalar<D> rolled(const Coupling& coupling, const Pose<D>& pose, const std::vector<Scalar<D>>& expected,
                     Scalar<D> row) const {
        const Scalar<D> found = static_cast<Scalar<D>>(whole(coupling, pose, expected, row) + row);
        return abs(found) <= model_.thresholds.open_limit * model_.row_scale[coupling.row] ? Scalar<D>(0.0) : found;
    }

    // The laps and turns of a roller that bring its row nearest to its expected value; both, as they have no common
    // measure.
    long double whole(const Coupling& coupling, const Pose<D>& pose, const std::vector<Scalar<D>>& expected,
                      Scalar<D> row) const {
        const int roller = coupling.coordinates[1];
        const Scalar<D> angle = Coordinate<D>(model_.coordinates, roller, pose).value();
        const Scalar<D> turns = nearbyint((expected[roller] - angle) / (2.0 * M_PI));
        const long double turned = static_cast<long double>(2.0 * M_PI) * coupling.weights[1] * turns;
        if (coupling.period == 0.0) return turned;
        const Scalar<D> apart =
            sum(coupling, pose, expected) - offset(coupling.row) - row - static_cast<Scalar<D>>(turned);
        return turned + static_cast<long double>(coupling.period) * nearbyint(apart / coupling.period);
    }

    Scalar<D> offset(int row) const {
        for (const Instance<D>& p : model_.constraints.instances)
            if (p.row == row && p.rows == 1) return p.offset;
        return 0.0;
    }

    // The weighted sum of the coordinates with counted turns, less the curve.
    Scalar<D> sum(const Coupling& coupling, const Pose<D>& pose, const std::vector<Scalar<D>>& expected) const {
        Scalar<D> total = 0.0;
        if (coupling.curve >= 0) {
            const int first = coupling.coordinates.front();
            const Scalar<D> counted = Coordinate<D>(model_.coordinates, first, pose).value(expected[first]);
            const Scalar<D> turns = nearbyint((counted - pose.curved(coupling.curve)) / (2.0 * M_PI));
            total = -pose.curve(coupling.curve).x - coupling.growth * (coupling.growth == 0.0 ? 0.0 : turns);
        }
        for (std::size_t k = 0; k < coupling.coordinates.size(); ++k) {
            const int index = coupling.coordinates[k];
            total += coupling.weights[k] * Coordinate<D>(model_.coordinates, index, pose).value(expected[index]);
        }
        return total;
    }

    const Model<D>& model_;
    std::vector<Scalar<D>> start_;
};

}  // namespace mbproj
