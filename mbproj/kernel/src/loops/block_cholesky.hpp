// Cholesky factorisation of a symmetric positive definite matrix of small blocks, in an order of minimum degree.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include "loops/small_blocks.hpp"

namespace mbproj {

template <class Scalar> class BlockCholesky final {
public:
    BlockCholesky() = default;
    // The sizes of the blocks, and the pairs that couple. The first `first` blocks are eliminated first, with all rows.
    BlockCholesky(std::vector<int> sizes, const std::vector<std::pair<int, int>>& couplings, int first)
        : sizes_(std::move(sizes)), first_(first), place_(sizes_.size()), begin_(sizes_.size()) {
        const int count = static_cast<int>(sizes_.size());
        int rows = 0;
        for (int i = 0; i < count; ++i) {
            begin_[i] = rows;
            rows += sizes_[i];
        }
        diagonal_.resize(rows);
        hidden_.assign(rows, 0.0);
        reciprocal_.resize(rows);
        per_usual_.assign(rows, 1.0);
        std::vector<std::vector<int>> near(count);
        for (const auto& [i, j] : couplings)
            if (i != j) {
                near[i].push_back(j);
                near[j].push_back(i);
            }
        for (std::vector<int>& blocks : near) {
            std::sort(blocks.begin(), blocks.end());
            blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
        }
        order_by_degree(std::move(near));
    }

    // Where to add entries of block (i, j) before `factor`: row-major, `transposed` if (j, i) is stored.
    struct Target {
        std::size_t offset;
        bool transposed;
    };
    Target target(int i, int j) const {
        if (place_[i] >= place_[j]) return {offset(i, j), false};
        return {offset(j, i), true};
    }
    Scalar* at(std::size_t offset) { return values_.data() + offset; }
    void clear() {
        for (auto* numbers : {&values_, &hidden_}) std::fill(numbers->begin(), numbers->end(), 0.0);
    }
    // Adds a part of a row's square that its diagonal entry lacks; pivots are measured against the sum.
    void hide(int row, Scalar square) { hidden_[row] += square; }

    // Factors in place; returns the block that has a pivot below `smallest` of its diagonal entry, or -1.
    int factor(double smallest);
    void solve(Scalar* x) const;
    // The largest magnitude of x in the rows that are left out, less the values that the other rows imply there. Overwrites x.
    Scalar contradiction(Scalar* x) const;

    std::vector<std::vector<int>> independent_rows(double smallest, double tied, int most);
    double largest_left() const { return largest_left_; }  // the largest pivot that was left out
    void keep() { kept_ = values_; }                       // `restore` brings them back
    void restore() { values_ = kept_; }

    // Rows that `factor` leaves out from now on: their λ is 0 for any right-hand side.
    void leave_out(std::vector<char> rows) { left_out_ = std::move(rows); }
    bool leaves_out() const { return !left_out_.empty(); }
    std::size_t stored() const { return values_.size(); }
    std::size_t filled() const { return fill_; }  // the part of them in fill: blocks that are 0 in the matrix
    int row(int block) const { return begin_[block]; }
    double smallest_pivot() const { return smallest_pivot_; }
    double nearness() const { return nearness_; }    // the smallest ratio of a pivot to its usual value
    void expect(const std::vector<double>& usual) {  // empty: all 1, for other rows or a penalty
        const std::size_t n = per_usual_.size();
        for (std::size_t r = 0; r < n; ++r) per_usual_[r] = usual.size() == n ? 1.0 / usual[r] : 1.0;
    }
    // The pivots of all rows in parts of their diagonal entries; 0 for those that are left out.
    std::vector<double> pivots() const {
        std::vector<double> found(diagonal_.size(), 0.0);
        for (std::size_t r = 0; r < found.size(); ++r)
            if (reciprocal_[r] > 0.0) found[r] = value_of(1.0 / (reciprocal_[r] * reciprocal_[r] * diagonal_[r]));
        return found;
    }

private:
    struct Entry {
        int block;
        std::size_t offset;
    };
    struct ColumnOf {
        int block;
        std::size_t diagonal;
        std::vector<Entry> below;
        std::vector<std::size_t> updates;  // targets of the products of pairs of `below`, row by row of the triangle
    };

    void order_by_degree(std::vector<std::vector<int>> near);
    void find_updates(ColumnOf& column) const;
    std::size_t offset(int i, int j) const {
        const ColumnOf& column = columns_[place_[j]];
        if (i == j) return column.diagonal;
        for (const Entry& entry : column.below)
            if (entry.block == i) return entry.offset;
        return 0;
    }
    template <class LeftOut> void forward(Scalar* x, LeftOut&& left_out) const;
    void measure_rows();
    int factor_diagonal(const ColumnOf& column, double smallest);
    template <int R> void subtract_products(const ColumnOf& column);
    Scalar part(const ColumnOf& column, int i) {
        return at(column.diagonal)[i * (sizes_[column.block] + 1)] / diagonal_[begin_[column.block] + i];
    }
    int largest_pivot(const ColumnOf& column, const std::vector<bool>& open, double smallest, double tied);
    void eliminate(const ColumnOf& column, int row, const std::vector<bool>& open);
    void divide_below(const ColumnOf& column, const std::vector<int>& rows);

    std::vector<int> sizes_;
    int first_ = 0;
    std::vector<int> place_, begin_;
    std::vector<ColumnOf> columns_;                                // in the order of elimination
    std::vector<Scalar> values_, diagonal_, hidden_, reciprocal_;  // `diagonal_`: the squares of the rows
    std::vector<char> left_out_;                                   // one for each row, or none
    std::vector<Scalar> transposed_, kept_;                        // of the blocks of a column; values
    std::vector<double> per_usual_;                                // 1 / usual pivots
    double smallest_pivot_ = 1.0, nearness_ = 1.0, largest_left_ = 0.0;
    std::size_t fill_ = 0;
};

// `near`: the blocks that couple with each, ascending.
template <class Scalar> inline void BlockCholesky<Scalar>::order_by_degree(std::vector<std::vector<int>> near) {
    const int count = static_cast<int>(sizes_.size());
    const auto original = near;
    std::set<std::pair<std::size_t, int>> waiting;
    const auto turn = [&](int i) { return std::pair(i < first_ ? 0 : 1 + near[i].size(), i); };
    for (int i = 0; i < count; ++i) waiting.insert(turn(i));
    std::vector<int> both;
    std::size_t next = 0;
    while (!waiting.empty()) {
        const int block = waiting.begin()->second;
        waiting.erase(waiting.begin());
        place_[block] = static_cast<int>(columns_.size());
        ColumnOf column{block, next, {}, {}};
        next += static_cast<std::size_t>(sizes_[block]) * sizes_[block];
        for (const int i : near[block]) {
            column.below.push_back({i, next});
            const std::size_t size = static_cast<std::size_t>(sizes_[i]) * sizes_[block];
            next += size;
            if (!std::binary_search(original[block].begin(), original[block].end(), i)) fill_ += size;
            waiting.erase(turn(i));
            both.clear();
            std::set_union(near[i].begin(), near[i].end(), near[block].begin(), near[block].end(),
                           std::back_inserter(both));
            both.erase(std::remove_if(both.begin(), both.end(), [&](int j) { return j == i || j == block; }),
                       both.end());
            near[i].assign(both.begin(), both.end());
            waiting.insert(turn(i));
        }
        near[block] = {};
        columns_.push_back(std::move(column));
    }
    values_.resize(next);
    for (ColumnOf& column : columns_)
        std::sort(column.below.begin(), column.below.end(),
                  [this](const Entry& a, const Entry& b) { return place_[a.block] < place_[b.block]; });
    std::size_t most = 0;
    for (ColumnOf& column : columns_) {
        find_updates(column);
        most = max(most, blocks::eight * column.below.size() * sizes_[column.block]);
    }
    transposed_.resize(most);
}

// For each pair of a column's blocks, the place of their product: the blocks of the later column are in the same order.
template <class Scalar> inline void BlockCholesky<Scalar>::find_updates(ColumnOf& column) const {
    const std::size_t count = column.below.size();
    column.updates.resize(count * (count + 1) / 2);
    for (std::size_t b = 0; b < count; ++b) {
        const ColumnOf& target = columns_[place_[column.below[b].block]];
        column.updates[b * (b + 1) / 2 + b] = target.diagonal;
        auto at = target.below.begin();
        for (std::size_t a = b + 1; a < count; ++a) {
            while (at->block != column.below[a].block) ++at;
            column.updates[a * (a + 1) / 2 + b] = at->offset;
        }
    }
}

template <class Scalar> inline int BlockCholesky<Scalar>::factor_diagonal(const ColumnOf& column, double smallest) {
    const int size = sizes_[column.block], row = begin_[column.block];
    Scalar* L = at(column.diagonal);
    for (int i = 0; i < size; ++i) {
        for (int j = 0; j < i; ++j) {
            Scalar sum = L[i * size + j];
            for (int k = 0; k < j; ++k) sum = multiply_add(-L[i * size + k], L[j * size + k], sum);
            L[i * size + j] = sum * reciprocal_[row + j];
        }
        if (leaves_out() && left_out_[row + i]) {
            reciprocal_[row + i] = 0.0;
            continue;
        }
        Scalar pivot = L[i * size + i];
        for (int k = 0; k < i; ++k) pivot = multiply_add(-L[i * size + k], L[i * size + k], pivot);
        const Scalar part = pivot / diagonal_[row + i];
        if (!(part > smallest)) return column.block;
        smallest_pivot_ = min(smallest_pivot_, value_of(part));
        nearness_ = min(nearness_, value_of(part) * per_usual_[row + i]);
        L[i * size + i] = sqrt(pivot);
        reciprocal_[row + i] = 1.0 / L[i * size + i];
    }
    return -1;
}

template <class Scalar> inline void BlockCholesky<Scalar>::measure_rows() {
    for (const ColumnOf& column : columns_) {
        const int size = sizes_[column.block], row = begin_[column.block];
        for (int i = 0; i < size; ++i) diagonal_[row + i] = at(column.diagonal)[i * size + i] + hidden_[row + i];
    }
}

// Subtracts the products of a column's blocks, R wide, from later columns.
template <class Scalar> template <int R> void BlockCholesky<Scalar>::subtract_products(const ColumnOf& column) {
    constexpr std::size_t size = blocks::eight * R;
    const std::size_t* update = column.updates.data();
    for (std::size_t a = 0; a < column.below.size(); ++a) {
        const Scalar* X = at(column.below[a].offset);
        const int rows = sizes_[column.below[a].block];
        blocks::transpose<R>(X, rows, transposed_.data() + size * a);
        for (std::size_t b = 0; b <= a; ++b, ++update)
            blocks::subtract<R>(at(*update), X, rows, transposed_.data() + size * b, sizes_[column.below[b].block]);
    }
}

template <class Scalar> inline int BlockCholesky<Scalar>::factor(double smallest) {
    smallest_pivot_ = nearness_ = 1.0;
    measure_rows();
    for (const ColumnOf& column : columns_) {
        const int failed = factor_diagonal(column, smallest);
        if (failed >= 0) return failed;
        const Scalar* L = at(column.diagonal);
        const Scalar* reciprocal = reciprocal_.data() + begin_[column.block];
        blocks::with_width(sizes_[column.block], [&](auto width) {
            constexpr int R = decltype(width)::value;
            for (const Entry& entry : column.below)
                blocks::divide<R>(at(entry.offset), sizes_[entry.block], L, reciprocal);
            subtract_products<R>(column);
        });
    }
    return -1;
}

// x := L⁻¹ x, by columns; calls `left_out` with the remainder of each row that is left out.
template <class Scalar> template <class Out> void BlockCholesky<Scalar>::forward(Scalar* x, Out&& left_out) const {
    const bool all = !leaves_out();
    for (const ColumnOf& column : columns_)
        blocks::with_width(sizes_[column.block], [&](auto width) {
            constexpr int R = decltype(width)::value;
            const int row = begin_[column.block];
            const Scalar* L = values_.data() + column.diagonal;
            Scalar* part = x + row;
            for (int i = 0; i < R; ++i) {
                for (int k = 0; k < i; ++k) part[i] = multiply_add(-L[i * R + k], part[k], part[i]);
                if (!all && left_out_[row + i]) left_out(part[i]);
                part[i] *= reciprocal_[row + i];
            }
            for (const Entry& entry : column.below) {
                const Scalar* X = values_.data() + entry.offset;
                Scalar* below = x + begin_[entry.block];
                for (int i = 0; i < sizes_[entry.block]; ++i, X += R)
                    for (int k = 0; k < R; ++k) below[i] = multiply_add(-X[k], part[k], below[i]);
            }
        });
}

template <class Scalar> inline void BlockCholesky<Scalar>::solve(Scalar* x) const {
    forward(x, [](Scalar) {});
    for (auto column = columns_.rbegin(); column != columns_.rend(); ++column)
        blocks::with_width(sizes_[column->block], [&](auto width) {
            constexpr int R = decltype(width)::value;
            Scalar* part = x + begin_[column->block];
            for (const Entry& entry : column->below) {
                const Scalar* X = values_.data() + entry.offset;
                const Scalar* below = x + begin_[entry.block];
                for (int i = 0; i < sizes_[entry.block]; ++i, X += R)
                    for (int k = 0; k < R; ++k) part[k] = multiply_add(-X[k], below[i], part[k]);
            }
            const Scalar* L = values_.data() + column->diagonal;
            for (int i = R - 1; i >= 0; --i) {
                for (int k = i + 1; k < R; ++k) part[i] = multiply_add(-L[k * R + i], part[k], part[i]);
                part[i] *= reciprocal_[begin_[column->block] + i];
            }
        });
}

}  // namespace mbproj
