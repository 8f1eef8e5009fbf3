#include "step/turn_counter.hpp"

namespace mbproj {

TurnCounter::TurnCounter(Equations& equations, const Stepper& stepper)
    : model_(equations.mechanism()), followed_(model_.layout.followed), equations_(equations), stepper_(stepper) {
    std::vector<int> motion(model_.coordinate_count(), -1);
    for (int k = 0; k < model_.driven_count(); ++k) motion[model_.driven_coordinate(k)] = k;
    for (std::size_t i = 0; i < motion.size(); ++i)
        if (model_.counts_turns[i]) counting_.push_back({static_cast<int>(i), motion[i]});
}

TurnCounter::Counted TurnCounter::start(std::vector<long> turns, double t, Vector& y) const {
    Counted counted{std::vector<Angle>(turns.size()), std::move(turns)};
    for (const Counting& each : counting_) counted.angles[each.coordinate] = angle_now(each);
    follow(counted, y);
    equations_.set_pose(t, y.data());
    equations_.start_teeth();
    return counted;
}

void TurnCounter::take_speeds(Counted& counted) const {
    for (const Counting& each : counting_)
        counted.angles[each.coordinate].speed = equations_.angle(each.coordinate).speed;
}

void TurnCounter::lead(double t, Vector& y) const {
    if (!followed_.size || model_.driven_count() == 0) return;
    equations_.set_pose(t, y.data());
    for (const Counting& each : counting_)
        if (each.motion >= 0) y[followed_.first + each.coordinate] = equations_.prescribed(each.motion);
}

Slip TurnCounter::advance(Counted& counted, double t, const Vector& y, double t_new, Vector& y_new) const {
    Slip worst;
    const double h = t_new - t;
    for (const Counting& each : counting_) {
        const int i = each.coordinate;
        const Angle before = counted.angles[i], now = angle_now(each);
        const bool led = each.motion >= 0;
        double turned = led ? now.prescribed - before.prescribed : 0.5 * h * (before.speed + now.speed);
        const double most = led ? 2.0 * std::abs(turned) : h * (std::abs(before.speed) + std::abs(now.speed));
        counted.angles[i] = now;
        if (most < 2.0 && ((before.cosine > 0.0 && now.cosine > 0.0) || before.sine * now.sine > 0.0))
            continue;  // has not crossed ±π, where the value jumps, or has come back
        double off = 0.0;
        long more = turns(before.value() + turned, now.value(), off);
        if (off > model_.thresholds.turns_told && !led) {
            turned = followed_.size ? y_new[followed_.first + i] - y[followed_.first + i]
                                    : rotation(each, t, y, t_new, y_new);
            more = turns(before.value() + turned, now.value(), off);
        }
        counted.turns[i] += more;
        if (!(off <= std::max(model_.thresholds.turns_told, worst.off))) worst = {i, std::abs(turned), off};
    }
    follow(counted, y_new);
    return worst;
}

Slip TurnCounter::far(const Counted& counted, double h) const {
    Slip found;
    for (const Counting& each : counting_) {
        const double turned = h * std::abs(counted.angles[each.coordinate].speed);
        if (turned > std::max(M_PI, found.turned)) found = {each.coordinate, turned, 0.0};
    }
    return found;
}

TurnCounter::Counted TurnCounter::inside(const Counted& before, double t, const Counted& after, double t_new,
                                         double time, const Vector& y) const {
    Counted found = before;
    const double h = t_new - t, s = (time - t) / h, rest = 1.0 - s;
    for (const Counting& each : counting_) {
        const int i = each.coordinate;
        double expected = rest * rest * ((1.0 + 2.0 * s) * before.value(i) + s * h * before.angles[i].speed) +
                          s * s * ((1.0 + 2.0 * rest) * after.value(i) - rest * h * after.angles[i].speed);
        if (each.motion >= 0)
            expected = equations_.prescribed(each.motion);
        else if (followed_.size)
            expected = y[followed_.first + i];
        double off;
        found.angles[i] = angle_now(each);
        found.turns[i] = turns(expected, found.angles[i].value(), off);
    }
    return found;
}

long TurnCounter::turns(double expected, double value, double& off) {
    const double more = std::nearbyint((expected - value) / (2.0 * M_PI));
    off = std::abs(value + 2.0 * M_PI * more - expected);
    return std::lrint(more);
}

void TurnCounter::follow(const Counted& counted, Vector& y) const {
    if (!followed_.size) return;
    for (const Counting& each : counting_) y[followed_.first + each.coordinate] = counted.value(each.coordinate);
}

double TurnCounter::rotation(const Counting& each, double t, const Vector& y, double t_new, const Vector& y_new) const {
    const double h = t_new - t;
    double total = 0.0;
    stepper_.quadrature(t, y, h, [&](double weight, double time, const Vector& state) {
        equations_.set_pose(time, state.data());
        equations_.set_velocities(state.data(), false);
        total += h * weight * angle_now(each).speed;
    });
    equations_.set_pose(t_new, y_new.data());
    equations_.set_velocities(y_new.data(), false);
    return total;
}

}  // namespace mbproj
