// The numbers that were chosen, not derived. Their values, units, reasons and sources stand in `mbproj.thresholds`, which fills
// this struct; `mbproj info --thresholds` prints them.
#pragma once

namespace mbproj {

struct Thresholds {
    // mbproj/thresholds/__init__.py
    double no_digits, rounding, same_written, half_digits, rounded;
    int most_passes;
    // mbproj/thresholds/poses.py
    int most_dense;
    // mbproj/thresholds/contact.py
    double stop_slack, touching, stop_rests, rest_acceleration, rest_steps, lowest_bounce, no_push, contact_pulls,
        slips, springs_give, damped_to, middle_unlike, turned_speed, straight_speed, creates_energy, on_grid, met_soon,
        slides_in;
    int most_halves, most_meetings;
    // mbproj/thresholds/steps.py
    double safety, smallest_change, largest_change, least_error, least_error_before, located, widest_polishing,
        bracketed, beside, chatter, turns_told, most_turned, newton_part, newton_fixed, newton_floor, first_contraction,
        least_contraction, softened;
    int most_polishing, most_chatter, most_newton, free_passes, most_halvings, branch_halvings;
    // mbproj/thresholds/solution.py
    double row_rests, row_refused, row_tolerated;
    // mbproj/thresholds/solution.py
    double closed_to, closed_grains, paper_tolerance, round_off_grains, slow, widest_turn, tighter, stiffer, open_limit,
        lost_limit;
    // mbproj/thresholds/poses.py
    double least_violation, passing, nearing, agreement, agreed_tolerances, shorter, branch_change, lost_velocity,
        lost_way, at_rest, rest_rate, told_part, told_way, crossed_way;
    int most_shorter;
    // mbproj/thresholds/solution.py
    double lent_part;
    int fewest_shared, fewest_passed;
    // mbproj/thresholds/contact.py
    double overlap;
    // mbproj/thresholds/solution.py
    double near_branch, decline, choice_from, tied, no_part;
};

// Calls visit("name", member) for every threshold.
template <class Visit> void each_threshold(Visit&& visit) {
    visit("no_digits", &Thresholds::no_digits);
    visit("rounding", &Thresholds::rounding);
    visit("same_written", &Thresholds::same_written);
    visit("half_digits", &Thresholds::half_digits);
    visit("rounded", &Thresholds::rounded);
    visit("most_passes", &Thresholds::most_passes);
    visit("most_dense", &Thresholds::most_dense);
    visit("stop_slack", &Thresholds::stop_slack);
    visit("touching", &Thresholds::touching);
    visit("stop_rests", &Thresholds::stop_rests);
    visit("rest_acceleration", &Thresholds::rest_acceleration);
    visit("rest_steps", &Thresholds::rest_steps);
    visit("lowest_bounce", &Thresholds::lowest_bounce);
    visit("no_push", &Thresholds::no_push);
    visit("contact_pulls", &Thresholds::contact_pulls);
    visit("slips", &Thresholds::slips);
    visit("springs_give", &Thresholds::springs_give);
    visit("damped_to", &Thresholds::damped_to);
    visit("middle_unlike", &Thresholds::middle_unlike);
    visit("most_halves", &Thresholds::most_halves);
    visit("turned_speed", &Thresholds::turned_speed);
    visit("straight_speed", &Thresholds::straight_speed);
    visit("creates_energy", &Thresholds::creates_energy);
    visit("on_grid", &Thresholds::on_grid);
    visit("met_soon", &Thresholds::met_soon);
    visit("slides_in", &Thresholds::slides_in);
    visit("most_meetings", &Thresholds::most_meetings);
    visit("safety", &Thresholds::safety);
    visit("smallest_change", &Thresholds::smallest_change);
    visit("largest_change", &Thresholds::largest_change);
    visit("least_error", &Thresholds::least_error);
    visit("least_error_before", &Thresholds::least_error_before);
    visit("located", &Thresholds::located);
    visit("most_polishing", &Thresholds::most_polishing);
    visit("widest_polishing", &Thresholds::widest_polishing);
    visit("bracketed", &Thresholds::bracketed);
    visit("beside", &Thresholds::beside);
    visit("chatter", &Thresholds::chatter);
    visit("most_chatter", &Thresholds::most_chatter);
    visit("turns_told", &Thresholds::turns_told);
    visit("most_turned", &Thresholds::most_turned);
    visit("newton_part", &Thresholds::newton_part);
    visit("newton_fixed", &Thresholds::newton_fixed);
    visit("newton_floor", &Thresholds::newton_floor);
    visit("most_newton", &Thresholds::most_newton);
    visit("first_contraction", &Thresholds::first_contraction);
    visit("least_contraction", &Thresholds::least_contraction);
    visit("softened", &Thresholds::softened);
    visit("free_passes", &Thresholds::free_passes);
    visit("most_halvings", &Thresholds::most_halvings);
    visit("branch_halvings", &Thresholds::branch_halvings);
    visit("row_rests", &Thresholds::row_rests);
    visit("row_refused", &Thresholds::row_refused);
    visit("row_tolerated", &Thresholds::row_tolerated);
    visit("closed_to", &Thresholds::closed_to);
    visit("closed_grains", &Thresholds::closed_grains);
    visit("paper_tolerance", &Thresholds::paper_tolerance);
    visit("round_off_grains", &Thresholds::round_off_grains);
    visit("slow", &Thresholds::slow);
    visit("widest_turn", &Thresholds::widest_turn);
    visit("tighter", &Thresholds::tighter);
    visit("stiffer", &Thresholds::stiffer);
    visit("open_limit", &Thresholds::open_limit);
    visit("lost_limit", &Thresholds::lost_limit);
    visit("least_violation", &Thresholds::least_violation);
    visit("passing", &Thresholds::passing);
    visit("nearing", &Thresholds::nearing);
    visit("agreement", &Thresholds::agreement);
    visit("agreed_tolerances", &Thresholds::agreed_tolerances);
    visit("shorter", &Thresholds::shorter);
    visit("most_shorter", &Thresholds::most_shorter);
    visit("branch_change", &Thresholds::branch_change);
    visit("lost_velocity", &Thresholds::lost_velocity);
    visit("lost_way", &Thresholds::lost_way);
    visit("at_rest", &Thresholds::at_rest);
    visit("rest_rate", &Thresholds::rest_rate);
    visit("told_part", &Thresholds::told_part);
    visit("told_way", &Thresholds::told_way);
    visit("crossed_way", &Thresholds::crossed_way);
    visit("lent_part", &Thresholds::lent_part);
    visit("fewest_shared", &Thresholds::fewest_shared);
    visit("fewest_passed", &Thresholds::fewest_passed);
    visit("overlap", &Thresholds::overlap);
    visit("near_branch", &Thresholds::near_branch);
    visit("decline", &Thresholds::decline);
    visit("choice_from", &Thresholds::choice_from);
    visit("tied", &Thresholds::tied);
    visit("no_part", &Thresholds::no_part);
}

}  // namespace mbproj
