// Functions of a scene as postfix programs, in the numbers of mbproj.functions.program.
#pragma once

#include <limits>
#include <set>
#include <type_traits>
#include <vector>

#include "model/taylor_series.hpp"

namespace mbproj {

enum class Op : int {
    constant,
    variable,
    table,
    power,
    negate,
    add,
    subtract,
    multiply,
    divide,
    power_of,
    atan2,
    hypot,
    min,
    max,
    sin,
    cos,
    tan,
    asin,
    acos,
    atan,
    sinh,
    cosh,
    tanh,
    exp,
    log,
    log10,
    sqrt,
    abs,
    sign,
    floor,
    ceil,
    smooth_step
};
constexpr int op_count = static_cast<int>(Op::smooth_step) + 1;
constexpr int deepest_stack = 64;
constexpr int law_variables = 3;

// The number of values that an operation takes from the stack.
constexpr int arguments(Op op) {
    if (op <= Op::variable) return 0;
    return op >= Op::add && op <= Op::max ? 2 : 1;
}

template <class Number> struct ProgramsOf {
    std::vector<int> start;
    std::vector<Op> op;
    std::vector<double> operand;   // the numbers of variables and tables, and exponents
    std::vector<Number> constant;  // the constant of each instruction
    std::vector<int> table_start;
    std::vector<double> knot;
    std::vector<Number> origin;
    std::vector<Number> piece;   // four a row
    std::vector<bool> kinked;    // pieces that begin with a kink, and the first of each table
    std::vector<double> period;  // of each table, 0 for one that does not repeat
    int variables = law_variables;

    int size() const { return static_cast<int>(start.size()) - 1; }
    // Whether a program names a variable from this number on.
    bool names(int program, int variable) const {
        for (int at = start[program]; at < start[program + 1]; ++at)
            if (op[at] == Op::variable && operand[at] >= variable) return true;
        return false;
    }

    // The variables that a program names, each once, ascending.
    std::vector<std::size_t> named(int program) const {
        std::set<std::size_t> found;
        for (int at = start[program]; at < start[program + 1]; ++at)
            if (op[at] == Op::variable) found.insert(static_cast<std::size_t>(operand[at]));
        return {found.begin(), found.end()};
    }

    // Value and derivatives of a program. Its variables are the time, the coordinate and the rate of a law, and channels.
    template <class S> Series<S> run(int program, const Series<S>* variables) const {
        return walk(program, variables, nullptr, [](int, const Series<S>&, const Series<S>&) {});
    }

    // Value and derivatives on the branches `held`, one for each instruction, or on free ones (model/switches.hpp).
    // Where a held branch has no value beyond its end, such as the root of a negative number, all branches are free.
    template <class S> Series<S> run(int program, const Series<S>* variables, const double* held) const {
        const Series<S> found = walk(program, variables, held, [](int, const Series<S>&, const Series<S>&) {});
        return held && !isfinite(found.x) ? run(program, variables) : found;
    }
    template <class S> S value(int program, const Series<S>* variables, const double* held) const {
        return run(program, variables, held).x;
    }
    // The derivative of a program along the given derivatives of its variables.
    template <class S> S slope(int program, const Series<S>* variables, const double* held) const {
        return run(program, variables, held).d;
    }

    // Calls see(instruction, x, y) with the arguments of each instruction that takes some; y has no meaning where it takes one
    // argument.
    template <class S, class See>
    Series<S> walk(int program, const Series<S>* variables, const double* held, See&& see) const {
        Stack<S> values;
        Series<S>* const stack = values.at;
        int top = -1;
        for (int at = start[program]; at < start[program + 1]; ++at) {
            const int taken = arguments(op[at]);
            if (taken == 0) {
                stack[++top] = op[at] == Op::constant ? Series<S>{constant[at], 0.0, 0.0}
                                                      : variables[static_cast<int>(operand[at])];
                continue;
            }
            top -= taken - 1;
            see(at, stack[top], stack[top + 1]);
            if (held && !isnan(held[at]))
                stack[top] = on_branch(at, held[at], stack[top], stack[top + 1]);
            else
                stack[top] = taken == 1 ? unary(at, stack[top]) : binary(op[at], stack[top], stack[top + 1]);
        }
        return stack[0];
    }

    // The last piece of the branch of a table that begins with the piece `first`.
    int last_piece(int table, int first) const {
        int last = first;
        while (last + 1 < table_start[table + 1] && !kinked[last + 1]) ++last;
        return last;
    }
    // The end of the branch of a table that begins with the piece `first`.
    double end(int table, int first) const {
        const int start = table_start[table], after = last_piece(table, first) + 1;
        if (after < table_start[table + 1]) return knot[after];
        return period[table] > 0.0 ? knot[start] + period[table] : std::numeric_limits<double>::infinity();
    }
    // x shifted by whole periods to be nearest to a branch of a table, or to lie in the first period where no branch is held.
    template <class S> S lifted(int table, const S& x, double branch = std::numeric_limits<double>::quiet_NaN()) const {
        const double whole = period[table];
        if (!(whole > 0.0)) return x;
        if (isnan(branch)) return x - whole * floor((x - knot[table_start[table]]) / whole);
        const int first = static_cast<int>(branch);
        return x - whole * nearbyint((x - 0.5 * (knot[first] + end(table, first))) / whole);
    }
    // The value that decides the branch of a switch, from its arguments.
    template <class S> S argument(int at, double branch, const S& x, const S& y) const {
        if (op[at] == Op::table) return lifted(static_cast<int>(operand[at]), x, branch);
        return op[at] == Op::min || op[at] == Op::max ? x - y : x;
    }
    // The piece of a table at x, which lies within one period. The first piece also holds before its knot.
    template <class S> int piece_at(int table, const S& x) const {
        const auto second = knot.begin() + table_start[table] + 1, end = knot.begin() + table_start[table + 1];
        return table_start[table] + static_cast<int>(std::upper_bound(second, end, value_of(x)) - second);
    }

private:
    // Not set to zero, which would take longer than many programs. A program reads only numbers that it has written.
    template <class S> struct Stack {
        union {
            Series<S> at[deepest_stack];
        };
        Stack() {}
    };

    // The result of a switch on one of its branches.
    template <class S> Series<S> on_branch(int at, double branch, const Series<S>& x, const Series<S>& y) const {
        switch (op[at]) {
            case Op::max: return branch > 0.0 ? x : y;
            case Op::min: return branch > 0.0 ? y : x;
            case Op::abs: return {branch * x.x, branch * x.d, branch * x.dd};
            case Op::table: {
                const int table = static_cast<int>(operand[at]), first = static_cast<int>(branch);
                const Series<S> near{lifted(table, x.x, branch), x.d, x.dd};
                return on_piece(min(max(piece_at(table, near.x), first), last_piece(table, first)), near);
            }
            default: return flat(S(branch));
        }
    }

    template <class S> static Series<S> flat(const S& value) { return {value, 0.0, 0.0}; }

    template <class S> Series<S> binary(Op op, const Series<S>& a, const Series<S>& b) const {
        switch (op) {
            case Op::add: return a + b;
            case Op::subtract: return a - b;
            case Op::multiply: return a * b;
            case Op::divide: return a / b;
            case Op::power_of: return power_of(a, b);
            case Op::atan2: return arc_tangent(a, b);
            case Op::hypot: return hypotenuse(a, b);
            case Op::min: return a.x <= b.x ? a : b;
            default: return a.x >= b.x ? a : b;
        }
    }

    template <class S> Series<S> unary(int at, const Series<S>& s) const {
        const S x = s.x;
        switch (op[at]) {
            case Op::table: return look_up(static_cast<int>(operand[at]), s);
            case Op::power: return power(s, operand[at]);
            case Op::negate: return {-s.x, -s.d, -s.dd};
            case Op::sin:
            case Op::cos: {
                const auto [sine, cosine] = sine_and_cosine(x);
                return op[at] == Op::sin ? chain(sine, cosine, -sine, s) : chain(cosine, -sine, -cosine, s);
            }
            case Op::tan: {
                const S value = tan(x), rate = 1.0 + value * value;
                return chain(value, rate, 2.0 * value * rate, s);
            }
            case Op::asin:
            case Op::acos: {
                const S rate = 1.0 / sqrt(1.0 - x * x), bend = x * rate * rate * rate;
                return op[at] == Op::asin ? chain(asin(x), rate, bend, s) : chain(acos(x), -rate, -bend, s);
            }
            case Op::atan: {
                const S rate = 1.0 / (1.0 + x * x);
                return chain(atan(x), rate, -2.0 * x * rate * rate, s);
            }
            case Op::sinh: return chain(sinh(x), cosh(x), sinh(x), s);
            case Op::cosh: return chain(cosh(x), sinh(x), cosh(x), s);
            case Op::tanh: {
                const S value = tanh(x), rate = 1.0 - value * value;
                return chain(value, rate, -2.0 * value * rate, s);
            }
            case Op::exp: return exponential(s);
            case Op::log: return logarithm(s);
            case Op::log10: {
                const Series<S> found = logarithm(s);
                const double scale = 1.0 / log(10.0);
                return {scale * found.x, scale * found.d, scale * found.dd};
            }
            case Op::sqrt: {
                const S root = sqrt(x);
                return chain(root, 0.5 / root, -0.25 / (root * root * root), s);
            }
            case Op::abs: return chain(abs(x), S(x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0), S(0.0), s);
            case Op::sign: return flat(x > 0.0 ? S(1.0) : x < 0.0 ? S(-1.0) : x);
            case Op::floor: return flat(floor(x));
            case Op::ceil: return flat(ceil(x));
            default: return smooth_step(s);
        }
    }

    template <class S> Series<S> look_up(int table, const Series<S>& s) const {
        const Series<S> first{lifted(table, s.x), s.d, s.dd};
        return on_piece(piece_at(table, first.x), first);
    }

    template <class S> Series<S> on_piece(int at, const Series<S>& s) const {
        const S c[4] = {piece[4 * at], piece[4 * at + 1], piece[4 * at + 2], piece[4 * at + 3]};
        const S u = s.x - origin[at];
        return chain(c[0] + u * (c[1] + u * (c[2] + u * c[3])), c[1] + u * (2.0 * c[2] + 3.0 * u * c[3]),
                     2.0 * c[2] + 6.0 * u * c[3], s);
    }
};
using Programs = ProgramsOf<double>;

}  // namespace mbproj
