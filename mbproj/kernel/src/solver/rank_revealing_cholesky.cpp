// Finds the independent rows of a symmetric positive semidefinite block matrix: its Cholesky factorisation leaves a row out where
// its pivot vanishes.
#include "solver/block_cholesky.hpp"

namespace mbproj {

// For each block the rows, ascending, whose pivots exceed `smallest` of their diagonal entries. Within a block the largest pivot
// comes first, or the first row with this part of it; blocks follow the order of elimination. Stops once more than `most` rows
// are left out. Overwrites the values.
std::vector<std::vector<int>> BlockCholesky::independent_rows(double smallest, double tied, int most) {
    std::vector<std::vector<int>> kept(sizes_.size());
    largest_left_ = 0.0;
    measure_rows();
    for (const ColumnOf& column : columns_) {
        const int size = sizes_[column.block];
        double* A = at(column.diagonal);
        for (int i = 0; i < size; ++i)
            for (int j = i + 1; j < size; ++j) A[i * size + j] = A[j * size + i];
        std::vector<bool> open(size, true);
        const double least = column.block < first_ ? 0.0 : smallest;
        for (int row; (row = largest_pivot(column, open, least, tied)) >= 0;) {
            open[row] = false;
            kept[column.block].push_back(row);
            eliminate(column, row, open);
        }
        for (int i = 0; i < size; ++i)
            if (open[i]) largest_left_ = max(largest_left_, part(column, i)), --most;
        if (most < 0) break;
        divide_below(column, kept[column.block]);
        std::sort(kept[column.block].begin(), kept[column.block].end());
        for (const Entry& entry : column.below)
            for (int r = 0; r < sizes_[entry.block]; ++r)
                for (int i = 0; i < size; ++i)
                    if (open[i]) at(entry.offset)[r * size + i] = 0.0;
        blocks::with_width(size, [&](auto width) { subtract_products<decltype(width)::value>(column); });
    }
    return kept;
}

// The first open row whose pivot is at least the part `tied` of the largest one, or -1 where none exceeds `smallest` of its
// diagonal entry. So round-off does not decide between rows that symmetry makes equal.
int BlockCholesky::largest_pivot(const ColumnOf& column, const std::vector<bool>& open, double smallest, double tied) {
    const int size = sizes_[column.block];
    double largest = 0.0;
    for (int i = 0; i < size; ++i)
        if (open[i]) largest = max(largest, part(column, i));
    for (int i = 0; i < size; ++i)
        if (open[i] && part(column, i) > smallest && part(column, i) >= tied * largest) return i;
    return -1;
}

// Eliminates a row of a block from the open rows; its column of the block keeps its pivot and their factors.
void BlockCholesky::eliminate(const ColumnOf& column, int row, const std::vector<bool>& open) {
    const int size = sizes_[column.block];
    double* A = at(column.diagonal);
    for (int i = 0; i < size; ++i) {
        if (!open[i]) continue;
        const double share = A[i * size + row] / A[row * (size + 1)];
        for (int j = 0; j < size; ++j)
            if (open[j]) A[i * size + j] -= share * A[row * size + j];
        A[i * size + row] = share;
    }
}

// Turns the columns of these rows, in the order of their removal, into those of the factor in the blocks below.
void BlockCholesky::divide_below(const ColumnOf& column, const std::vector<int>& rows) {
    const int size = sizes_[column.block];
    const double* A = at(column.diagonal);
    double roots[6];
    for (std::size_t k = 0; k < rows.size(); ++k) roots[k] = sqrt(A[rows[k] * (size + 1)]);
    for (const Entry& entry : column.below) {
        double* x = at(entry.offset);
        for (int r = 0; r < sizes_[entry.block]; ++r, x += size)
            for (std::size_t k = 0; k < rows.size(); ++k) {
                for (std::size_t i = k + 1; i < rows.size(); ++i)
                    x[rows[i]] -= A[rows[i] * size + rows[k]] * x[rows[k]];
                x[rows[k]] /= roots[k];
            }
    }
}

}  // namespace mbproj
