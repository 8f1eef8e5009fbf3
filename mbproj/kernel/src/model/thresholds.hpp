// The numbers that were chosen, not derived. Their values, units, reasons and sources stand in `mbproj.base.thresholds`, which fills
// this struct; `mbproj info --thresholds` prints them.
#pragma once

#include <functional>

namespace mbproj {

// Gives numbers by name while the members of a struct are initialised, each where it is declared; 0 without a source.
class NumbersByName {
public:
    using Source = std::function<double(const char*)>;

protected:
    NumbersByName() = default;
    explicit NumbersByName(const Source& source) : source_(&source) {}
    double number(const char* name) const { return source_ ? (*source_)(name) : 0.0; }
    int whole(const char* name) const { return static_cast<int>(number(name)); }
    void close() { source_ = nullptr; }

private:
    const Source* source_ = nullptr;
};

struct Thresholds : NumbersByName {
    Thresholds() = default;
    explicit Thresholds(const Source& source) : NumbersByName(source) { close(); }

    // mbproj/base/thresholds.py
    double no_digits = number("no_digits"), rounding = number("rounding"), same_written = number("same_written"),
           half_digits = number("half_digits"), rounded = number("rounded");
    int most_passes = whole("most_passes");
    // mbproj/base/thresholds.py
    int most_dense = whole("most_dense");
    // mbproj/base/thresholds.py
    double stop_slack = number("stop_slack"), touching = number("touching"), stop_rests = number("stop_rests"),
           rest_acceleration = number("rest_acceleration"), rest_steps = number("rest_steps"),
           lowest_bounce = number("lowest_bounce"), no_push = number("no_push"),
           contact_pulls = number("contact_pulls"), slips = number("slips"), just_slips = number("just_slips"),
           pushes_along = number("pushes_along"), damped_to = number("damped_to"),
           middle_unlike = number("middle_unlike"), near_miss = number("near_miss"),
           turned_speed = number("turned_speed"), straight_speed = number("straight_speed"),
           creates_energy = number("creates_energy"), on_grid = number("on_grid"), met_soon = number("met_soon"),
           slides_in = number("slides_in");
    int most_halves = whole("most_halves"), most_meetings = whole("most_meetings");
    // mbproj/base/thresholds.py
    double safety = number("safety"), smallest_change = number("smallest_change"),
           largest_change = number("largest_change"), least_error = number("least_error"),
           least_error_before = number("least_error_before"), located = number("located"),
           widest_polishing = number("widest_polishing"), bracketed = number("bracketed"), beside = number("beside"),
           chatter = number("chatter"), turns_told = number("turns_told"), most_turned = number("most_turned"),
           newton_part = number("newton_part"), newton_fixed = number("newton_fixed"),
           newton_floor = number("newton_floor"), first_contraction = number("first_contraction"),
           least_contraction = number("least_contraction"), softened = number("softened");
    int most_polishing = whole("most_polishing"), most_chatter = whole("most_chatter"),
        most_newton = whole("most_newton"), free_passes = whole("free_passes"), most_halvings = whole("most_halvings"),
        branch_halvings = whole("branch_halvings");
    // mbproj/base/thresholds.py
    double row_rests = number("row_rests"), row_refused = number("row_refused"),
           row_tolerated = number("row_tolerated");
    double closed_to = number("closed_to"), closed_grains = number("closed_grains"),
           paper_tolerance = number("paper_tolerance"), round_off_grains = number("round_off_grains"),
           slow = number("slow"), widest_turn = number("widest_turn"), tighter = number("tighter"),
           stiffer = number("stiffer"), open_limit = number("open_limit"), lost_limit = number("lost_limit");
    // mbproj/base/thresholds.py
    double least_violation = number("least_violation"), passing = number("passing"), nearing = number("nearing"),
           agreement = number("agreement"), agreed_tolerances = number("agreed_tolerances"),
           shorter = number("shorter"), branch_change = number("branch_change"),
           lost_velocity = number("lost_velocity"), lost_way = number("lost_way"), at_rest = number("at_rest"),
           rest_rate = number("rest_rate"), told_part = number("told_part"), told_way = number("told_way"),
           crossed_way = number("crossed_way");
    int most_shorter = whole("most_shorter");
    // mbproj/base/thresholds.py
    double lent_part = number("lent_part");
    int fewest_shared = whole("fewest_shared"), fewest_passed = whole("fewest_passed");
    // mbproj/base/thresholds.py
    double overlap = number("overlap");
    // mbproj/base/thresholds.py
    double near_branch = number("near_branch"), decline = number("decline"), choice_from = number("choice_from"),
           tied = number("tied"), no_part = number("no_part");
};

}  // namespace mbproj
