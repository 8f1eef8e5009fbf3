// Contacts of rigid stops as plain data: their laws, which hold, and what is recorded of them.
#pragma once

#include <limits>
#include <vector>

namespace mbproj {

// A rigid stop: its side, its restitution, how far its gap may be below zero, and what gaps are measured against.
struct StopLaw {
    double side, restitution, slack, size;
};

enum class Happening : int { impact, push, rest, contact, release };

// What is recorded: when, which stop, what, where to; of an impact the impulse and the energy that it takes.
struct ContactEvent {
    double t;
    int stop;
    Happening what;
    int direction;
    double impulse, energy;
};

// What the next step depends on: the stops that hold, how hard they push at most, the fastest motion so far, when something was met
// last and how often then; what impacts have lost and motions have worked in no time; how many events were recorded.
struct ContactState {
    std::vector<int> held;
    double push = 0.0, fastest = 0.0, met_at = -std::numeric_limits<double>::infinity();
    int met_often = 0;
    double lost = 0.0, work = 0.0;
    long events = 0;
};

}  // namespace mbproj
