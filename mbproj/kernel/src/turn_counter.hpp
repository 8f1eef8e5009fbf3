// Whole turns of the joints' angles, counted step by step.
#pragma once

#include <cmath>

#include "loads.hpp"

namespace mbproj {

// What is known of the angles at one point of the motion: where each vector stands, how fast it turns, and its turns.
struct Counted {
    struct Angle {
        double cosine = 1.0, sine = 0.0, speed = 0.0;
        double value() const { return std::atan2(sine, cosine); }
    };
    std::vector<Angle> angles;
    std::vector<long> turns;

    // Where the coordinates are now, and how fast they change.
    void remember(double t, Turning& turning) const {
        turning.t = t;
        turning.value.resize(turns.size());
        turning.speed.resize(turns.size());
        for (std::size_t i = 0; i < angles.size(); ++i) {
            turning.value[i] = angles[i].value() + 2.0 * M_PI * static_cast<double>(turns[i]);
            turning.speed[i] = angles[i].speed;
        }
    }
};

template <int D> class TurnCounter {
public:
    explicit TurnCounter(const Model<D>& model) : model_(model) {
        for (std::size_t i = 0; i < model.coordinates.instances.size(); ++i)
            if (model.counts_turns[i]) counting_.push_back(static_cast<int>(i));
    }

    Counted start(const Pose<D>& pose, const Motion<D>& motion, std::vector<long> turns) const {
        Counted counted{std::vector<Counted::Angle>(turns.size()), std::move(turns)};
        for (const int i : counting_) counted.angles[i] = look(i, pose, motion);
        return counted;
    }

    // From one point to another, `h` later.
    void advance(Counted& counted, const Pose<D>& pose, const Motion<D>& motion, double h) const {
        for (const int i : counting_) {
            const Counted::Angle before = counted.angles[i], now = look(i, pose, motion);
            counted.angles[i] = now;
            if (before.cosine > 0.0 && now.cosine > 0.0 && h * (std::abs(before.speed) + std::abs(now.speed)) < 2.0)
                continue;  // far from ±π, where the value jumps, at both ends and in between
            // The rates at both ends predict the change, so that more than half a turn in a step is counted right.
            const double expected = before.value() + 0.5 * h * (before.speed + now.speed);
            counted.turns[i] += std::lrint((expected - now.value()) / (2.0 * M_PI));
        }
    }

private:
    Counted::Angle look(int index, const Pose<D>& pose, const Motion<D>& motion) const {
        const Instance& p = model_.coordinates.instances[index];
        Point<D> x[3], x_dot[3];
        for (int s = 0; s < 3; ++s) {
            const Attachment<D>& a = model_.coordinates.attachments[p.slots[s]];
            x[s].noalias() = pose[a.body].rotation * a.local;
            x_dot[s] = turned_by(motion[a.body].omega, x[s]);
        }
        const double cosine = x[2].dot(x[0]), sine = x[2].dot(x[1]);
        const double cosine_dot = x_dot[2].dot(x[0]) + x[2].dot(x_dot[0]);
        const double sine_dot = x_dot[2].dot(x[1]) + x[2].dot(x_dot[1]);
        return {cosine, sine, (cosine * sine_dot - sine * cosine_dot) / (cosine * cosine + sine * sine)};
    }

    const Model<D>& model_;
    std::vector<int> counting_;
};

}  // namespace mbproj
