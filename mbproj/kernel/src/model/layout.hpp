// The place of each block in y, as in mbproj.model.layout: bodies, states of elements, quadratures, and angles that are followed.
// Blocks whose errors are controlled come first.
#pragma once

#include <vector>

namespace mbproj {

// Consecutive numbers of y.
struct Block {
    int first = 0, size = 0;
    int end() const { return first + size; }
};

struct Layout {
    Block bodies, states, quadratures, followed;
    std::vector<double> scale;  // magnitudes for the absolute tolerance, of the blocks with error control
    std::vector<double> start;  // values at the start of a run, of all blocks; 0 where the caller gives them
    int size() const { return static_cast<int>(start.size()); }
    int controlled() const { return static_cast<int>(scale.size()); }
    // Whether angles are integrated from step to step, so that each stage knows how far wheels have turned.
    bool follows() const { return followed.size > 0; }
};

}  // namespace mbproj
