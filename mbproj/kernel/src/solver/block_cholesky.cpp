#include "solver/block_cholesky.hpp"

namespace mbproj {

// `near`: the blocks that couple with each, ascending.
void BlockCholesky::order_by_degree(std::vector<std::vector<int>> near) {
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
void BlockCholesky::find_updates(ColumnOf& column) const {
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

int BlockCholesky::factor_diagonal(const ColumnOf& column, double smallest) {
    const int size = sizes_[column.block], row = begin_[column.block];
    double* L = at(column.diagonal);
    for (int i = 0; i < size; ++i) {
        for (int j = 0; j < i; ++j) {
            double sum = L[i * size + j];
            for (int k = 0; k < j; ++k) sum = multiply_add(-L[i * size + k], L[j * size + k], sum);
            L[i * size + j] = sum * reciprocal_[row + j];
        }
        if (leaves_out() && left_out_[row + i]) {
            reciprocal_[row + i] = 0.0;
            continue;
        }
        double pivot = L[i * size + i];
        for (int k = 0; k < i; ++k) pivot = multiply_add(-L[i * size + k], L[i * size + k], pivot);
        const double part = pivot / diagonal_[row + i];
        if (!(part > smallest)) return column.block;
        smallest_pivot_ = min(smallest_pivot_, part);
        nearness_ = min(nearness_, part * per_usual_[row + i]);
        L[i * size + i] = sqrt(pivot);
        reciprocal_[row + i] = 1.0 / L[i * size + i];
    }
    return -1;
}

void BlockCholesky::measure_rows() {
    for (const ColumnOf& column : columns_) {
        const int size = sizes_[column.block], row = begin_[column.block];
        for (int i = 0; i < size; ++i) diagonal_[row + i] = at(column.diagonal)[i * size + i] + hidden_[row + i];
    }
}

// Subtracts the products of a column's blocks, R wide, from later columns.
template <int R> void BlockCholesky::subtract_products(const ColumnOf& column) {
    constexpr std::size_t size = blocks::eight * R;
    const std::size_t* update = column.updates.data();
    for (std::size_t a = 0; a < column.below.size(); ++a) {
        const double* X = at(column.below[a].offset);
        const int rows = sizes_[column.below[a].block];
        blocks::transpose<R>(X, rows, transposed_.data() + size * a);
        for (std::size_t b = 0; b <= a; ++b, ++update)
            blocks::subtract<R>(at(*update), X, rows, transposed_.data() + size * b, sizes_[column.below[b].block]);
    }
}

int BlockCholesky::factor(double smallest) {
    smallest_pivot_ = nearness_ = 1.0;
    measure_rows();
    for (const ColumnOf& column : columns_) {
        const int failed = factor_diagonal(column, smallest);
        if (failed >= 0) return failed;
        const double* L = at(column.diagonal);
        const double* reciprocal = reciprocal_.data() + begin_[column.block];
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
template <class Out> void BlockCholesky::forward(double* x, Out&& left_out) const {
    const bool all = !leaves_out();
    for (const ColumnOf& column : columns_)
        blocks::with_width(sizes_[column.block], [&](auto width) {
            constexpr int R = decltype(width)::value;
            const int row = begin_[column.block];
            const double* L = values_.data() + column.diagonal;
            double* part = x + row;
            for (int i = 0; i < R; ++i) {
                for (int k = 0; k < i; ++k) part[i] = multiply_add(-L[i * R + k], part[k], part[i]);
                if (!all && left_out_[row + i]) left_out(part[i]);
                part[i] *= reciprocal_[row + i];
            }
            for (const Entry& entry : column.below) {
                const double* X = values_.data() + entry.offset;
                double* below = x + begin_[entry.block];
                for (int i = 0; i < sizes_[entry.block]; ++i, X += R)
                    for (int k = 0; k < R; ++k) below[i] = multiply_add(-X[k], part[k], below[i]);
            }
        });
}

void BlockCholesky::solve(double* x) const {
    forward(x, [](double) {});
    for (auto column = columns_.rbegin(); column != columns_.rend(); ++column)
        blocks::with_width(sizes_[column->block], [&](auto width) {
            constexpr int R = decltype(width)::value;
            double* part = x + begin_[column->block];
            for (const Entry& entry : column->below) {
                const double* X = values_.data() + entry.offset;
                const double* below = x + begin_[entry.block];
                for (int i = 0; i < sizes_[entry.block]; ++i, X += R)
                    for (int k = 0; k < R; ++k) part[k] = multiply_add(-X[k], below[i], part[k]);
            }
            const double* L = values_.data() + column->diagonal;
            for (int i = R - 1; i >= 0; --i) {
                for (int k = i + 1; k < R; ++k) part[i] = multiply_add(-L[k * R + i], part[k], part[i]);
                part[i] *= reciprocal_[begin_[column->block] + i];
            }
        });
}

double BlockCholesky::contradiction(double* x) const {
    double most = 0.0;
    forward(x, [&most](double rest) { most = max(most, abs(rest)); });
    return most;
}

}  // namespace mbproj
