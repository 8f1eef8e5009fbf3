// Contacts as a border on the joints' factor. N are the gradients of coordinates that only contacts hold. Their Delassus operator
// is B = N (W⁻¹ - W⁻¹GᵀS⁻¹GW⁻¹) Nᵀ: one solve with the current factor for each row, for accelerations, projections and impulses
// alike. The factor, its order and its redundant rows do not depend on contacts.
#pragma once

#include "dynamics/body_forces.hpp"
#include "dynamics/feet.hpp"

namespace mbproj {

// A row that keeps the coordinate of a stop or of a dry friction, by its number, `at` a value. `sign` is the side of a
// stop, so that the row is its gap.
struct ContactRow {
    int coordinate;
    double sign, at;
};

template <class D> class ContactBorder final {
public:
    using Vector = Eigen::VectorXd;

    explicit ContactBorder(const Model<D>& model) : model_(model), none_(model.all_rows(), 0.0), forces_(model) {}

    // Sets the rows that hold from now on.
    void hold(std::vector<ContactRow> rows, std::vector<SlidingRow> slides = {}, std::vector<ContactFoot> feet = {}) {
        rows_ = std::move(rows), slides_ = std::move(slides), given_ = false;
        feet_.hold(std::move(feet), rows_.size());
    }
    // Sets forces along rows that are no constraints.
    void give(std::vector<ContactRow> rows, Vector forces) {
        hold(std::move(rows));
        pushes_ = std::move(forces), given_ = true;
    }
    bool gives() const { return given_; }
    const std::vector<ContactRow>& rows() const { return rows_; }
    bool any() const { return !rows_.empty() && !given_; }
    bool acts() const { return any() || !slides_.empty(); }
    // Whether friction depends on pushes along the rows.
    bool has_feet() const { return feet_.any(); }
    // The law of a friction that leaves no unique forces, or -1.
    int jammed() const { return feet_.jammed(); }

    // Sets N at a pose.
    void set_normals(const Pose<D>& pose) {
        along_.clear();
        for (const ContactRow& row : rows_) along_.emplace_back(model_.stops.coordinates, row.coordinate, pose);
    }
    // Sets N, and B with the solver's factor; reactions where bearings need them, or on request. False where the
    // equations have no unique solution.
    bool factor(const Pose<D>& pose, KktSolver<D>& solver, bool reacts = false) {
        const auto count = static_cast<Eigen::Index>(rows_.size());
        set_normals(pose);
        B_.resize(count, count), rests_.setZero(count);
        reactions_.resize(model_.all_rows(), count), loose_.resize(count);
        Vector unit = Vector::Zero(count), column;
        for (Eigen::Index k = 0; k < count; ++k) {
            unit[k] = 1.0;
            set_forces(unit);
            loose_[k] = 0.0;
            forces_.give(solver);
            for (int b = 0; b < model_.size(); ++b) loose_[k] += alone(b, pose);
            double* reaction = (model_.bearings.empty() && !reacts) || !reactions_.rows() ? nullptr : &reactions_(0, k);
            if (!solver.solve(none_.data(), reaction)) return false;
            changes(solver, column);
            B_.col(k) = column;
            unit[k] = 0.0;
        }
        cholesky_.factor(B_, model_.thresholds.no_push);
        return true;
    }
    const Eigen::MatrixXd& operator_of_rows() const { return B_; }
    // The change of the joints' multipliers by a unit force along each row, where bearings depend on them.
    const Eigen::MatrixXd& reactions() const { return reactions_; }
    // Whether anything can move along a row. Where nothing can, B is round-off of its value without joints.
    bool moves(Eigen::Index k) const { return !model_.is_held() && B_(k, k) > model_.thresholds.no_push * loose_[k]; }
    // The factor of the independent rows.
    const SemidefiniteCholesky& cholesky() const { return cholesky_; }

    // `gaps`: g of the rows, angles within half a turn; `rates`: N u; `bends`: the part of g'' without accelerations.
    void gaps(Vector& found) const {
        found.resize(static_cast<Eigen::Index>(rows_.size()));
        for (std::size_t k = 0; k < rows_.size(); ++k) {
            const double from = along_[k].value() - rows_[k].at;
            found[static_cast<Eigen::Index>(k)] = rows_[k].sign * (is_angle(k) ? nearest(from) : from);
        }
    }
    void rates(const Motion<D>& motion, Vector& found) const {
        found.resize(static_cast<Eigen::Index>(rows_.size()));
        for (std::size_t k = 0; k < rows_.size(); ++k)
            found[static_cast<Eigen::Index>(k)] = rows_[k].sign * along_[k].rate(motion);
    }
    void bends(const Motion<D>& motion, Vector& found) const {
        found.resize(static_cast<Eigen::Index>(rows_.size()));
        for (std::size_t k = 0; k < rows_.size(); ++k)
            found[static_cast<Eigen::Index>(k)] = rows_[k].sign * along_[k].bend(motion);
    }
    // N δ of the solver's last solution.
    void changes(const KktSolver<D>& solver, Vector& found) const {
        const auto shift = [&](int b) { return b < model_.size() ? solver.shift(b) : Point<D>(Point<D>::Zero()); };
        const auto turn = [&](int b) { return b < model_.size() ? solver.turn(b) : Turn<D>(Turn<D>::Zero()); };
        found.resize(static_cast<Eigen::Index>(rows_.size()));
        for (std::size_t k = 0; k < rows_.size(); ++k)
            found[static_cast<Eigen::Index>(k)] = rows_[k].sign * along_[k].rate(shift, turn);
    }

    // g'' of the rows in the solver's last motion. In the first `first` rows, values within the round-off of the whole
    // motion become 0. The energy of accelerations bounds each row's share: |g''|² <= B Σ (m r''² + ω'ᵀ J ω').
    void accelerations(const Pose<D>& pose, const KktSolver<D>& solver, const Motion<D>& motion, Eigen::Index first,
                       Vector& found) {
        changes(solver, found);
        bends(motion, bend_);
        found += bend_;
        double whole = 0.0;
        for (int b = 0; b < model_.size(); ++b) {
            const Turn<D> turn = to_body(pose[b].rotation, solver.turn(b));
            whole += model_.bodies[b].mass * solver.shift(b).squaredNorm() + turn.dot(model_.bodies[b].inertia * turn);
        }
        rests_ = model_.thresholds.no_push * std::sqrt(whole) * B_.diagonal().head(first).cwiseSqrt();
        for (Eigen::Index k = 0; k < first; ++k)
            if (std::abs(found[k]) <= rests_[k]) found[k] = 0.0;
    }
    // Whether the gap of one of these first rows opens with this acceleration.
    bool opens(Eigen::Index k, double acceleration) const { return acceleration > rests_[k]; }
    // The round-off of forces along these rows.
    double round_off() const {
        double most = 0.0;
        for (Eigen::Index k = 0; k < rests_.size(); ++k)
            if (rests_[k] > 0.0) most = std::max(most, rests_[k] / B_(k, k));
        return most;
    }

    // Whether each gap is at most `grains` ε of the largest coordinate that enters it, or `least`.
    [[gnu::noinline, gnu::cold]] bool within(const Pose<D>& pose, double grains, double least) {
        set_normals(pose);
        gaps(gap_);
        for (std::size_t k = 0; k < rows_.size(); ++k)
            if (!(std::abs(gap_[static_cast<Eigen::Index>(k)]) <=
                  std::max(least * std::min(1.0, size(k)), grain(k, pose, grains))))
                return false;
        return true;
    }
    // The largest gap that is open by more than round-off, in parts of the mechanism's length.
    [[gnu::noinline, gnu::cold]] double open(const Pose<D>& pose) {
        set_normals(pose);
        gaps(gap_);
        double most = 0.0;
        for (std::size_t k = 0; k < rows_.size(); ++k)
            if (const double gap = std::abs(gap_[static_cast<Eigen::Index>(k)]);
                !(gap <= grain(k, pose, model_.thresholds.closed_grains)))
                most = larger(most, gap / size(k));
        return most;
    }

    // The forces z along the rows with b + B z = 0; they are 0 along dependent rows.
    void close(const Vector& b, Vector& z) const { cholesky_.solve(b, z); }
    // Adds the friction at feet; `applied` has its forces for pushes of 1. False where the forces are not unique then.
    bool add_friction(const Pose<D>& pose, const Applied<D>& applied, KktSolver<D>& solver) {
        const auto effect = [&](const ContactFoot& foot, Vector& column, double* reactions) {
            forces_.clear();
            for (const auto& [coordinate, law] : foot.rubs)
                forces_.add(Coordinate<D>(model_.stops.coordinates, coordinate, pose), applied.given[law]);
            forces_.give(solver);
            if (!solver.solve(none_.data(), reactions)) return false;
            return changes(solver, column), true;
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
    // solver's forces. Without `motion`, the solver's motion is the response to forces alone.
    void settle(const KktSolver<D>& solver, const Motion<D>* motion) {
        changes(solver, free_);
        if (motion) {
            bends(*motion, bend_);
            free_ += bend_;
        }
        feet_.any() ? feet_.close(free_, pushes_) : close(free_, pushes_);
    }
    // Sets these forces, and adds the joints' reactions to them to the multipliers `lambda`.
    void add_reactions(const KktSolver<D>& solver, const Motion<D>* motion, std::vector<double>& lambda) {
        settle(solver, motion);
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
    const Vector& free_accelerations() const { return free_; }
    void pull(KktSolver<D>& solver) {
        set_forces(pushes_);
        forces_.give_more(solver);
    }

    // Solves for the change by impulses z along the rows, with the right-hand sides c of the joints' rows.
    bool respond(KktSolver<D>& solver, const Vector& z, const double* c = nullptr) {
        set_forces(z);
        forces_.give(solver);
        return solver.solve(c ? c : none_.data());
    }
    // Solves for the accelerations by forces on the bodies alone while the rows hold, with the current factor; `set` gives the
    // forces to the solver. Multipliers on request. False where they are not unique.
    template <class Set>
    bool answer(const Pose<D>& pose, KktSolver<D>& solver, const Set& set, double* multipliers = nullptr) {
        set();
        if (!solver.solve(none_.data(), multipliers)) return false;
        return !any() || answer_closed(pose, solver, set, multipliers);
    }

private:
    // `answer` with forces along rows that hold.
    template <class Set> [[gnu::noinline, gnu::cold]] bool answer_closed(const Pose<D>& pose, KktSolver<D>& solver,
                                                                         const Set& set, double* multipliers) {
        if (!factor(pose, solver)) return false;
        set();
        if (!solver.solve(none_.data())) return false;
        changes(solver, free_);
        close(free_, pushes_);
        set();
        pull(solver);
        return solver.solve(none_.data(), multipliers);
    }
    // Sets forces and moments Nᵀ z on the bodies, about their centres of mass.
    void set_forces(const Vector& z) {
        forces_.clear();
        for (std::size_t k = 0; k < rows_.size(); ++k)
            forces_.add(along_[k], rows_[k].sign * z[static_cast<Eigen::Index>(k)]);
    }

    // nᵀ W⁻¹ n of one body without joints, with the current forces n.
    double alone(int b, const Pose<D>& pose) const {
        const Body<D>& body = model_.bodies[b];
        const double shifts = body.mass > 0.0 ? forces_.force[b].squaredNorm() / body.mass : 0.0;
        return shifts + (body.inverse_root * to_body(pose[b].rotation, forces_.torque[b])).squaredNorm();
    }

    double size(std::size_t k) const { return is_angle(k) ? 1.0 : model_.length; }
    double grain(std::size_t k, const Pose<D>& pose, double grains) const {
        double reach = std::min(1.0, size(k));
        for (int s = 0; s < along_[k].p.slot_count; ++s)
            if (const Attachment<D>& a = along_[k].attachment(s); a.is_point)
                reach = std::max(reach, pose[a.body].position.largest() + a.size);
        return grains * std::numeric_limits<double>::epsilon() * reach;
    }
    bool is_angle(std::size_t k) const { return mbproj::is_angle(along_[k].p.kind); }

    const Model<D>& model_;
    const std::vector<double> none_;
    std::vector<ContactRow> rows_;
    std::vector<SlidingRow> slides_;
    Feet feet_;
    bool given_ = false;
    std::vector<Coordinate<D>> along_;
    Eigen::MatrixXd B_, reactions_;
    SemidefiniteCholesky cholesky_;
    Vector free_, bend_, pushes_, gap_, loose_, rests_;
    ForcesAlong<D> forces_;
};

}  // namespace mbproj
