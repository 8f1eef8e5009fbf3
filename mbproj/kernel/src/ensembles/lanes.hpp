// The data of each lane of an ensemble: the case that it runs, and its largest values.
#pragma once

#include <optional>
#include <vector>

#include "ensembles/pack.hpp"
#include "stepping/samples.hpp"
#include "stepping/schedule.hpp"

namespace mbproj {

// The case of a lane, by its number; its time, its next step, its counters and its samples.
struct Lane {
    std::size_t number = 0;
    std::optional<Schedule> schedule;
    std::optional<StepSizeControl> control;
    double t = 0.0, h = 0.0;
    Target to{};
    Counters counters{};
    SampleBlock samples;
    // The start of the current step.
    struct Begin {
        double h;
        StepSizeControl::Saved control;
        Counters counters;
        std::size_t samples;
    } begin{};
};

// The largest value so far of each lane, its row, and when.
struct PackedPeak {
    Pack value = 0.0, row = 0.0, time = 0.0;
    void watch(const Pack* rows, int count, const Pack& t) {
        const Mask in = Lanes::in();
        for (int r = 0; r < count; ++r) {
            const Pack size = abs(rows[r]);
            const Mask higher = in & (size > value);
            value = where(higher, size, value);
            row = where(higher, static_cast<double>(r), row);
            time = where(higher, t, time);
        }
    }
    void clear(int lane) { value.set(lane, 0.0), row.set(lane, 0.0), time.set(lane, 0.0); }
    Peak of(int lane) const { return {value[lane], static_cast<long>(row[lane]), time[lane]}; }
};

// `Peaks` of each lane.
struct PackedPeaks {
    PackedPeak position, joint, velocity;
    void watch(const Pack* C, const Pack* C_dot, int rows, int driven, const Pack& t) {
        position.watch(C, rows, t);
        if (driven > 0) joint.watch(C, rows - driven, t);
        velocity.watch(C_dot, rows, t);
    }
    void clear(int lane) { position.clear(lane), joint.clear(lane), velocity.clear(lane); }
    Peaks of(int lane, int driven) const {
        return {position.of(lane), (driven > 0 ? joint : position).of(lane), velocity.of(lane)};
    }
};

// The numbers of one lane.
inline std::vector<double> numbers_of(const std::vector<Pack>& packs, int lane) {
    std::vector<double> found;
    for (const Pack& number : packs) found.push_back(number[lane]);
    return found;
}
inline Eigen::VectorXd vector_of(const std::vector<Pack>& packs, int lane) {
    Eigen::VectorXd found(packs.size());
    for (std::size_t i = 0; i < packs.size(); ++i) found[i] = packs[i][lane];
    return found;
}
// Copies `from` to `to` in the lanes that are in.
inline void take_over(std::vector<Pack>& to, const std::vector<Pack>& from) {
    const Mask in = Lanes::in();
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = where(in, from[i], to[i]);
}

}  // namespace mbproj
