// The irreducible blocks of a square matrix. In their order the matrix is block triangular (Duff & Reid 1978). Each
// block is regular or singular by itself. A block of a driven mechanism is a set of rows that must be closed at once: a
// crank with its motion, and then groups of Assur.
#pragma once

#include <algorithm>
#include <vector>

namespace mbproj {

class IrreducibleBlocks final {
public:
    // For a matrix whose row r has entries in `columns[r]`. No blocks where some row cannot be paired with a column.
    explicit IrreducibleBlocks(const std::vector<std::vector<int>>& columns)
        : columns_(columns), row_of_(columns.size(), -1), number_(columns.size(), 0), least_(columns.size(), 0),
          block_of_(columns.size(), -1), seen_(columns.size(), -1) {
        const int size = static_cast<int>(columns.size());
        for (int row = 0; row < size; ++row)
            if (!finds_column(row, row)) return;
        for (int column = 0; column < size; ++column)
            if (number_[column] == 0) visit(column);
    }

    int count() const { return count_; }
    // The block of each column, and of the row that is paired with it; -1 where there are none.
    int of_column(int column) const { return block_of_[column]; }
    int row_of(int column) const { return row_of_[column]; }

private:
    // Pairs a row with a column; changes other pairs where it must.
    bool finds_column(int row, int mark) {
        for (const int column : columns_[row])
            if (row_of_[column] < 0) return row_of_[column] = row, true;
        for (const int column : columns_[row]) {
            if (seen_[column] == mark) continue;
            seen_[column] = mark;
            if (finds_column(row_of_[column], mark)) return row_of_[column] = row, true;
        }
        return false;
    }
    // Strongly connected columns (Tarjan 1972): a column leads to the columns in which its row has entries.
    void visit(int column) {
        number_[column] = least_[column] = ++visited_;
        open_.push_back(column);
        for (const int next : columns_[row_of_[column]]) {
            if (number_[next] == 0) visit(next);
            if (block_of_[next] < 0) least_[column] = std::min(least_[column], least_[next]);
        }
        if (least_[column] != number_[column]) return;
        for (bool done = false; !done; open_.pop_back()) {
            block_of_[open_.back()] = count_;
            done = open_.back() == column;
        }
        ++count_;
    }

    const std::vector<std::vector<int>>& columns_;
    std::vector<int> row_of_, number_, least_, block_of_, seen_, open_;
    int count_ = 0, visited_ = 0;
};

}  // namespace mbproj
