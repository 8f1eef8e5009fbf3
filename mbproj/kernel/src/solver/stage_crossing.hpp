// Forces and states that depend on channels, in one equation of an implicit step.
// A change δa of the accelerations changes coordinate channels by w = g² G δa, rate
// channels by w = g G δa. States change by δx' = E (f - x'₀ + f_w w) with E = (I - g f_x)⁻¹, forces by φ = F_w w + g F_x δx'.
// Such forces are few. Z is the response of the accelerations to a unit of each, with the current factor. So δa = δa₀ + Z φ
// (Woodbury), and (I - C H) φ = φ₀ + C w₀ with C = F_w + g F_x E f_w and H = w of Z. No term is dropped.
#pragma once

#include "solver/equations_of_motion.hpp"

namespace mbproj {

template <class D> class StageCrossing final {
public:
    using S = Size<D>;
    using Vector = Eigen::VectorXd;
    using Dense = Eigen::MatrixXd;

    explicit StageCrossing(EquationsOfMotion<D>& equations)
        : equations_(equations), model_(equations.model()), shift_(model_.size() + 1, Point<D>::Zero()),
          turn_(model_.size() + 1, Turn<D>::Zero()) {
        for (std::size_t c = 0; c < model_.channels.size(); ++c)
            if (model_.channels[c].kind != ChannelKind::state) moving_.push_back(c);
        if (!model_.loads) return;
        for (std::size_t l = 0; l < model_.loads->laws.size(); ++l)
            if (names(model_.loads->laws[l].program)) pulls_.push_back({static_cast<int>(l), nullptr, 0});
        for (const BodyForce<D>& force : model_.loads->on_bodies)
            for (int k = 0; k < 3; ++k)
                if (names(force.programs[k])) pulls_.push_back({-1, &force, k});
    }

    // Whether there are states or channels at all, and whether forces depend on channels.
    bool any() const { return model_.layout.states.size > 0 || !model_.channels.empty(); }
    bool pushes() const { return !pulls_.empty(); }

    // The change of y' by channels in a pass of Newton's method, with the accelerations and rates of states `before`.
    bool take(double t, const double* y, double g, const double* before, double* slope, double* lambda) {
        set(t, y, g);
        Vector w = of_accelerations(slope) - of_accelerations(before);
        add(before, -1.0, slope);
        if (!change(w, slope, lambda)) return false;
        add(before, 1.0, slope);
        return true;
    }

    // (I - g ∂f/∂y)⁻¹ e of an error e of the state y at t whose velocities have been filtered without channels. `moved`: w of
    // the errors of its positions.
    bool filter(const Vector& moved, double* e) {
        Vector w = of_accelerations(e) + moved;
        return change(w, e, nullptr);
    }
    // w of the errors of positions, at the state y at t.
    Vector of_positions(double t, const double* y, double g, const double* e) {
        set(t, y, g);
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> error(e, b), part(y, b);
            shift_[b] = error.position();
            turn_[b] = turn_of(Column<S::orientation>(part.orientation()), Column<S::orientation>(error.orientation()));
        }
        Vector found = along();
        for (Eigen::Index i = 0; i < found.size(); ++i)
            found[i] = model_.channels[moving_[i]].kind == ChannelKind::rate ? 0.0 : found[i] / g;
        return found;
    }

private:
    // A force that depends on channels: a law, or a component of a force on a body.
    struct Pull {
        int law;
        const BodyForce<D>* force;
        int component;
    };

    bool names(int program) const { return program >= 0 && model_.programs.names(program, law_variables); }

    // Sets the slopes at the state y in place, at t; a function without a slope counts as constant.
    void set(double t, const double* y, double g) {
        g_ = g;
        Channels<D>& channels = equations_.channels_at(t, y);
        const auto states = static_cast<Eigen::Index>(model_.layout.states.size);
        const auto pulls = static_cast<Eigen::Index>(pulls_.size());
        std::vector<double> by(channels.size());
        const auto take = [&](Eigen::Index row, Dense& by_states, Dense& by_motion, double weight) {
            for (std::size_t c = 0; c < by.size(); ++c)
                if (const Channel& channel = model_.channels[c];
                    channel.kind == ChannelKind::state && std::isfinite(by[c]))
                    by_states(row, channel.index) += weight * by[c];
            for (std::size_t i = 0; i < moving_.size(); ++i)
                by_motion(row, static_cast<Eigen::Index>(i)) = std::isfinite(by[moving_[i]]) ? by[moving_[i]] : 0.0;
        };
        left_ = Dense::Identity(states, states);
        by_motion_ = Dense::Zero(states, static_cast<Eigen::Index>(moving_.size()));
        for (int k = 0; k < states; ++k) {
            equations_.states().slopes(k, channels, by.data());
            take(k, left_, by_motion_, -g);
        }
        pushed_ = Dense::Zero(pulls, states);
        pushed_by_motion_ = Dense::Zero(pulls, by_motion_.cols());
        const Applied<D>& applied = equations_.applied();
        for (Eigen::Index r = 0; r < pulls; ++r) {
            if (const Pull& pull = pulls_[r]; pull.law >= 0)
                applied.slopes(*model_.loads, pull.law, equations_.pose(), equations_.motion(), channels, by.data());
            else
                applied.slopes(*pull.force, pull.component, channels, by.data());
            take(r, pushed_, pushed_by_motion_, g);
        }
    }

