// Forces of a scene without gravity, as in mbproj.equations.forces: laws on coordinates, forces on bodies.
#pragma once

#include "kinematics/channels.hpp"
#include "kinematics/laws.hpp"
#include "model/switches.hpp"

namespace mbproj {

// The loads at a state: the force and the moment about the centre of mass of each body and the ground in global axes, the power
// of functions, and the power lost in dampers.
template <class D> struct Applied : ActingLaws {
    std::vector<Point<D>> force;
    std::vector<Turn<D>> torque;
    Scalar<D> power = 0.0, dissipation = 0.0;
    std::vector<Scalar<D>> carried;  // the loads of the bearings
    std::vector<Scalar<D>> lost;     // W, of laws whose losses have their own quadrature
    std::vector<Scalar<D>> given;    // the forces of programs of laws, before multiplication by loads

    explicit Applied(const Model<D>& model)
        : force(model.loads ? model.size() + 1 : 0), torque(force.size()), carried(model.bearings.size(), 0.0),
          lost(max(0, model.layout.quadratures.size - 2), 0.0), given(model.loads ? model.loads->laws.size() : 0, 0.0),
          programs_(model.programs), least_cosine_(cos(0.5 * model.thresholds.most_turned)) {}

    // Evaluates all loads. False where a function has no finite value, or a bushing has turned too far.
    bool update(const Loads<D>& loads, const Pose<D>& pose, const Motion<D>& motion, Channels<D>& channels) {
        clear();
        power = dissipation = 0.0;
        for (std::size_t l = 0; l < loads.laws.size(); ++l)
            if (!apply(loads, static_cast<int>(l), pose, motion, channels)) return false;
        for (const BodyForce<D>& given : loads.on_bodies)
            if (!apply(given, pose, motion, channels)) return false;
        for (const Bushing<D>& bushing : loads.bushings)
            if (!apply(bushing, pose, motion)) return false;
        return true;
    }

    // The slopes of a law's force by its coordinate and rate, on the branches that are
    // held.
    LawSlopes<D> slopes(const Loads<D>& loads, int l, const Pose<D>& pose, const Motion<D>& motion,
                        Channels<D>& channels, Scalar<D>* by_channels = nullptr) const {
        const Law<D>& law = loads.laws[l];
        LawSlopes<D> found{law.stiffness, law.damping, 0.0, 0.0, 0.0};
        if (by_channels) std::fill_n(by_channels, channels.size(), 0.0);
        if (law.program < 0) return found;
        if (is_given(l)) return found.given = part[l] * load_of(loads, l), found;
        const Seen now(loads, l, *this, Coordinate<D>(loads.coordinates, l, pose), pose, motion, channels);
        const Scalar<D> load = load_of(loads, l) * now.part;
        const Scalar<D> times = pace.empty() ? 1.0 : pace[l];
        const Series<Scalar<D>>* variables = channels.variables(now.at, now.speed * times);
        found.value = now.at;
        found.rate = now.rate;
        found.given = load * programs_.value(law.program, variables, held);
        Scalar<D> own[2];
        channels.slopes(law.program, held, 1, 3, own);
        own[1] *= times;
        if (!acts.empty() && acts[l] == Acts::kept) own[1] = 0.0;
        for (Scalar<D>& slope : own) slope = isfinite(load * slope) ? load * slope : 0.0;
        found.of_value -= own[0];
        found.of_rate -= own[1];
        if (!by_channels) return found;
        channels.slopes(law.program, held, law_variables, law_variables + channels.size(), by_channels);
        for (std::size_t c = 0; c < channels.size(); ++c) by_channels[c] *= load;
        return found;
    }

    // ∂F/∂channel of a component of a force on a body.
    void slopes(const BodyForce<D>& given, int component, Channels<D>& channels, Scalar<D>* by_channels) const {
        channels.variables();
        channels.slopes(given.programs[component], held, law_variables, law_variables + channels.size(), by_channels);
    }

    // Sets the loads to zero, before single forces are added.
    void clear() {
        for (auto& f : force) f.setZero();
        for (auto& f : torque) f.setZero();
    }
    // V of springs, with the preloads of bushings.
    Scalar<D> stored(const Loads<D>& loads, const Pose<D>& pose, const Channels<D>& channels) const {
        Scalar<D> sum = 0.0;
        for (std::size_t l = 0; l < loads.laws.size(); ++l) {
            const Law<D>& law = loads.laws[l];
            if (law.stiffness == 0.0) continue;
            const Scalar<D> longer =
                value(law, Coordinate<D>(loads.coordinates, static_cast<int>(l), pose), channels) - law.free;
            sum += 0.5 * law.stiffness * longer * longer;
        }
        for (const Bushing<D>& bushing : loads.bushings) {
            const auto s = Deflection<D>(bushing, pose).value();
            sum += s.dot(0.5 * (bushing.stiffness * s) - bushing.preload);
        }
        return sum;
    }
    Scalar<D> load_of(const Loads<D>& loads, int law) const {
        const int bearing = loads.laws[law].bearing;
        return (bearing < 0 ? 1.0 : carried[bearing]) * (pushed.empty() ? 1.0 : pushed[law]);
    }
    void add(const Loads<D>& loads, int law, const Pose<D>& pose, Scalar<D> size) {
        pull(Coordinate<D>(loads.coordinates, law, pose), size);
    }
    void add(const BodyForce<D>& given, int component, const Pose<D>& pose) {
        Column<3, Scalar<D>> unit = Column<3, Scalar<D>>::Zero();
        unit[component] = 1.0;
        const auto [push, twist] = wrench(given, unit, pose);
        force[given.body] += push;
        torque[given.body] += twist;
    }
    // Replaces the loads by a force of size 1 along one of the coordinates of forces.
    void pull(const Loads<D>& loads, int l, const Pose<D>& pose) {
        clear();
        const int of_bushings = l - static_cast<int>(loads.laws.size());
        if (of_bushings >= 0) {
            const Bushing<D>& bushing = loads.bushings[of_bushings / 6];
            Deflection<D>(bushing, pose).pull(bushing.map.row(of_bushings % 6).transpose(), force, torque);
            return;
        }
        pull(Coordinate<D>(loads.coordinates, l, pose), 1.0);
    }
    // The rate of a coordinate of forces, from velocities and angular velocities (n + 1, global axes).
    Scalar<D> rate(const Loads<D>& loads, int l, const Pose<D>& pose, const std::vector<Point<D>>& velocity,
                   const std::vector<Turn<D>>& omega) const {
        const auto velocity_of = [&](int b) { return velocity[b]; };
        const auto omega_of = [&](int b) { return omega[b]; };
        const int of_bushings = l - static_cast<int>(loads.laws.size());
        if (of_bushings < 0) return Coordinate<D>(loads.coordinates, l, pose).rate(velocity_of, omega_of);
        const Bushing<D>& bushing = loads.bushings[of_bushings / 6];
        return bushing.map.row(of_bushings % 6).dot(Deflection<D>(bushing, pose).rate(velocity_of, omega_of));
    }

    template <class Rows> void touch(const Rows& rows) {  // these rows of stops are held
        touching.clear();
        for (const auto& row : rows) touching.insert(row.coordinate);
    }
    // Evaluates the arguments of the model's switches at a state, on these branches, or on free ones.
    void switch_arguments(const Model<D>& model, const Pose<D>& pose, const Motion<D>& motion, Channels<D>& channels,
                          const double* branches, std::vector<Scalar<D>>& arguments) const {
        const std::vector<Switch>& switches = model.switches;
        for (std::size_t k = 0; k < switches.size();) {
            const auto [program, _, l, curve] = switches[k];
            const Series<Scalar<D>>* variables = channels.variables();
            if (l >= 0) {
                const Coordinate<D> along(model.loads->coordinates, l, pose);
                const Scalar<D> times = pace.empty() ? 1.0 : pace[l];
                variables =
                    channels.variables(value(model.loads->laws[l], along, channels), along.rate(motion) * times);
            }
            if (curve >= 0) variables = channels.variables(followed(model, curve, pose));
            const std::size_t first = k;
            programs_.walk(program, variables, branches,
                           [&](int at, const Series<Scalar<D>>& x, const Series<Scalar<D>>& y) {
                               if (k == switches.size() || switches[k].at != at) return;
                               const bool acts = l < 0 || part.empty() || part[l] != 0.0;
                               arguments[k++] =
                                   acts ? programs_.argument(at, branches ? branches[at] : free_branch, x.x, y.x) : 1.0;
                           });
            if (k == first) return;
        }
    }

private:
    const ProgramsOf<Scalar<D>>& programs_;
    Scalar<D> least_cosine_;

    // The argument of a curve; NaN for a follower whose law does not act now, or whose stop does not touch.
    Scalar<D> followed(const Model<D>& model, int curve, const Pose<D>& pose) const {
        const auto [number, _, of, second] = model.curves[curve];
        if (of == Of::row) return pose.curved(curve);
        if (of == Of::coordinate) return Coordinate<D>(model.coordinates, number, pose).value();
        const bool acts = of == Of::law ? part.empty() || part[number] != 0.0 : touching.count(number) > 0;
        const PrimitiveSet<D>& set = of == Of::law ? model.loads->coordinates : model.stop_coordinates;
        return acts ? Coordinate<D>(set, number, pose).foot(second) : free_branch;
    }
    static Scalar<D> value(const Law<D>& law, const Coordinate<D>& along, const Channels<D>& channels) {
        return is_angle(along.p.kind) ? along.value(channels.expected(law.coordinate)) : along.value();
    }

    // The part of a law that keeps its direction of sliding, which may turn at a constant rate.
    Scalar<D> kept(int l, int partner, Scalar<D> t) const {
        if (partner < 0 || (turning[l] == 0.0 && turning[partner] == 0.0)) return part[l];
        const Scalar<D> own = part[l] + turning[l] * (t - since),
                        other = part[partner] + turning[partner] * (t - since);
        return own / hypot(own, other);
    }
    bool is_given(int l) const { return !acts.empty() && acts[l] == Acts::given; }

    // The variables of a law's program: its coordinate and the speed along it; and the part of its value along the law's tangent.
    // That part is 1 except for friction in a plane, whose program gets the speed in the plane.
    struct Seen {
        Scalar<D> at, rate, speed, part;

        Seen(const Loads<D>& loads, int l, const Applied& applied, const Coordinate<D>& along, const Pose<D>& pose,
             const Motion<D>& motion, const Channels<D>& channels)
            : at(value(loads.laws[l], along, channels)), rate(along.rate(motion)), speed(rate),
              part(applied.part.empty() ? 1.0 : applied.part[l]) {
            const Law<D>& law = loads.laws[l];
            if (!applied.acts.empty()) {
                if (applied.acts[l] == Acts::kept) speed = 0.0, part = applied.kept(l, law.partner, channels.time());
                if (applied.acts[l] != Acts::in_plane) return;
            } else if (law.partner < 0) {
                return;
            }
            const bool turns = !applied.acts.empty();
            const Scalar<D> own = turns ? part : law.own, other = turns ? applied.part[law.partner] : law.other;
            const Scalar<D> across = Coordinate<D>(loads.coordinates, law.partner, pose).rate(motion);
            speed = hypot(rate, across);
            part = !(speed > 0.0) ? own : own * rate + other * across < 0.0 ? -rate / speed : rate / speed;
        }
    };

    void pull(const Coordinate<D>& along, Scalar<D> size) {
        for (int s = 0; s < along.p.slot_count; ++s) {
            const Attachment<D>& a = along.attachment(s);
            if (a.is_point) force[a.body] += size * along.g[s];
            torque[a.body] += moment(along.spoke[s], Point<D>(size * along.g[s]));
        }
    }

    bool apply(const Loads<D>& loads, int l, const Pose<D>& pose, const Motion<D>& motion, Channels<D>& channels) {
        const Law<D>& law = loads.laws[l];
        const Coordinate<D> along(loads.coordinates, l, pose);
        const Seen now(loads, l, *this, along, pose, motion, channels);
        const Scalar<D> times = pace.empty() ? 1.0 : pace[l];
        given[l] = 0.0;
        if (is_given(l))
            given[l] = part[l];
        else if (law.program >= 0)
            given[l] = now.part * programs_.value(law.program, channels.variables(now.at, now.speed * times), held);
        const Scalar<D> added = given[l] * load_of(loads, l);
        const Scalar<D> size = added - law.stiffness * (now.at - law.free) - law.damping * now.rate;
        (law.loses ? dissipation : power) += (law.loses ? -added : added) * now.rate;
        dissipation += law.damping * now.rate * now.rate;
        if (law.apart >= 0) lost[law.apart] = -added * now.rate;
        if (!isfinite(size)) return false;
        pull(along, size);
        return true;
    }

    bool apply(const Bushing<D>& bushing, const Pose<D>& pose, const Motion<D>& motion) {
        const Deflection<D> bent(bushing, pose);
        if (!(bent.cosine() >= least_cosine_ || bushing.turns_freely)) return false;
        const auto rate = bent.rate([&](int b) { return motion[b].velocity; }, [&](int b) { return motion[b].omega; });
        const auto viscous = (bent.damping() * rate).eval();
        dissipation += viscous.dot(rate);
        bent.pull(bushing.preload - bushing.stiffness * bent.value() - viscous, force, torque);
        return true;
    }

    // The wrench of a given force or torque with these components: a force at the centre of mass and a moment, global axes.
    static std::pair<Point<D>, Turn<D>> wrench(const BodyForce<D>& given, const Column<3, Scalar<D>>& components,
                                               const Pose<D>& pose) {
        const Rotation<D>& A = pose[given.body].rotation;
        if (given.is_torque) {
            const Turn<D> vector = given.torque_map * components;
            return {Point<D>::Zero(), given.in_body ? to_global(A, vector) : vector};
        }
        Point<D> vector = given.force_map * components;
        if (given.in_body) vector = A * vector.eval();
        const Point<D> arm = A * given.point;
        return {vector, moment(arm, vector)};
    }

    bool apply(const BodyForce<D>& given, const Pose<D>& pose, const Motion<D>& motion, Channels<D>& channels) {
        Column<3, Scalar<D>> components;
        for (int k = 0; k < 3; ++k) components[k] = programs_.value(given.programs[k], channels.variables(), held);
        if (!components.allFinite()) return false;
        const auto [push, twist] = wrench(given, components, pose);
        force[given.body] += push;
        torque[given.body] += twist;
        power += push.dot(motion[given.body].velocity) + twist.dot(motion[given.body].omega);
        return true;
    }
};

}  // namespace mbproj
