// Cholesky factorisation of a symmetric positive definite matrix of small blocks, in an order of minimum degree.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include "solver/small_blocks.hpp"

namespace mbproj {

class BlockCholesky final {
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
    double* at(std::size_t offset) { return values_.data() + offset; }
    void clear() {
        for (auto* numbers : {&values_, &hidden_}) std::fill(numbers->begin(), numbers->end(), 0.0);
    }
    // Adds a part of a row's square that its diagonal entry lacks; pivots are measured against the sum.
    void hide(int row, double square) { hidden_[row] += square; }

    // Factors in place; returns the block that has a pivot below `smallest` of its diagonal entry, or -1.
    int factor(double smallest);
    void solve(double* x) const;
    // The largest magnitude of x in the rows that are left out, less the values that the other rows imply there. Overwrites x.
    double contradiction(double* x) const;

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
            if (reciprocal_[r] > 0.0) found[r] = 1.0 / (reciprocal_[r] * reciprocal_[r] * diagonal_[r]);
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
    template <class LeftOut> void forward(double* x, LeftOut&& left_out) const;
    void measure_rows();
    int factor_diagonal(const ColumnOf& column, double smallest);
    template <int R> void subtract_products(const ColumnOf& column);
    double part(const ColumnOf& column, int i) {
        return at(column.diagonal)[i * (sizes_[column.block] + 1)] / diagonal_[begin_[column.block] + i];
    }
    int largest_pivot(const ColumnOf& column, const std::vector<bool>& open, double smallest, double tied);
    void eliminate(const ColumnOf& column, int row, const std::vector<bool>& open);
    void divide_below(const ColumnOf& column, const std::vector<int>& rows);

    std::vector<int> sizes_;
    int first_ = 0;
    std::vector<int> place_, begin_;
    std::vector<ColumnOf> columns_;                                // in the order of elimination
    std::vector<double> values_, diagonal_, hidden_, reciprocal_;  // `diagonal_`: the squares of the rows
    std::vector<char> left_out_;                                   // one for each row, or none
    std::vector<double> transposed_, kept_;                        // of the blocks of a column; values
    std::vector<double> per_usual_;                                // 1 / usual pivots
    double smallest_pivot_ = 1.0, nearness_ = 1.0, largest_left_ = 0.0;
    std::size_t fill_ = 0;
};

}  // namespace mbproj
