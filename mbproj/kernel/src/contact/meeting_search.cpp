#include "contact/meeting_search.hpp"

namespace mbproj {

bool MeetingSearch::is_below(const Margins& margins) const {
    for (std::size_t k = 0; k < slack_.size(); ++k)
        if (margins[k].value < -slack_[k]) return true;
    return false;
}

int MeetingSearch::worst(const Margins& margins) const {
    std::size_t found = 0;
    for (std::size_t k = 1; k < slack_.size(); ++k)
        if (margins[k].value / slack_[k] < margins[found].value / slack_[found]) found = k;
    return static_cast<int>(found);
}

double MeetingSearch::between(double low, double y_low, double high, double y_high, double old, double y_old) {
    const double line = high - y_high * (high - low) / (y_high - y_low);
    const double bend = (old - low) / (y_old - y_low) - (high - low) / (y_high - y_low);
    const double guess = line + y_low * y_high * bend / (y_old - y_high);
    return guess > low && guess < high ? guess : line;
}

}  // namespace mbproj
