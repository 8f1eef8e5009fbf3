// The branches of switches, as in mbproj.functions.program: the interval of each branch, the branch at an argument, and the
// branch beyond each end.
#pragma once

#include <limits>

#include "model/programs.hpp"

namespace mbproj {

constexpr double free_branch = std::numeric_limits<double>::quiet_NaN();

inline bool is_sided(Op op) { return op == Op::abs || op == Op::sign || op == Op::min || op == Op::max; }
inline bool is_switching(Op op) { return is_sided(op) || op == Op::floor || op == Op::ceil || op == Op::table; }

// The interval of the argument in which a branch holds.
struct Interval {
    double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
    // The distance of x from the interval; negative inside.
    double excess(double x) const { return std::max(low - x, x - high); }
    // The end that x is nearest to, or beyond: 1 for the upper end, -1 for the lower.
    int direction(double x) const { return low - x > x - high ? -1 : 1; }
};

// The interval of a branch of instruction `at`; everything where no branch is held.
inline Interval interval(const Programs& programs, int at, double branch) {
    Interval found;
    const Op op = programs.op[at];
    if (std::isnan(branch)) return found;
    if (is_sided(op)) {
        (branch > 0.0 ? found.low : found.high) = 0.0;
    } else if (op == Op::table) {
        found.low = programs.knot[static_cast<std::size_t>(branch)];
        found.high = programs.end(static_cast<int>(programs.operand[at]), static_cast<int>(branch));
    } else {
        found.low = op == Op::floor ? branch : branch - 1.0;
        found.high = found.low + 1.0;
    }
    return found;
}

// The first piece of the branch of a table to which a piece belongs.
inline int first_piece(const Programs& programs, int table, int piece) {
    while (piece > programs.table_start[table] && !programs.kinked[piece]) --piece;
    return piece;
}

// The branch at x; free where x = 0 lies between two signs, or x is not finite.
inline double natural_branch(const Programs& programs, int at, double x) {
    const Op op = programs.op[at];
    if (!std::isfinite(x)) return free_branch;
    if (is_sided(op)) return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : free_branch;
    if (op == Op::floor) return std::floor(x);
    if (op == Op::ceil) return std::ceil(x);
    const int table = static_cast<int>(programs.operand[at]);
    return first_piece(programs, table, programs.piece_at(table, programs.lifted(table, x)));
}

// The branch above (1) or below (-1) the one that is held.
inline double branch_beyond(const Programs& programs, int at, double branch, int direction) {
    if (is_sided(programs.op[at])) return direction;
    if (programs.op[at] != Op::table) return branch + direction;
    const int table = static_cast<int>(programs.operand[at]), first = static_cast<int>(branch);
    const int start = programs.table_start[table], end = programs.table_start[table + 1];
    if (direction < 0) return first_piece(programs, table, first > start ? first - 1 : end - 1);
    const int after = programs.last_piece(table, first) + 1;
    return after < end ? after : start;
}

}  // namespace mbproj
