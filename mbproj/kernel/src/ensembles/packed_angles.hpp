// The whole turns of the joints' angles in several cases at once, as `TurnCounter` counts them. A lane leaves where the
// rates at both ends of a step cannot tell its turns.
#pragma once

#include <array>
#include <cmath>

#include "ensembles/packed_equations.hpp"
#include "steppers/stepper.hpp"

namespace mbproj {

template <class P> class PackedAngles final {
public:
    using Vector = std::vector<Pack>;

    explicit PackedAngles(const PackedEquations<P>& equations)
        : equations_(equations), turned_(equations.model().thresholds.turns_told),
          followed_(equations.model().layout.followed), count_(equations.model().coordinates.instances.size()) {
        const Model<P>& model = equations.model();
        for (std::size_t i = 0; i < count_; ++i) {
            if (!model.counts_turns[i]) continue;
            counting_.push_back({static_cast<int>(i), -1});
            for (std::size_t k = 0; k < model.driven.size(); ++k)
                if (model.driven[k].coordinate == static_cast<int>(i)) counting_.back().motion = static_cast<int>(k);
        }
        now_.resize(counting_.size()), before_ = now_;
        for (std::vector<long>& turns : turns_) turns.assign(count_, 0);
        turns_before_ = turns_;
    }

    void set_turns(int lane, std::vector<long> turns) { turns_[lane] = std::move(turns); }
    // The lanes that are in begin at the state y, in place.
    void start(Vector& y) {
        for (std::size_t c = 0; c < counting_.size(); ++c) now_[c] = chosen(angle_now(c), now_[c]);
        follow(y);
    }
    // A step begins.
    void begin() { before_ = now_, turns_before_ = turns_; }
    // Before the state y at t is closed: sets angles that are followed and driven to the values of their motions.
    void lead(PackedEquations<P>& equations, const Pack& t, Vector& y) const {
        if (!followed_.size || equations.drive().empty()) return;
        equations.set_pose(t, y.data());
        for (const Counting& each : counting_)
            if (each.motion >= 0) y[followed_.first + each.coordinate] = equations.drive().prescribed(each.motion);
    }

    // Counts turns over a step of size h from y to y_new, the state in place.
    void advance(const Pack& h, const Vector& y, Vector& y_new) {
        for (std::size_t c = 0; c < counting_.size(); ++c) {
            const Angle &before = before_[c], now = angle_now(c);
            const bool led = counting_[c].motion >= 0;
            const Pack most =
                led ? 2.0 * abs(now.prescribed - before.prescribed) : h * (abs(before.at.speed) + abs(now.at.speed));
            const Mask stays = Mask(most < 2.0) & ((Mask(before.at.cosine > 0.0) & (now.at.cosine > 0.0)) |
                                                   Mask(before.at.sine * now.at.sine > 0.0));
            now_[c] = chosen(now, before);
            const Mask looks = Lanes::in() & ~stays;
            for (int k = 0; k < pack_width; ++k) {
                if (!looks[k]) continue;
                const int of_y = followed_.first + counting_[c].coordinate;
                count_turns(c, k, now, h[k], followed_.size ? y_new[of_y][k] - y[of_y][k] : not_a_number);
            }
        }
        follow(y_new);
    }

    // The angles at the end of the last counted step, or at its start.
    std::vector<double> values(int lane) const { return values(lane, now_, turns_); }
    template <class Counted> void write_end(int lane, Counted& counted) const { write(lane, now_, turns_, counted); }
    template <class Counted> void write_begin(int lane, Counted& counted) const {
        write(lane, before_, turns_before_, counted);
    }
    // The angles at the part s of the last counted step, of size h, for y in place: near the cubics through both ends.
    std::vector<double> inside(int lane, double s, double h, const Vector& y) const {
        const std::vector<double> first = values(lane, before_, turns_before_), last = values(lane);
        std::vector<double> found = values(lane, {}, turns_);
        const double rest = 1.0 - s;
        for (std::size_t c = 0; c < counting_.size(); ++c) {
            const auto [i, motion] = counting_[c];
            double expected = rest * rest * ((1.0 + 2.0 * s) * first[i] + s * h * before_[c].at.speed[lane]) +
                              s * s * ((1.0 + 2.0 * rest) * last[i] - rest * h * now_[c].at.speed[lane]);
            if (motion >= 0)
                expected = equations_.drive().prescribed(motion)[lane];
            else if (followed_.size)
                expected = y[followed_.first + i][lane];
            const double here = angle(angle_now(c), lane);
            double off;
            found[i] = with_turns(here, turns_between(expected, here, off));
        }
        return found;
    }

private:
    struct Counting {
        int coordinate, motion;
    };
    struct Angle {
        JointAngle<P> at;
        Pack prescribed = 0.0;
    };
    using Turns = std::array<std::vector<long>, pack_width>;

    static double with_turns(double angle, long turns) { return angle + 2.0 * M_PI * static_cast<double>(turns); }
    static double angle(const Angle& of, int lane) { return std::atan2(of.at.sine[lane], of.at.cosine[lane]); }
    static long turns_between(double expected, double value, double& off) {
        const double more = std::nearbyint((expected - value) / (2.0 * M_PI));
        off = std::abs(value + 2.0 * M_PI * more - expected);
        return std::lrint(more);
    }
    // The angles of all coordinates; for those that count no turns, the turns alone.
    std::vector<double> values(int lane, const std::vector<Angle>& angles, const Turns& turns) const {
        std::vector<double> found;
        for (const long each : turns[lane]) found.push_back(with_turns(0.0, each));
        for (std::size_t c = 0; c < angles.size(); ++c) {
            const int i = counting_[c].coordinate;
            found[i] = with_turns(angle(angles[c], lane), turns[lane][i]);
        }
        return found;
    }
    template <class Counted>
    void write(int lane, const std::vector<Angle>& angles, const Turns& turns, Counted& counted) const {
        counted.angles.resize(count_);
        for (std::size_t c = 0; c < counting_.size(); ++c) {
            const auto& [at, prescribed] = angles[c];
            auto& to = counted.angles[counting_[c].coordinate];
            to.cosine = at.cosine[lane], to.sine = at.sine[lane], to.speed = at.speed[lane];
            to.prescribed = prescribed[lane];
        }
        counted.turns = turns[lane];
    }
    Angle angle_now(std::size_t c) const {
        const auto [coordinate, motion] = counting_[c];
        return {equations_.angle(coordinate), motion < 0 ? Pack(0.0) : equations_.drive().prescribed(motion)};
    }
    static Angle chosen(const Angle& now, const Angle& before) {
        const Mask in = Lanes::in();
        return {{where(in, now.at.cosine, before.at.cosine), where(in, now.at.sine, before.at.sine),
                 where(in, now.at.speed, before.at.speed)},
                where(in, now.prescribed, before.prescribed)};
    }
    // `integrated`: how far the angle has turned where y follows it, else NaN.
    void count_turns(std::size_t c, int lane, const Angle& now, double h, double integrated) {
        const Angle& before = before_[c];
        const bool led = counting_[c].motion >= 0;
        const double from = angle(before, lane), to = angle(now, lane);
        const double turned = led ? now.prescribed[lane] - before.prescribed[lane]
                                  : 0.5 * h * (before.at.speed[lane] + now.at.speed[lane]);
        double off;
        long more = turns_between(from + turned, to, off);
        if (off > turned_ && !led) more = turns_between(from + integrated, to, off);
        if (!(off <= turned_)) return Lanes::leave(lane);
        turns_[lane][counting_[c].coordinate] += more;
    }
    // Sets angles that are followed to their counted values.
    void follow(Vector& y) const {
        for (std::size_t c = 0; followed_.size && c < counting_.size(); ++c) {
            const int i = counting_[c].coordinate;
            for (int k = 0; k < pack_width; ++k)
                if (Lanes::in()[k]) y[followed_.first + i].set(k, with_turns(angle(now_[c], k), turns_[k][i]));
        }
    }

    const PackedEquations<P>& equations_;
    const double turned_;
    const Block followed_;  // in y
    const std::size_t count_;
    std::vector<Counting> counting_;
    std::vector<Angle> now_, before_;
    Turns turns_, turns_before_;
};

}  // namespace mbproj