    // Adds the effect of channels to w, to the accelerations in `slope`, and to the rates of states in its block. All three are
    // given without it.
    bool change(Vector& w, double* slope, double* lambda) {
        Eigen::Map<Vector> states(slope + model_.layout.states.first, model_.layout.states.size);
        const Eigen::Index moving = by_motion_.cols();
        Dense found(states.size(), moving + 1);
        found.leftCols(moving) = by_motion_;
        found.col(moving) = states;
        if (states.size()) found = solved_columns(left_, found);
        const Dense by_motion = found.leftCols(moving);
        const Vector off = found.col(moving);
        if (!pulls_.empty() && !push(w, by_motion, off, slope, lambda)) return false;
        states = off + by_motion * w;
        return true;
    }

    // Adds the effect of the forces φ to the accelerations in `slope`, to w and the multipliers. `by_motion`: E f_w.
    bool push(Vector& w, const Dense& by_motion, const Vector& off, double* slope, double* lambda) {
        const auto pulls = static_cast<Eigen::Index>(pulls_.size());
        const Dense by = pushed_by_motion_ + pushed_ * by_motion;  // C
        Dense responses(w.size(), pulls), moved(S::freedoms * model_.size(), pulls);
        Dense multipliers = Dense::Zero(model_.all_rows(), lambda ? pulls : 0);
        for (Eigen::Index r = 0; r < pulls; ++r) {
            if (!respond(pulls_[r], lambda ? multipliers.col(r).data() : nullptr)) return false;
            responses.col(r) = along();
            double* a = moved.col(r).data();
            for (int b = 0; b < model_.size(); ++b) {
                const Turn<D> turn = to_body(equations_.pose()[b].rotation, turn_[b]);
                a = std::copy(shift_[b].begin(), shift_[b].end(), a);
                a = std::copy(turn.begin(), turn.end(), a);
            }
        }
        const Vector phi = solved(Dense::Identity(pulls, pulls) - by * responses, by * w + pushed_ * off);
        if (!phi.allFinite()) return false;
        w += responses * phi;
        const Vector more = moved * phi;
        const double* a = more.data();
        for (int b = 0; b < model_.size(); ++b) {
            WritablePart<D> part(slope, b);
            for (int i = 0; i < D::axes; ++i) part.velocity()[i] += *a++;
            for (int i = 0; i < S::turns; ++i) part.omega()[i] += *a++;
        }
        if (lambda) Eigen::Map<Vector>(lambda, multipliers.rows()) += multipliers * phi;
        return true;
    }

    // The response of the bodies to a unit of a force, with the current factor: their twists, and the multipliers.
    bool respond(const Pull& pull, double* multipliers) {
        Applied<D>& applied = equations_.applied();
        KktSolver<D>& solver = equations_.solver();
        applied.clear();
        if (pull.law >= 0)
            applied.add(*model_.loads, pull.law, equations_.pose(), 1.0);
        else
            applied.add(*pull.force, pull.component, equations_.pose());
        const auto set = [&] {
            for (int b = 0; b < model_.size(); ++b) solver.set_force(b, applied.force[b], applied.torque[b]);
        };
        if (!equations_.contacts().answer(set, multipliers)) return false;
        for (int b = 0; b < model_.size(); ++b) {
            shift_[b] = solver.shift(b);
            turn_[b] = solver.turn(b);
        }
        return true;
    }

    // w of the accelerations in a slope, and of the current twists.
    Vector of_accelerations(const double* slope) {
        for (int b = 0; b < model_.size(); ++b) {
            const Part<D> part(slope, b);
            shift_[b] = part.velocity();
            turn_[b] = to_global(equations_.pose()[b].rotation, Turn<D>(part.omega()));
        }
        return along();
    }
    Vector along() const {
        Vector found(static_cast<Eigen::Index>(moving_.size()));
        for (std::size_t i = 0; i < moving_.size(); ++i) {
            const Channel& channel = model_.channels[moving_[i]];
            const Coordinate<D> coordinate(model_.coordinates, channel.index, equations_.pose());
            const double rate =
                coordinate.rate([this](int b) { return shift_[b]; }, [this](int b) { return turn_[b]; });
            found[static_cast<Eigen::Index>(i)] = (channel.kind == ChannelKind::rate ? g_ : g_ * g_) * rate;
        }
        return found;
    }
    // Adds `weight` times the states' block of one slope to that of another.
    void add(const double* from, double weight, double* to) const {
        for (int i = model_.layout.states.first; i < model_.layout.states.end(); ++i) to[i] += weight * from[i];
    }

    EquationsOfMotion<D>& equations_;
    const Model<D>& model_;
    std::vector<Point<D>> shift_;  // of all bodies, the ground's last, global axes
    std::vector<Turn<D>> turn_;
    std::vector<Pull> pulls_;
    std::vector<std::size_t> moving_;  // the channels that depend on the motion
    Dense left_, by_motion_;           // I - g f_x and f_w
    Dense pushed_, pushed_by_motion_;  // g F_x and F_w
    double g_ = 0.0;
};

}  // namespace mbproj
