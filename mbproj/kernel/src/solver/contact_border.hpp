// A border of one dimension.
#pragma once

#include "solver/body_forces.hpp"
#include "solver/border.hpp"

namespace mbproj {

template <class D> class ContactBorder final : public Border {
public:
    // Of the pose, motion and solver of these equations.
    ContactBorder(const Model<D>& model, const Pose<D>& pose, const Motion<D>& motion, KktSolver<D>& solver)
        : Border(model.is_held(), model.thresholds.no_push), model_(model), pose_(pose), motion_(motion),
          solver_(solver), none_(model.all_rows(), 0.0), forces_(model) {}

    void set_normals() override {
        along_.clear();
        for (const ContactRow& row : rows_) along_.emplace_back(model_.stop_coordinates, row.coordinate, pose_);
    }
    bool factor(bool reacts = false) override {
        const auto count = static_cast<Eigen::Index>(rows_.size());
        set_normals();
        B_.resize(count, count), rests_.setZero(count);
        reactions_.resize(model_.all_rows(), count), loose_.resize(count);
        Vector unit = Vector::Zero(count), column;
        for (Eigen::Index k = 0; k < count; ++k) {
            unit[k] = 1.0;
            set_forces(unit);
            loose_[k] = 0.0;
            forces_.give(solver_);
            for (int b = 0; b < model_.size(); ++b) loose_[k] += alone(b);
            double* reaction = (model_.bearings.empty() && !reacts) || !reactions_.rows() ? nullptr : &reactions_(0, k);
            if (!solver_.solve(none_.data(), reaction)) return false;
            changes(column);
            B_.col(k) = column;
            unit[k] = 0.0;
        }
        cholesky_.factor(B_, model_.thresholds.no_push);
        return true;
    }

    // `gaps`: g of the rows, angles within half a turn; `bends`: the part of g'' without accelerations.
    void gaps(Vector& found) const {
        found.resize(static_cast<Eigen::Index>(rows_.size()));
        for (std::size_t k = 0; k < rows_.size(); ++k) {
            const double from = along_[k].value() - rows_[k].at;
            found[static_cast<Eigen::Index>(k)] = rows_[k].sign * (is_angle(k) ? nearest(from) : from);
        }
    }
    void rates(Vector& found) const override {
        found.resize(static_cast<Eigen::Index>(rows_.size()));
        for (std::size_t k = 0; k < rows_.size(); ++k)
            found[static_cast<Eigen::Index>(k)] = rows_[k].sign * along_[k].rate(motion_);
    }
    void bends(Vector& found) const {
        found.resize(static_cast<Eigen::Index>(rows_.size()));
        for (std::size_t k = 0; k < rows_.size(); ++k)
            found[static_cast<Eigen::Index>(k)] = rows_[k].sign * along_[k].bend(motion_);
    }
    // N δ of the solver's last solution.
    void changes(Vector& found) const {
        const auto shift = [&](int b) { return b < model_.size() ? solver_.shift(b) : Point<D>(Point<D>::Zero()); };
        const auto turn = [&](int b) { return b < model_.size() ? solver_.turn(b) : Turn<D>(Turn<D>::Zero()); };
        found.resize(static_cast<Eigen::Index>(rows_.size()));
        for (std::size_t k = 0; k < rows_.size(); ++k)
            found[static_cast<Eigen::Index>(k)] = rows_[k].sign * along_[k].rate(shift, turn);
    }

    void accelerations(Eigen::Index first, Vector& found) override {
        changes(found);
        bends(bend_);
        found += bend_;
        double whole = 0.0;
        for (int b = 0; b < model_.size(); ++b) {
            const Turn<D> turn = to_body(pose_[b].rotation, solver_.turn(b));
            whole += model_.bodies[b].mass * solver_.shift(b).squaredNorm() + turn.dot(model_.bodies[b].inertia * turn);
        }
        rests_ = model_.thresholds.no_push * std::sqrt(whole) * B_.diagonal().head(first).cwiseSqrt();
        for (Eigen::Index k = 0; k < first; ++k)
            if (std::abs(found[k]) <= rests_[k]) found[k] = 0.0;
    }

    // Whether each gap is at most `grains` ε of the largest coordinate that enters it, or `least`.
    [[gnu::noinline, gnu::cold]] bool within(double grains, double least) {
        set_normals();
        gaps(gap_);
        for (std::size_t k = 0; k < rows_.size(); ++k)
            if (!(std::abs(gap_[static_cast<Eigen::Index>(k)]) <=
                  std::max(least * std::min(1.0, size(k)), grain(k, grains))))
                return false;
        return true;
    }
    // The largest gap that is open by more than round-off, in parts of the mechanism's length.
    [[gnu::noinline, gnu::cold]] double open() {
        set_normals();
        gaps(gap_);
        double most = 0.0;
        for (std::size_t k = 0; k < rows_.size(); ++k)
            if (const double gap = std::abs(gap_[static_cast<Eigen::Index>(k)]);
                !(gap <= grain(k, model_.thresholds.closed_grains)))
                most = larger(most, gap / size(k));
        return most;
    }

    // Adds the friction at feet; `applied` has its forces for pushes of 1. False where the forces are not unique then.
    bool add_friction(const Applied<D>& applied) {
        const auto effect = [&](const ContactFoot& foot, Vector& column, double* reactions) {
            forces_.clear();
            for (const auto& [coordinate, law] : foot.rubs)
                forces_.add(Coordinate<D>(model_.stop_coordinates, coordinate, pose_), applied.given[law]);
            forces_.give(solver_);
            if (!solver_.solve(none_.data(), reactions)) return false;
            return changes(column), true;
        };
        return feet_.add_friction(B_, reactions_, cholesky_, effect);
    }
    // Multiplies the friction at feet by the last pushes from now on, or by 0.
    void load(Applied<D>& applied, bool any = true) const {
        if (!has_feet()) return;
        const auto take = [&](const ContactFoot& foot, double push) {
            for (const SlidingRow& each : foot.rubs) applied.pushed[each.law] = push;
        };
        feet_.each(take, any ? pushes_ : Vector::Zero(static_cast<Eigen::Index>(rows_.size())));
    }

    // Sets the forces with which no row accelerates, from the solver's motion without them; `pull` adds them to the
    // solver's forces. Unless it `moves`, the solver's motion is the response to forces alone.
    void settle(bool moves) {
        changes(free_);
        if (moves) {
            bends(bend_);
            free_ += bend_;
        }
        feet_.any() ? feet_.close(free_, pushes_) : close(free_, pushes_);
    }
    // Sets these forces, and adds the joints' reactions to them to the multipliers `lambda`.
    void add_reactions(bool moves, std::vector<double>& lambda) {
        settle(moves);
        const Vector more = (feet_.any() ? feet_.reactions() : reactions_) * pushes_;
        for (Eigen::Index r = 0; r < more.size(); ++r) lambda[r] += more[r];
    }
    // Writes the force along each coordinate that is held, or that slides.
    void write_forces(const Applied<D>& applied, double* found) const {
        for (std::size_t k = 0; k < rows_.size(); ++k)
            found[rows_[k].coordinate] = pushes_[static_cast<Eigen::Index>(k)];
        feet_.each([&](const ContactFoot& foot, double push) { found[foot.stop] = push; }, pushes_);
        write_sliding_forces(applied, found);
    }
    void write_sliding_forces(const Applied<D>& applied, double* found) const {
        for (const auto& [coordinate, law] : slides_)
            found[coordinate] = applied.given[law] * applied.load_of(*model_.loads, law);
    }
    void pull() {
        set_forces(pushes_);
        forces_.give_more(solver_);
    }

    bool respond(const Vector& z, const double* c = nullptr) override {
        set_forces(z);
        forces_.give(solver_);
        return solver_.solve(c ? c : none_.data());
    }
    // Solves for the accelerations by forces on the bodies alone while the rows hold, with the current factor; `set` gives the
    // forces to the solver. Multipliers on request. False where they are not unique.
    template <class Set> bool answer(const Set& set, double* multipliers = nullptr) {
        set();
        if (!solver_.solve(none_.data(), multipliers)) return false;
        return !any() || answer_closed(set, multipliers);
    }

private:
    // `answer` with forces along rows that hold.
    template <class Set> [[gnu::noinline, gnu::cold]] bool answer_closed(const Set& set, double* multipliers) {
        if (!factor()) return false;
        set();
        if (!solver_.solve(none_.data())) return false;
        changes(free_);
        close(free_, pushes_);
        set();
        pull();
        return solver_.solve(none_.data(), multipliers);
    }
    // Sets forces and moments Nᵀ z on the bodies, about their centres of mass.
    void set_forces(const Vector& z) {
        forces_.clear();
        for (std::size_t k = 0; k < rows_.size(); ++k)
            forces_.add(along_[k], rows_[k].sign * z[static_cast<Eigen::Index>(k)]);
    }

    // nᵀ W⁻¹ n of one body without joints, with the current forces n.
    double alone(int b) const {
        const Body<D>& body = model_.bodies[b];
        const double shifts = body.mass > 0.0 ? forces_.force[b].squaredNorm() / body.mass : 0.0;
        return shifts + (body.inverse_root * to_body(pose_[b].rotation, forces_.torque[b])).squaredNorm();
    }

    double size(std::size_t k) const { return is_angle(k) ? 1.0 : model_.length; }
    double grain(std::size_t k, double grains) const {
        double reach = std::min(1.0, size(k));
        for (int s = 0; s < along_[k].p.slot_count; ++s)
            if (const Attachment<D>& a = along_[k].attachment(s); a.is_point)
                reach = std::max(reach, pose_[a.body].position.largest() + a.size);
        return grains * std::numeric_limits<double>::epsilon() * reach;
    }
    bool is_angle(std::size_t k) const { return mbproj::is_angle(along_[k].p.kind); }

    const Model<D>& model_;
    const Pose<D>& pose_;
    const Motion<D>& motion_;
    KktSolver<D>& solver_;
    const std::vector<double> none_;
    std::vector<Coordinate<D>> along_;
    Vector bend_, gap_;
    ForcesAlong<D> forces_;
};

extern template class ContactBorder<Plane<double>>;
extern template class ContactBorder<Space<double>>;

}  // namespace mbproj
