// Which rows of a symmetric positive semidefinite block matrix are independent: its Cholesky factorisation, which leaves
// a row out where nothing of it is left.
#pragma once

#include "loops/block_cholesky.hpp"

namespace mbproj {

// For each block the rows, ascending, whose pivots exceed `smallest` of their diagonal entries: within a block the largest
// pivot goes first, and blocks in the order of elimination. The values are used up.
inline std::vector<std::vector<int>> BlockCholesky::independent_rows(double smallest) {
    std::vector<std::vector<int>> kept(sizes_.size());
    measure_rows();
    for (const ColumnOf& column : columns_) {
        const int size = sizes_[column.block];
        double* A = at(column.diagonal);
        for (int i = 0; i < size; ++i)
            for (int j = i + 1; j < size; ++j) A[i * size + j] = A[j * size + i];
        std::vector<bool> open(size, true);
        const double least = column.block < first_ ? 0.0 : smallest;
        for (int row = largest_pivot(column, open, least); row >= 0; row = largest_pivot(column, open, least)) {
            open[row] = false;
            kept[column.block].push_back(row);
            eliminate(column, row, open);
        }
        std::sort(kept[column.block].begin(), kept[column.block].end());
        const std::size_t* update = column.updates.data();
        for (std::size_t a = 0; a < column.below.size(); ++a) {
            const Entry& x = column.below[a];
            for (int r = 0; r < sizes_[x.block]; ++r)
                for (int i = 0; i < size; ++i)
                    if (open[i]) at(x.offset)[r * size + i] = 0.0;
            for (std::size_t b = 0; b <= a; ++b, ++update) {
                const Entry& y = column.below[b];
                blocks::with_width(size, [&](auto width) {
                    blocks::subtract<decltype(width)::value>(at(*update), at(x.offset), sizes_[x.block], at(y.offset),
                                                             sizes_[y.block]);
                });
            }
        }
    }
    return kept;
}

// The open row with the largest pivot, or -1 where none exceeds `smallest` of its diagonal entry.
inline int BlockCholesky::largest_pivot(const ColumnOf& column, const std::vector<bool>& open, double smallest) {
    const int size = sizes_[column.block];
    int best = -1;
    for (int i = 0; i < size; ++i) {
        const double part = at(column.diagonal)[i * (size + 1)] / diagonal_[begin_[column.block] + i];
        if (!open[i] || !(part > smallest)) continue;
        smallest = part;
        best = i;
    }
    return best;
}

// Takes a row of a block out of the open ones, and makes its column of the blocks below one of the factor.
inline void BlockCholesky::eliminate(const ColumnOf& column, int row, const std::vector<bool>& open) {
    const int size = sizes_[column.block];
    double* A = at(column.diagonal);
    const double pivot = A[row * (size + 1)];
    for (int i = 0; i < size; ++i) {
        if (!open[i]) continue;
        const double share = A[i * size + row] / pivot;
        for (int j = 0; j < size; ++j)
            if (open[j]) A[i * size + j] -= share * A[row * size + j];
        for (const Entry& x : column.below)
            for (int r = 0; r < sizes_[x.block]; ++r)
                at(x.offset)[r * size + i] -= share * at(x.offset)[r * size + row];
    }
    for (const Entry& x : column.below)
        for (int r = 0; r < sizes_[x.block]; ++r) at(x.offset)[r * size + row] /= std::sqrt(pivot);
}

}  // namespace mbproj
