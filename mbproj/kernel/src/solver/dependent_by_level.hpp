// Finds dependent rows where some rows are at velocity level.
#pragma once

#include <algorithm>

#include "model/decompositions.hpp"
#include "model/model.hpp"

namespace mbproj {

// The rows of the model, ascending, that depend on the others at the pose of the last `fill_evenly`, up to a distance of
// √smallest. Rows at velocity level, marked in `slips`, come after all others: a position-level row that is left out in their
// favour would open. Within a level the row farthest from the span of those taken comes first; of equals, the first one. Dense,
// since this order is unrelated to the fill.
template <class Delassus, class D> std::vector<int>
dependent_by_level(const Delassus& from, const std::vector<char>& slips, const Model<D>& model, double smallest) {
    constexpr int F = Delassus::F;
    std::vector<int> of_model(from.count()), left;
    Eigen::MatrixXd Y = Eigen::MatrixXd::Zero(F * from.layout().pieces(), from.count());
    from.each_column([&](int body, int row, const auto& y) {
        for (int i = 0; i < F; ++i) Y(F * body + i, row) = value_of(y[i]);
    });
    from.each_row([&](int own, int row) { of_model[own] = row; });
    const Eigen::VectorXd size = Y.colwise().squaredNorm();
    const auto part = [&](int r) { return size[r] > 0.0 ? Y.col(r).squaredNorm() / size[r] : 0.0; };
    const auto is_less = [&](int a, int b) { return part(a) < model.thresholds.tied * part(b); };
    for (const char level : {0, 1}) {
        std::vector<int> open;
        for (int r = 0; r < from.count(); ++r)
            if (of_model[r] < model.constraints.rows && slips[of_model[r]] == level) open.push_back(r);
        while (!open.empty()) {
            const auto best = std::max_element(open.begin(), open.end(), is_less);
            if (part(*best) <= smallest) break;
            const Eigen::VectorXd unit = Y.col(*best).normalized();
            open.erase(best);
            for (int pass = 0; pass < 2; ++pass)  // twice is enough (Kahan)
                for (Eigen::Index r = 0; r < Y.cols(); ++r) Y.col(r) -= unit * unit.dot(Y.col(r));
        }
        for (const int r : open) left.push_back(of_model[r]);
    }
    std::sort(left.begin(), left.end());
    return left;
}

}  // namespace mbproj
