// Solve with these rows: which rows of the loops' joints are held, and how small the pivots of S usually are. A value,
// constant within a step: equal (t, state, row set) has equal bits, in any order of calls. Which set a step is given is the
// answer of the RowPolicy.
//
// The reference is mbproj.dynamics.rank.row_set. It judges by singular values of C_q and holds combinations of rows; here
// single rows are held, by pivots of S, squares of distances in the metric of the masses. Both solve the same equations
// where the rows are independent. Near a singular pose each errs by the distance σ of what it leaves out, and so they may
// differ by that.
#pragma once

#include <vector>

namespace mbproj {

struct RowSet {
    // Of each joint in the loops, in their order, the rows that are held, ascending; empty where all are.
    std::vector<std::vector<int>> held;
    // A pose is near a singular one where the smallest pivot of S is small beside these: with the masses of the bodies, and
    // where all bodies weigh the same.
    double usual = 1.0, usual_even = 1.0;
    // Of the last accepted pose that was looked at closely: the smallest pivot, and what of it counts where all bodies weigh
    // the same; 0 where there is none.
    double clear_pivot = 0.0, clear_even = 0.0;
};

}  // namespace mbproj
