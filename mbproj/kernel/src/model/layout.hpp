// Where in y each block is, as mbproj.model.layout has it: the bodies' state, states of elements, quadratures, angles that
// are followed. Blocks whose errors are controlled come first.
#pragma once

#include <vector>

namespace mbproj {

// Numbers of y, one after another.
struct Block {
    int first = 0, size = 0;
    int end() const { return first + size; }
};

struct Layout {
    Block bodies, states, quadratures, followed;
    std::vector<double> scale;  // what the absolute tolerance is relative to, of the blocks that are controlled
    std::vector<double> start;  // of all blocks: with what a run begins, 0 where it is told that
    int size() const { return static_cast<int>(start.size()); }
    int controlled() const { return static_cast<int>(scale.size()); }
    // Whether angles are integrated from step to step, so that each stage knows how far the wheels have turned.
    bool follows() const { return followed.size > 0; }
};

}  // namespace mbproj
