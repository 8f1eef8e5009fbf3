// The side of a singular pose on which a mechanism without degrees of freedom is: the sign of the determinant of the square
// matrix G of the rows held. It is taken block by block, since two blocks that change at once leave the whole sign as it is. A
// sign changes only where branches of the motion cross. Where two branches meet, as at a dead centre, they have opposite signs
// (Allgower & Georg, Numerical Continuation Methods, 1990, sect. 8.1).
#pragma once

#include <limits>
#include <vector>

#include "model/decompositions.hpp"
#include "model/irreducible_blocks.hpp"
#include "solver/equations_of_motion.hpp"

namespace mbproj {

template <class D> class BranchSign final {
public:
    using S = Size<D>;
    using Signs = std::vector<int>;  // the signs of the blocks, 0 where one is singular

    explicit BranchSign(const Model<D>& model) : model_(model) {}

    // Whether a sign differs between (t, y) and a later state, the state in place. False where a sign is unknown.
    bool changes(EquationsOfMotion<D>& equations, double t, const double* y, double t_new, const double* y_new) {
        const std::vector<int>& left_out = equations.solver().left_out();
        if (left_out != seen_for_ || at_.empty()) find_blocks(left_out);
        if (t == last_.t) std::swap(first_, last_);
        last_ = {t_new, signs(equations.pose())};
        if (t != first_.t) {
            equations.set_pose(t, y);
            first_ = {t, signs(equations.pose())};
            equations.set_pose(t_new, y_new);
        }
        for (std::size_t b = 0; b < last_.signs.size(); ++b)
            if (first_.signs[b] * last_.signs[b] < 0) return true;
        return false;
    }

private:
    struct Seen {
        double t = std::numeric_limits<double>::quiet_NaN();
        Signs signs;
    };
    // The block of a row or a column, and its place in the block.
    struct At {
        int block = -1, place = 0;
    };

    // Finds the blocks of G without these rows; none where G is not square.
    void find_blocks(const std::vector<int>& left_out) {
        seen_for_ = left_out, first_ = last_ = {};
        const int size = S::freedoms * model_.size();
        at_.assign(model_.constraints.rows, {}), columns_.assign(size, {}), sizes_.clear();
        std::vector<std::vector<int>> columns;
        std::vector<int> rows;
        for (const Joint& joint : model_.joints)
            for (int row = joint.row; row < joint.row + joint.rows && row < model_.constraints.rows; ++row) {
                if (std::binary_search(left_out.begin(), left_out.end(), row)) continue;
                rows.push_back(row);
                columns.emplace_back();
                for (const int body : joint.bodies)
                    for (int c = 0; c < S::freedoms; ++c) columns.back().push_back(S::freedoms * body + c);
            }
        if (static_cast<int>(rows.size()) != size) return;
        const IrreducibleBlocks blocks(columns);
        sizes_.assign(blocks.count(), 0);
        for (int column = 0; column < size && blocks.count(); ++column) {
            const int block = blocks.of_column(column), place = sizes_[block]++;
            columns_[column] = at_[rows[blocks.row_of(column)]] = {block, place};
        }
    }

    Signs signs(const Pose<D>& pose) {
        entries_.resize(sizes_.size());
        for (auto& entries : entries_) entries.clear();
        for (const Joint& joint : model_.joints) {
            if (joint.row >= model_.constraints.rows || sizes_.empty()) break;
            for (const int body : joint.bodies) {
                mbproj::jacobian<D>(model_, pose, joint, body, part_);
                for (int r = 0; r < joint.rows; ++r)
                    for (int c = 0; c < S::freedoms; ++c) {
                        const At &row = at_[joint.row + r], &column = columns_[S::freedoms * body + c];
                        if (row.block >= 0 && row.block == column.block && part_(r, c) != 0.0)
                            entries_[row.block].push_back({row.place, column.place, part_(r, c)});
                    }
            }
        }
        Signs found;
        for (std::size_t b = 0; b < sizes_.size(); ++b) found.push_back(determinant_sign(sizes_[b], entries_[b]));
        return found;
    }

    const Model<D>& model_;
    std::vector<int> seen_for_;  // the rows left out for which the blocks were found
    std::vector<At> at_, columns_;
    std::vector<int> sizes_;
    Seen first_, last_;  // the start and the end of the last step that was tried
    std::vector<std::vector<Entry>> entries_;
    Matrix<6, S::freedoms> part_;
};

}  // namespace mbproj
