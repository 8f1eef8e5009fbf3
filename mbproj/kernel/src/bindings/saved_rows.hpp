// What a row policy remembers, as plain data for Python, and back: what comes from a file is checked.
#pragma once

#include "bindings/from_numpy.hpp"
#include "dynamics/row_policy.hpp"

namespace mbproj {

template <int D> nb::dict saved_rows(const typename RowPolicy<D>::Saved& saved) {
    nb::dict found;
    found["held"] = saved.rows.held;
    found["usual"] = saved.rows.usual;
    found["usual_even"] = saved.rows.usual_even;
    found["clear_pivot"] = saved.rows.clear_pivot;
    found["clear_even"] = saved.rows.clear_even;
    found["largest_pivot"] = saved.largest_pivot;
    found["largest_even"] = saved.largest_even;
    found["chosen_pivots"] = saved.chosen_pivots;
    found["others_may_serve"] = saved.others_may_serve;
    found["before"] = saved.before;
    return found;
}

// Of each joint in the loops some of its rows, or of none.
template <int D>
void check_held_rows(const std::vector<std::vector<int>>& held, const Model<D>& model, const std::vector<int>& joints) {
    if (held.empty()) return;
    if (held.size() != joints.size()) refuse("held", "has a wrong number of joints");
    for (std::size_t h = 0; h < held.size(); ++h)
        for (std::size_t r = 0; r < held[h].size(); ++r)
            if (held[h][r] < (r ? held[h][r - 1] + 1 : 0) || held[h][r] >= model.joints[joints[h]].rows)
                refuse("held", "holds an index out of range");
}

template <int D>
typename RowPolicy<D>::Saved rows_from(const nb::dict& given, const Model<D>& model, const std::vector<int>& joints) {
    const auto number = [&given](const char* name) {
        const auto value = nb::cast<double>(given[name]);
        if (!(value >= 0.0 && std::isfinite(value))) refuse(name, "is negative or not finite");
        return value;
    };
    typename RowPolicy<D>::Saved saved;
    saved.rows.held = nb::cast<std::vector<std::vector<int>>>(given["held"]);
    check_held_rows(saved.rows.held, model, joints);
    saved.rows.usual = number("usual");
    saved.rows.usual_even = number("usual_even");
    require_positive(saved.rows.usual, "usual");
    require_positive(saved.rows.usual_even, "usual_even");
    saved.rows.clear_pivot = number("clear_pivot");
    saved.rows.clear_even = number("clear_even");
    saved.largest_pivot = number("largest_pivot");
    saved.largest_even = number("largest_even");
    saved.chosen_pivots = nb::cast<std::vector<double>>(given["chosen_pivots"]);
    std::size_t rows = 0;
    for (const auto& some : saved.rows.held) rows += some.size();
    if (!saved.chosen_pivots.empty() && !saved.rows.held.empty() && saved.chosen_pivots.size() != rows)
        refuse("chosen_pivots", "has a wrong shape");
    saved.others_may_serve = nb::cast<bool>(given["others_may_serve"]);
    saved.before = number("before");
    return saved;
}

}  // namespace mbproj
