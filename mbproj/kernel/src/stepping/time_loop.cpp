#include "stepping/time_loop.hpp"

namespace mbproj {

TimeLoop::TimeLoop(std::unique_ptr<Mechanics> mechanics, Steps steps, const std::vector<double>& y,
                   std::vector<long> turns)
    : mechanics_(std::move(mechanics)), steps_(std::move(steps)), phases_(mechanics_->phases),
      equations_(mechanics_->equations()), model_(equations_.mechanism()), projector_(mechanics_->projector()),
      stepper_(mechanics_->stepper()), turns_(equations_, stepper_), step_end_(equations_, projector_, turns_),
      schedule_(steps_), now_{steps_.start, 0.0, Eigen::Map<const Vector>(y.data(), model_.layout.size()),
                              Vector::Zero(model_.layout.size())},
      trial_(steps_, now_, equations_, projector_, stepper_, step_end_, schedule_, phases_),
      stops_(steps_, now_, equations_, stepper_, step_end_, schedule_, trial_), instants_(equations_), slope_(now_.y),
      copy_(now_.y), copy_slope_(now_.y), lambda_(model_.all_multipliers()), copy_lambda_(lambda_) {
    counted_.turns = std::move(turns);
}

bool TimeLoop::resume(Mark mark) {
    mark_ = std::move(mark);
    return takes(*mark_);
}

const Mark* TimeLoop::mark() {
    if (started_ && steps_.fixed()) take_mark();
    return mark_ ? &*mark_ : nullptr;
}

void TimeLoop::advance(std::size_t samples, double seconds, long attempts) {
    const FlushToZero flush;
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    block.clear();
    if (std::exchange(waits, false)) cross_break();
    const long look = std::max(1L, 64L / (1 + model_.size() / 8));  // steps between two looks at the clock
    pauses = false;
    for (long done = 0; now_.outcome.status == Status::running && block.t.size() < samples && !pauses && !waits;
         ++done) {
        if (done % look == look - 1 && std::chrono::steady_clock::now() > until) break;
        if (!started_)
            begin();
        else if (schedule_.inside())
            sample_inside();
        else if (now_.counters.steps + now_.counters.rejected_steps >= attempts)
            pauses = true, take_mark();
        else
            step();
    }
    if ((began_ || !mark_) && stops_.loses_contacts(now_.outcome)) decide_anew();
    count_factorisations();
}

Mark TimeLoop::here() {
    Mark mark;
    return write(mark), mark;
}

const TimeLoop::Vector* TimeLoop::try_step(double h) {
    const FlushToZero flush;
    begin();
    now_.to = schedule_.to(now_.t, now_.t + h);
    return !now_.outcome.stops() && trial_.stages_and_error() ? stepper_.estimate() : nullptr;
}

void TimeLoop::follow_formulation(std::unique_ptr<Formulation> other) {
    other_ = std::move(other);
    equations_.follow(other_.get());
}

void TimeLoop::begin() {
    started_ = true, ++now_.counters.evaluations;
    equations_.set_pose(now_.t, now_.y.data());
    equations_.set_velocities(now_.y.data(), true);
    peaks.watch(equations_.constraint(), equations_.C_dot(), model_.row_count(), model_.driven_count(), now_.t);
    counted_ = turns_.start(counted_.turns, now_.t, now_.y);
    if (mark_) return go_on_from_mark();
    if (stops_.begins() && !stops_.start(counted_.turns)) return stop({Status::undecided, now_.t});
    if (stops_.watch().any()) stops_.set_start(now_.t, now_.y, counted_.turns);
    if (!equations_.start() || !evaluate(now_.y, true)) return stop_at(now_.t);
    began_ = true, stepper_.first() = slope_, begin_balance();
    now_.h = steps_.step;
    if (!steps_.fixed() && !choose_step(schedule_.left(now_.t))) return;
    sample(now_.t, now_.y, slope_, lambda_, now_.h, counted_);
    equations_.set_window(schedule_.window());
    if (trial_.passes()) events().watch(now_.t, now_.y, schedule_.window());
    if (schedule_.is_after_break() || trial_.locates()) cross_break();
}

void TimeLoop::decide_anew() {
    const Outcome lost = std::exchange(now_.outcome, {});
    const auto change = [this] { return stops_.decide_anew(counted_.turns); };
    if (!began_ && change())
        started_ = false, --now_.counters.evaluations;
    else if (!began_)
        stop({Status::undecided, now_.t});
    else if (change_contacts(change) && std::exchange(left_at_end_, false))
        end_step();
    if (now_.outcome.status == Status::undecided && stops_.policy().undecided().cause == Cause::no_inertia) stop(lost);
}

void TimeLoop::go_on_from_mark() {
    now_.t = mark_->t, now_.h = mark_->h, now_.y = mark_->y, now_.counters = mark_->counters;
    counted_ = mark_->counted, peaks = mark_->peaks;
    trial_.resume(mark_->control, mark_->shortened, mark_->halved);
    schedule_.resume(now_.t, mark_->grid, StepParts(mark_->part));
    if (trial_.locates()) events().hold();
    equations_.set_window(schedule_.window());
    if (mark_->contacts) stops_.resume(*mark_->contacts);
    if (stops_.watch().any()) stops_.set_start(now_.t, now_.y, counted_.turns);
    equations_.set_pose(now_.t, now_.y.data());
    equations_.set_velocities(now_.y.data(), false);
    const bool anew = mark_->anew, carries = stepper_.carries_slope() && !anew;
    if (!equations_.start() || !(carries || evaluate(now_.y, false))) return stop_at(now_.t);
    if (carries) slope_ = mark_->slope;
    began_ = true, stepper_.first() = slope_;
    factorised_before_ = now_.counters.factorisations - equations_.factorisations();
    shaped_ = mark_->shaped;
    if (anew) mark_.reset();  // another run with this method cannot go on from it
}

void TimeLoop::step() {
    if (!steps_.fixed() && !schedule_.resolves(now_.t, now_.h))
        return stop(trial_.lost().stops() ? trial_.lost() : Outcome{Status::vanished, now_.t});
    now_.to = schedule_.target(now_.t, now_.h);
    if (steps_.fixed()) stops_.shorten(stepper_.first());
    if (!steps_.fixed() || now_.to.shaped) take_mark();
    shaped_ = shaped_ || now_.to.shaped;
    phases_.begin(now_.counters.steps + 1);
    if (!trial_.make()) {
        if (trial_.crossing() && !now_.outcome.stops() && cross_event()) go_on();
        return;
    }
    if (!take_step(stops_.watch().any()) && !(meets_ && end_at_meeting())) return;
    if (schedule_.inside() && !trial_.extend()) return;
    if (!steps_.fixed()) now_.h = trial_.control().after_accepted(trial_.error(), now_.to.h);
    phases_.mark(Phase::rest);
    if (!schedule_.inside()) finish_step();
}

bool TimeLoop::take_step(bool watching) {
    schedule_.enter(now_.to);
    if (now_.to.at_break) equations_.set_window({});  // samples there belong to that time itself
    const bool goes_on = accept(watching);
    if (now_.to.at_break) equations_.set_window(schedule_.window());
    return goes_on;
}

bool TimeLoop::accept(bool watching) {
    meets_ = false;
    if (!all_finite(now_.y_new.data(), now_.y_new.size())) return stop({Status::not_finite, now_.to.t}), false;
    ++now_.counters.steps;
    now_.counters.evaluations += stepper_.arrival_cost();
    if (!steps_.fixed() || watching) counted_before_ = counted_;
    const Outcome closed =
        step_end_.close(now_.t, now_.y, now_.to.t, now_.y_new, counted_, trial_.halves(), now_.counters, peaks);
    if (closed.status == Status::untold && !steps_.fixed()) return report_turns(closed), false;
    if (closed.stops()) return stop(closed), false;
    double* lambda = now_.to.due || watching ? lambda_.data() : nullptr;
    if (!equations_.start() || !stepper_.arrive(now_.y_new, slope_, lambda) ||
        (now_.to.at_break && !stepper_.meet_break(now_.to.t, now_.y_new, schedule_.window(), slope_, lambda)))
        return stop_at(now_.to.t), false;
    if (!all_finite(slope_.data(), slope_.size())) return stop({Status::not_finite, now_.to.t}), false;
    meets_ = watching && stops_.meets(slope_, counted_.turns, lambda_);
    if (!meets_) return !watching || !stops_.finds_push(lambda_) || (stop({Status::undecided, now_.to.t}), false);
    make_again();
    if (stops_.halts()) stop({Status::halted, now_.t});  // where the step began
    return false;
}

bool TimeLoop::end_at_meeting() {
    if (now_.outcome.stops()) return false;
    schedule_.leave();
    const auto found = stops_.locate(counted_, slope_);
    if (found == StopEvents::Found::none) return stop_at(now_.to.t), false;
    if (found == StopEvents::Found::at_once) return meet_stop(), false;
    if (!trial_.again() || !take_step(false)) return stops_.forget(), false;
    stops_.watch().begin(counted_.turns);
    return true;
}

void TimeLoop::report_turns(const Outcome& untold) {
    make_again();
    trial_.reject(untold.step);  // it is made again, shorter
}

void TimeLoop::sample_inside() {
    const double time = schedule_.take();
    ++now_.counters.evaluations;
    const double h = now_.to.h, theta = (time - now_.t) / h;
    stepper_.at(now_.y, h, theta, copy_);
    if (const Outcome closed = step_end_.close_sample(time, copy_); closed.stops()) return stop(closed);
    if (!stepper_.inside(time, h, theta, copy_, copy_slope_, copy_lambda_.data())) return stop_at(time);
    const auto turned = turns_.inside(counted_before_, now_.t, counted_, now_.to.t, time, copy_);
    sample(time, copy_, copy_slope_, copy_lambda_, now_.to.h, turned);
    if (!schedule_.inside()) finish_step();
}

void TimeLoop::finish_step() {
    now_.y.swap(now_.y_new);
    stepper_.first().swap(slope_);
    now_.t = now_.to.t;
    if (now_.to.due) sample(now_.t, now_.y, stepper_.first(), lambda_, now_.to.h, counted_);
    reach();
    if (trial_.passes()) events().watch(now_.t, now_.y, schedule_.window());
    if (stops_.meeting() && !meet_stop()) return void(left_at_end_ = true);
    end_step();
}

void TimeLoop::end_step() {
    if (schedule_.finished()) return stop({Status::finished, now_.t});
    if (trial_.crossing()) {
        if (cross_event()) now_.to.at_break ? cross_break() : go_on();
    } else if (now_.to.at_break) {
        cross_break();
    } else if (trial_.locates()) {
        events().set_free_signs(now_.t, now_.y, schedule_.window());
    }
}

void TimeLoop::take_mark() {
    if (shaped_ || !keeps_marks) return;
    if (!mark_) mark_.emplace();
    write(*mark_);
}

bool TimeLoop::evaluate(const Vector& y, bool with_multipliers) {
    return equations_.slope_at(y.data(), slope_.data(), with_multipliers ? lambda_.data() : nullptr);
}

void TimeLoop::sample(double t, const Vector& y, const Vector& slope, const std::vector<double>& lambda, double h,
                      const TurnCounter::Counted& turned) {
    count_factorisations();
    block.add(t, y, slope, model_, lambda, h, turned.values(), now_.counters);
    if (stops_.inside()) stops_.record(block, lambda);
}

void TimeLoop::act() {
    instants_.take_given(now_.y.data());
    bool looked = false;
    acted_ = schedule_.act([&](int action) {
        if (!std::exchange(looked, true)) instants_.set_channels(now_.t, now_.y.data());
        return instants_.act(action, now_.y.data());
    });
}

void TimeLoop::go_on() {
    if (steps_.fixed()) return;  // else the step is chosen anew
    trial_.control().forget();
    choose_step(schedule_.left(now_.t));
}

bool TimeLoop::choose_step(double longest) {
    const FirstStep first = stepper_.first_step(now_.t, now_.y, steps_.tolerance, longest);
    ++now_.counters.evaluations;
    if (first.h < 0.0) return stop_at(now_.t), false;
    now_.h = std::max(first.h, schedule_.shortest(now_.t));  // round-off of y may ask for less
    shaped_ = shaped_ || (first.limited && schedule_.is_before_end());
    return true;
}

bool TimeLoop::takes(const Mark& mark) {
    auto* rows = step_end_.invariants();
    if (mark.contacts.has_value() != stops_.inside() || mark.kept.has_value() != (rows != nullptr)) return false;
    if (mark.contacts && !stops_.policy().fits(*mark.contacts)) return false;
    if (rows) rows->kept = *mark.kept;
    if (other_ && !other_->resume(mark.other)) return false;
    return events().resume(mark.events);
}

void TimeLoop::make_again() {
    --now_.counters.steps;
    counted_ = counted_before_;
    step_end_.take_back();
}

void TimeLoop::begin_balance() {
    if (auto* rows = step_end_.invariants()) rows->begin(now_.t, now_.y.data());
}

void TimeLoop::reach() {
    schedule_.reach(now_.to);
    if (path) path->add(now_.t, now_.to.h, now_.y);
}

void TimeLoop::write(Mark& mark) {
    count_factorisations();
    mark.t = now_.t, mark.h = now_.h, mark.y = now_.y, mark.grid = schedule_.grid();
    mark.part = schedule_.parts().at(), mark.halved = trial_.halvings();
    mark.counted = counted_, mark.counters = now_.counters, mark.peaks = peaks;
    mark.control = trial_.control().save(), mark.shortened = trial_.shortened();
    if (events().any()) mark.events = events().save();
    if (stops_.inside()) mark.contacts = stops_.policy().state();
    if (const auto* rows = step_end_.invariants()) mark.kept = rows->kept;
    if (other_) mark.other = other_->save();
    mark.shaped = shaped_, mark.anew = false;
    if (stepper_.carries_slope()) mark.slope = stepper_.first();
}

bool TimeLoop::meet_stop() {
    return change_contacts([this] { return stops_.meet(counted_.turns); });
}

void TimeLoop::cross_break() {
    if (is_asked()) return;
    equations_.set_window({});  // as in the current slope
    if (!stepper_.before_jump(now_.t, now_.y)) return stop_at(now_.t);
    equations_.set_window(schedule_.window());
    const bool goes_on = jump([this] {
        schedule_.pass_break(now_.t);
        equations_.set_window(schedule_.window());
        act();
    });
    if (goes_on) acted_ ? go_on() : stop_at(now_.t);
}

bool TimeLoop::cross_event() {
    const Crossing crossing = *trial_.crossing();
    trial_.crossing().reset();
    int often = -1;
    const bool passes =
        change_branches([&] { often = events().cross(crossing, now_.t, schedule_.grain(now_.t), steps_.interval()); });
    if (often >= 0) return stop(Outcome::pushed_back(now_.t, often)), false;
    return passes;
}

bool TimeLoop::renew() {
    begin_balance();
    ++now_.counters.evaluations;
    return stepper_.after_jump(now_.t, now_.y, stepper_.first(), nullptr) || (stop_at(now_.t), false);
}

}  // namespace mbproj
