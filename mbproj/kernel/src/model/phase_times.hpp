// The time that each phase of a run takes. Phases are timed in every 64th step only, which costs next to nothing.
#pragma once

#include <array>
#include <chrono>

namespace mbproj {

enum class Phase : int { evaluation, position, velocity, rest };
constexpr int phase_count = 4;

class Phases final {
public:
    void begin(long step) {
        active_ = step % 64 == 0;
        if (active_) last_ = Clock::now();
    }
    // The time since the last mark belongs to this phase.
    void mark(Phase phase) {
        if (!active_) return;
        const auto now = Clock::now();
        seconds_[static_cast<int>(phase)] += std::chrono::duration<double>(now - last_).count();
        last_ = now;
    }
    const std::array<double, phase_count>& seconds() const { return seconds_; }

private:
    using Clock = std::chrono::steady_clock;
    std::array<double, phase_count> seconds_{};
    Clock::time_point last_{};
    bool active_ = false;
};

}  // namespace mbproj
