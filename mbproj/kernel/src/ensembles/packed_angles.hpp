// The whole turns of the joints' angles in four cases at once: what `TurnCounter` counts, where no motion drives an angle. A lane of
// which a step cannot tell the turns leaves.
#pragma once

#include <array>
#include <cmath>

#include "ensembles/packed_equations.hpp"

namespace mbproj {

template <class P> class PackedAngles final {
public:
    explicit PackedAngles(const PackedEquations<P>& equations)
        : equations_(equations), turned_(equations.model().thresholds.turns_told),
          count_(equations.model().coordinates.instances.size()) {
        const Model<P>& model = equations.model();
        for (std::size_t i = 0; i < count_; ++i)
            if (model.counts_turns[i]) counting_.push_back(static_cast<int>(i));
        now_.resize(counting_.size()), before_ = now_;
        for (std::vector<long>& turns : turns_) turns.assign(count_, 0);
        turns_before_ = turns_;
    }

    // The lanes that are in begin at the state in place.
    void start() {
        for (std::size_t c = 0; c < counting_.size(); ++c) now_[c] = chosen(look(c), now_[c]);
    }
    void set_turns(int lane, std::vector<long> turns) { turns_[lane] = std::move(turns); }
    const std::vector<long>& turns(int lane) const { return turns_[lane]; }
    std::vector<double> values(int lane) const {
        std::vector<double> found = whole_turns(lane);
        for (std::size_t c = 0; c < counting_.size(); ++c)
            found[counting_[c]] = value(now_[c], lane, turns_[lane][counting_[c]]);
        return found;
    }

    // Over a step of size h to the state in place.
    void advance(const Pack& h) {
        for (std::size_t c = 0; c < counting_.size(); ++c) {
            const JointAngle<P> before = now_[c], now = look(c);
            before_[c] = before;
            const Pack most = h * (abs(before.speed) + abs(now.speed));
            const Mask stays = Mask(most < 2.0) & ((Mask(before.cosine > 0.0) & (now.cosine > 0.0)) |
                                                   Mask(before.sine * now.sine > 0.0));
            now_[c] = chosen(now, before);
            const Mask looks = Lanes::in() & ~stays;
            for (int k = 0; k < pack_width; ++k) {
                turns_before_[k][counting_[c]] = turns_[k][counting_[c]];
                if (looks[k]) tell(c, k, before, now, h[k]);
            }
        }
    }

    // At the part s of the step of size h that was just counted, for the state in place: along the cubics through both ends.
    std::vector<double> inside(int lane, double s, double h) const {
        std::vector<double> found = whole_turns(lane);
        const double rest = 1.0 - s;
        for (std::size_t c = 0; c < counting_.size(); ++c) {
            const int i = counting_[c];
            const double before = value(before_[c], lane, turns_before_[lane][i]);
            const double after = value(now_[c], lane, turns_[lane][i]);
            const double expected =
                rest * rest * ((1.0 + 2.0 * s) * before + s * h * before_[c].speed[lane]) +
                s * s * ((1.0 + 2.0 * rest) * after - rest * h * now_[c].speed[lane]);
            const JointAngle<P> here = look(c);
            double off;
            found[i] = value(here, lane, turns_between(expected, angle(here, lane), off));
        }
        return found;
    }

private:
    std::vector<double> whole_turns(int lane) const {
        std::vector<double> found;
        for (const long turns : turns_[lane]) found.push_back(2.0 * M_PI * static_cast<double>(turns));
        return found;
    }
    static double angle(const JointAngle<P>& at, int lane) { return std::atan2(at.sine[lane], at.cosine[lane]); }
    static double value(const JointAngle<P>& at, int lane, long turns) {
        return angle(at, lane) + 2.0 * M_PI * static_cast<double>(turns);
    }
    static long turns_between(double expected, double value, double& off) {
        const double more = std::nearbyint((expected - value) / (2.0 * M_PI));
        off = std::abs(value + 2.0 * M_PI * more - expected);
        return std::lrint(more);
    }
    JointAngle<P> look(std::size_t c) const { return equations_.angle(counting_[c]); }
    static JointAngle<P> chosen(const JointAngle<P>& now, const JointAngle<P>& before) {
        const Mask in = Lanes::in();
        return {where(in, now.cosine, before.cosine), where(in, now.sine, before.sine),
                where(in, now.speed, before.speed)};
    }
    void tell(std::size_t c, int lane, const JointAngle<P>& before, const JointAngle<P>& now, double h) {
        const double turned = 0.5 * h * (before.speed[lane] + now.speed[lane]);
        double off;
        const long more = turns_between(angle(before, lane) + turned, angle(now, lane), off);
        if (!(off <= turned_)) return Lanes::leave(lane);
        turns_[lane][counting_[c]] += more;
    }

    const PackedEquations<P>& equations_;
    const double turned_;
    const std::size_t count_;
    std::vector<int> counting_;
    std::vector<JointAngle<P>> now_, before_;
    std::array<std::vector<long>, pack_width> turns_, turns_before_;
};

}  // namespace mbproj
