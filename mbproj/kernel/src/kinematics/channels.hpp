// The variables of the scene's functions at a state: the time, the coordinate and rate of a force, and channels, as in
// mbproj.equations.instant.
#pragma once

#include "kinematics/coordinate.hpp"

namespace mbproj {

template <class D> class Channels final {
public:
    explicit Channels(const Model<D>& model) : model_(model), variables_(law_variables + model.channels.size()) {
        for (std::size_t c = 0; c < model.channels.size(); ++c)
            if (model.channels[c].kind == ChannelKind::state) states_.push_back(c);
        for (int p = 0; p < model.programs.size(); ++p) named_.push_back(model.programs.named(p));
    }

    // Sets the channels for y at t, whose pose and motion are in place. y must stay valid while they are used.
    Channels& set(Scalar<D> t, const Scalar<D>* y, const Pose<D>& pose, const Motion<D>& motion) {
        expected_ = y + model_.layout.followed.first;
        variables_[0] = {t, 1.0, 0.0};
        for (std::size_t c = 0; c < model_.channels.size(); ++c)
            variables_[law_variables + c].x = at(model_.channels[c], y, pose, motion);
        return *this;
    }
    // Sets the channels where only the states differ from the last call.
    void set_states(const Scalar<D>* y) {
        for (const std::size_t c : states_)
            variables_[law_variables + c].x = y[model_.layout.states.first + model_.channels[c].index];
    }
    // The variables of a program that acts along a coordinate with this value and rate.
    Series<Scalar<D>>* variables(Scalar<D> value = 0.0, Scalar<D> rate = 0.0) {
        variables_[1].x = value;
        variables_[2].x = rate;
        return variables_.data();
    }
    Scalar<D> time() const { return variables_[0].x; }
    // A joint's coordinate as y follows it, to less than half a turn.
    Scalar<D> expected(int coordinate) const { return expected_[coordinate]; }

    // The slopes of a program by the variables from `first` to `end`, at their current values, on the branches `held`.
    void slopes(int program, const double* held, std::size_t first, std::size_t end, Scalar<D>* found) {
        std::fill_n(found, end - first, Scalar<D>(0.0));
        variables_[0].d = 0.0;
        for (const std::size_t v : named_[program]) {
            if (v < first || v >= end) continue;
            variables_[v].d = 1.0;
            found[v - first] = model_.programs.slope(program, variables_.data(), held);
            variables_[v].d = 0.0;
        }
        variables_[0].d = 1.0;
    }
    std::size_t size() const { return model_.channels.size(); }

private:
    Scalar<D> at(const Channel& channel, const Scalar<D>* y, const Pose<D>& pose, const Motion<D>& motion) const {
        if (channel.kind == ChannelKind::state) return y[model_.layout.states.first + channel.index];
        const Coordinate<D> coordinate(model_.coordinates, channel.index, pose);
        return channel.kind == ChannelKind::rate    ? coordinate.rate(motion)
               : model_.counts_turns[channel.index] ? coordinate.value(expected_[channel.index])
                                                    : coordinate.value();
    }

    const Model<D>& model_;
    std::vector<Series<Scalar<D>>> variables_;
    std::vector<std::size_t> states_;              // which channels are states
    std::vector<std::vector<std::size_t>> named_;  // the variables of each program
    const Scalar<D>* expected_ = nullptr;
};

}  // namespace mbproj
