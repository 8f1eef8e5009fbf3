// The numbers that were chosen, not derived. Their values, units, reasons and sources stand in `mbproj.thresholds`, which fills
// this struct; `mbproj info --thresholds` prints them.
#pragma once

namespace mbproj {

struct Thresholds {
    // mbproj/thresholds/dependence.py
    double smallest_pivot, near_dependent, near_branch, choice_from, choice_step, choice_to, tied, decline;
    int most_dense_rows;
    // mbproj/thresholds/passages.py
    double least_violation, passing, nearing, agreement, agreed_tolerances, shorter, branch_change, lost_velocity,
        lost_way, at_rest, rest_rate, nearly_closed, told_part, told_way, crossed_way;
    int most_shorter;
    // mbproj/thresholds/elimination.py
    double no_inertia, no_mass, asymmetry, most_cancelled, parallel, lent_part, settled_part, settled_enough,
        ill_conditioned, refined_part;
    int most_settling, most_refining, fewest_shared, fewest_passed;
    // mbproj/thresholds/closing.py
    double closed_to, closed_grains, paper_tolerance, round_off_grains, slow, stagnation, widest_turn, tighter, stiffer,
        lent_moment, shortest, open_limit, lost_limit, row_rests, row_singular, row_refused, row_grain, row_grains,
        row_tolerated;
    int tightenings, stiffenings;
    // mbproj/thresholds/steps.py
    double safety, smallest_change, largest_change, least_error, least_error_before, part_after_break, turns_told,
        most_turned, located, glance, widest_polishing, bracketed, beside, chatter, newton_part, newton_fixed,
        newton_floor, secant_change, softened, first_contraction, least_contraction;
    int most_polishing, most_chatter, most_newton, free_passes, most_halvings, branch_halvings;
    // mbproj/thresholds/contact.py
    double settled_load, middle_unlike, no_push, touching, stop_rests, rest_acceleration, rest_steps, lowest_bounce,
        contact_pulls, creates_energy, on_grid, damped_from, damped_to, balanced_to, slips, springs_give, slips_beyond,
        turned_speed, straight_speed, stop_slack, no_part, met_soon, slides_in;
    int most_load_passes, most_halves, most_meetings;
    // mbproj/thresholds/ropes.py
    double off_sheave, rope_turned;
    // mbproj/thresholds/curves.py
    double overlap;
};

// Calls visit("name", member) for every threshold.
template <class Visit> void each_threshold(Visit&& visit) {
    visit("smallest_pivot", &Thresholds::smallest_pivot);
    visit("near_dependent", &Thresholds::near_dependent);
    visit("near_branch", &Thresholds::near_branch);
    visit("choice_from", &Thresholds::choice_from);
    visit("choice_step", &Thresholds::choice_step);
    visit("choice_to", &Thresholds::choice_to);
    visit("tied", &Thresholds::tied);
    visit("decline", &Thresholds::decline);
    visit("most_dense_rows", &Thresholds::most_dense_rows);
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
    visit("nearly_closed", &Thresholds::nearly_closed);
    visit("told_part", &Thresholds::told_part);
    visit("told_way", &Thresholds::told_way);
    visit("crossed_way", &Thresholds::crossed_way);
    visit("no_inertia", &Thresholds::no_inertia);
    visit("no_mass", &Thresholds::no_mass);
    visit("asymmetry", &Thresholds::asymmetry);
    visit("most_cancelled", &Thresholds::most_cancelled);
    visit("parallel", &Thresholds::parallel);
    visit("lent_part", &Thresholds::lent_part);
    visit("most_settling", &Thresholds::most_settling);
    visit("settled_part", &Thresholds::settled_part);
    visit("settled_enough", &Thresholds::settled_enough);
    visit("ill_conditioned", &Thresholds::ill_conditioned);
    visit("refined_part", &Thresholds::refined_part);
    visit("most_refining", &Thresholds::most_refining);
    visit("fewest_shared", &Thresholds::fewest_shared);
    visit("fewest_passed", &Thresholds::fewest_passed);
    visit("closed_to", &Thresholds::closed_to);
    visit("closed_grains", &Thresholds::closed_grains);
    visit("paper_tolerance", &Thresholds::paper_tolerance);
    visit("round_off_grains", &Thresholds::round_off_grains);
    visit("slow", &Thresholds::slow);
    visit("stagnation", &Thresholds::stagnation);
    visit("widest_turn", &Thresholds::widest_turn);
    visit("tighter", &Thresholds::tighter);
    visit("tightenings", &Thresholds::tightenings);
    visit("stiffer", &Thresholds::stiffer);
    visit("stiffenings", &Thresholds::stiffenings);
    visit("lent_moment", &Thresholds::lent_moment);
    visit("shortest", &Thresholds::shortest);
    visit("open_limit", &Thresholds::open_limit);
    visit("lost_limit", &Thresholds::lost_limit);
    visit("row_rests", &Thresholds::row_rests);
    visit("row_singular", &Thresholds::row_singular);
    visit("row_refused", &Thresholds::row_refused);
    visit("row_grain", &Thresholds::row_grain);
    visit("row_grains", &Thresholds::row_grains);
    visit("row_tolerated", &Thresholds::row_tolerated);
    visit("safety", &Thresholds::safety);
    visit("smallest_change", &Thresholds::smallest_change);
    visit("largest_change", &Thresholds::largest_change);
    visit("least_error", &Thresholds::least_error);
    visit("least_error_before", &Thresholds::least_error_before);
    visit("part_after_break", &Thresholds::part_after_break);
    visit("turns_told", &Thresholds::turns_told);
    visit("off_sheave", &Thresholds::off_sheave);
    visit("rope_turned", &Thresholds::rope_turned);
    visit("overlap", &Thresholds::overlap);
    visit("most_turned", &Thresholds::most_turned);
    visit("located", &Thresholds::located);
    visit("glance", &Thresholds::glance);
    visit("widest_polishing", &Thresholds::widest_polishing);
    visit("most_polishing", &Thresholds::most_polishing);
    visit("bracketed", &Thresholds::bracketed);
    visit("beside", &Thresholds::beside);
    visit("chatter", &Thresholds::chatter);
    visit("most_chatter", &Thresholds::most_chatter);
    visit("newton_part", &Thresholds::newton_part);
    visit("newton_fixed", &Thresholds::newton_fixed);
    visit("newton_floor", &Thresholds::newton_floor);
    visit("most_newton", &Thresholds::most_newton);
    visit("first_contraction", &Thresholds::first_contraction);
    visit("least_contraction", &Thresholds::least_contraction);
    visit("secant_change", &Thresholds::secant_change);
    visit("softened", &Thresholds::softened);
    visit("free_passes", &Thresholds::free_passes);
    visit("most_halvings", &Thresholds::most_halvings);
    visit("branch_halvings", &Thresholds::branch_halvings);
    visit("settled_load", &Thresholds::settled_load);
    visit("middle_unlike", &Thresholds::middle_unlike);
    visit("no_push", &Thresholds::no_push);
    visit("touching", &Thresholds::touching);
    visit("stop_rests", &Thresholds::stop_rests);
    visit("rest_acceleration", &Thresholds::rest_acceleration);
    visit("rest_steps", &Thresholds::rest_steps);
    visit("lowest_bounce", &Thresholds::lowest_bounce);
    visit("contact_pulls", &Thresholds::contact_pulls);
    visit("creates_energy", &Thresholds::creates_energy);
    visit("on_grid", &Thresholds::on_grid);
    visit("damped_from", &Thresholds::damped_from);
    visit("damped_to", &Thresholds::damped_to);
    visit("balanced_to", &Thresholds::balanced_to);
    visit("slips", &Thresholds::slips);
    visit("springs_give", &Thresholds::springs_give);
    visit("slips_beyond", &Thresholds::slips_beyond);
    visit("turned_speed", &Thresholds::turned_speed);
    visit("straight_speed", &Thresholds::straight_speed);
    visit("stop_slack", &Thresholds::stop_slack);
    visit("no_part", &Thresholds::no_part);
    visit("met_soon", &Thresholds::met_soon);
    visit("slides_in", &Thresholds::slides_in);
    visit("most_meetings", &Thresholds::most_meetings);
    visit("most_halves", &Thresholds::most_halves);
    visit("most_load_passes", &Thresholds::most_load_passes);
}

}  // namespace mbproj
