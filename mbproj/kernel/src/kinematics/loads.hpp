// Forces of a scene but gravity, as mbproj.dynamics.equations.forces defines them: laws on coordinates, given forces on bodies.
#pragma once

#include "kinematics/bushings.hpp"
#include "kinematics/pose.hpp"
#include "kinematics/primitives.hpp"
#include "model/programs.hpp"

namespace mbproj {

// F = -stiffness (s - free) - damping s' + program(t, s, s') on a coordinate s, which takes its turns from one of the
// joints' coordinates where it is an angle.
struct Law {
    int coordinate;  // of the joints, or -1
    double stiffness, damping, free;
    int program;  // or -1
    bool loses;   // what the program gives is energy lost, as a damper's
    int bearing;  // whose load what the program gives is multiplied by, or -1
    int apart;    // the number of the integral of what it loses, or -1
    // Of friction in a plane, the law along the other tangent, or -1, and the direction of sliding along both: what the
    // program gives of the speed v is along v, as long as that has not turned round.
    int partner;
    double own, other;
};

// A force at a point, or a torque: `map` takes the three programs' values to the body's axes or to the global ones.
template <int D> struct BodyForce {
    int body;
    Point<D> point;
    bool is_torque, in_body;
    Matrix<D, 3> force_map;
    Matrix<Size<D>::turns, 3> torque_map;
    int programs[3];
};

// An instruction of a law that changes its branch with the state.
struct Switch {
    int law, at;
};

template <int D> struct Loads {
    PrimitiveSet<D> coordinates;  // of the laws, one each
    std::vector<Law> laws;
    std::vector<BodyForce<D>> on_bodies;
    Programs programs;
    std::vector<Bushing<D>> bushings;
    std::vector<Switch> switches;  // those of a law one after another, in the order of its program

    // Whether a law's force changes with the state, not with time alone.
    bool depends_on_state(const Law& law) const {
        if (law.stiffness != 0.0 || law.damping != 0.0) return true;
        if (law.program < 0) return false;
        for (int at = programs.start[law.program]; at < programs.start[law.program + 1]; ++at)
            if (programs.op[at] == Op::variable && programs.operand[at] > 0.0) return true;
        return false;
    }

    // What forces act along: the coordinates of the laws, then six of each bushing.
    int size() const { return static_cast<int>(laws.size() + 6 * bushings.size()); }
};

// A law at a state: ∂(-F)/∂s and ∂(-F)/∂s', the rate s', and the part of F that a function gives.
struct LawSlopes {
    double of_value, of_rate, rate, given;
};

// What the loads do at a state: force and torque about the centre of mass of each body and the ground, global axes, the
// power of what functions give, and what dampers lose.
template <int D> struct Applied {
    std::vector<Point<D>> force;
    std::vector<Turn<D>> torque;
    double power = 0.0, dissipation = 0.0;
    const double* held = nullptr;  // the branches of the laws' programs, or none
    std::vector<double> carried;   // the loads of the bearings
    std::vector<double> lost;      // of laws whose losses are integrated apart, W
    std::vector<double> given;     // by the programs of laws, before any load

    explicit Applied(const Model<D>& model)
        : force(model.loads ? model.size() + 1 : 0), torque(force.size()), carried(model.bearings.size(), 0.0),
          lost(std::max(0, model.layout.quadratures.size - 2), 0.0),
          given(model.loads ? model.loads->laws.size() : 0, 0.0),
          least_cosine_(std::cos(0.5 * model.thresholds.most_turned)) {}

    // False where a function has no finite value, or a bushing has turned too far.
    bool update(const Loads<D>& loads, const Pose<D>& pose, const Motion<D>& motion, double t,
                const std::vector<double>& expected) {
        clear();
        power = dissipation = 0.0;
        for (std::size_t l = 0; l < loads.laws.size(); ++l)
            if (!apply(loads, static_cast<int>(l), pose, motion, t, expected)) return false;
        for (const BodyForce<D>& given : loads.on_bodies)
            if (!apply(loads, given, pose, motion, t)) return false;
        for (const Bushing<D>& bushing : loads.bushings)
            if (!apply(bushing, pose, motion)) return false;
        return true;
    }

    // How the force of a law changes with its coordinate and rate, on the branches that are held.
    LawSlopes slopes(const Loads<D>& loads, int l, const Pose<D>& pose, const Motion<D>& motion, double t,
                     const std::vector<double>& expected) const {
        const Law& law = loads.laws[l];
        LawSlopes found{law.stiffness, law.damping, 0.0, 0.0};
        if (law.program < 0) return found;
        Variables now(Along(loads.coordinates, l, pose), motion, t, law, expected.data());
        found.rate = now.rate;
        const double load = load_of(law) * along_sliding(loads, law, pose, motion, now);
        found.given = load * loads.programs.value(law.program, now.series, held);
        now.series[0].d = 0.0;
        const auto slope = [&](int variable) {
            now.series[variable].d = 1.0;
            const double rate = load * loads.programs.slope(law.program, now.series, held);
            now.series[variable].d = 0.0;
            return std::isfinite(rate) ? rate : 0.0;
        };
        found.of_value -= slope(1);
        found.of_rate -= slope(2);
        return found;
    }

    // Forces along coordinates, one after another, in place of what was applied.
    void clear() {
        for (auto& f : force) f.setZero();
        for (auto& f : torque) f.setZero();
    }
    double load_of(const Law& law) const { return law.bearing < 0 ? 1.0 : carried[law.bearing]; }
    void add(const Loads<D>& loads, int law, const Pose<D>& pose, double size) {
        pull(Along(loads.coordinates, law, pose), size);
    }
    // A force of size 1 along one of the coordinates that forces act along, in place of what was applied.
    void pull(const Loads<D>& loads, int l, const Pose<D>& pose) {
        clear();
        const int of_bushings = l - static_cast<int>(loads.laws.size());
        if (of_bushings >= 0) {
            const Bushing<D>& bushing = loads.bushings[of_bushings / 6];
            Deflection<D>(bushing, pose).pull(bushing.map.row(of_bushings % 6).transpose(), force, torque);
            return;
        }
        Along along(loads.coordinates, l, pose);
        pull(along, 1.0);
    }

    // What velocities and angular velocities (n + 1, global axes) make of one of these coordinates: its rate.
    double rate(const Loads<D>& loads, int l, const Pose<D>& pose, const std::vector<Point<D>>& velocity,
                const std::vector<Turn<D>>& omega) const {
        const auto velocity_of = [&](int b) { return velocity[b]; };
        const auto omega_of = [&](int b) { return omega[b]; };
        const int of_bushings = l - static_cast<int>(loads.laws.size());
        if (of_bushings < 0) return Along(loads.coordinates, l, pose).rate(velocity_of, omega_of);
        const Bushing<D>& bushing = loads.bushings[of_bushings / 6];
        return bushing.map.row(of_bushings % 6).dot(Deflection<D>(bushing, pose).rate(velocity_of, omega_of));
    }

    // The arguments of the switches at a state, with these branches, or none.
    static void look(const Loads<D>& loads, const Pose<D>& pose, const Motion<D>& motion, double t,
                     const double* expected, const double* branches, std::vector<double>& arguments) {
        for (std::size_t k = 0; k < loads.switches.size();) {
            const int l = loads.switches[k].law;
            const Along along(loads.coordinates, l, pose);
            const Variables variables(along, motion, t, loads.laws[l], expected);
            const std::size_t first = k;
            loads.programs.walk(
                loads.laws[l].program, variables.series, branches, [&](int at, const Series& x, const Series& y) {
                    if (k == loads.switches.size() || loads.switches[k].law != l || loads.switches[k].at != at) return;
                    const Op op = loads.programs.op[at];
                    arguments[k++] = op == Op::min || op == Op::max ? x.x - y.x : x.x;
                });
            if (k == first) return;
        }
    }

private:
    double least_cosine_;

    // The coordinate of a law at a pose: its gradient at each attachment.
    struct Along {
        const PrimitiveSet<D>& set;
        const Instance& p;
        Point<D> x[most_slots], spoke[most_slots], g[most_slots];

        Along(const PrimitiveSet<D>& coordinates, int l, const Pose<D>& pose) : set(coordinates), p(set.instances[l]) {
            for (Point<D>& each : x) each.setZero();
            for (int s = 0; s < p.slot_count; ++s) {
                const Attachment<D>& a = attachment(s);
                spoke[s] = pose[a.body].rotation * a.local;
                x[s] = a.is_point ? Point<D>(pose[a.body].position + spoke[s]) : spoke[s];
            }
            gradient<D>(p, x, g);
        }
        const Attachment<D>& attachment(int s) const { return set.attachments[p.slots[s]]; }
        template <class Velocity, class Omega> double rate(const Velocity& velocity, const Omega& omega) const {
            double sum = 0.0;
            for (int s = 0; s < p.slot_count; ++s) {
                const Attachment<D>& a = attachment(s);
                const Point<D> turning_velocity = turned_by(omega(a.body), spoke[s]);
                sum += g[s].dot(a.is_point ? Point<D>(velocity(a.body) + turning_velocity) : turning_velocity);
            }
            return sum;
        }
    };

    // What the program of a law depends on.
    struct Variables {
        double at, rate;
        Series series[3];

        Variables(const Along& along, const Motion<D>& motion, double t, const Law& law, const double* expected)
            : at(value<D>(along.p, along.x)),
              rate(along.rate([&](int b) { return motion[b].velocity; }, [&](int b) { return motion[b].omega; })) {
            if (along.p.kind == Kind::angle) at = near(at, expected[law.coordinate]);
            series[0] = {t, 1.0, 0.0};
            series[1] = {at, 0.0, 0.0};
            series[2] = {rate, 0.0, 0.0};
        }
    };

    // The part of friction in a plane that is along this law's tangent, 1 of other laws; its program sees the speed.
    static double along_sliding(const Loads<D>& loads, const Law& law, const Pose<D>& pose, const Motion<D>& motion,
                                Variables& now) {
        if (law.partner < 0) return 1.0;
        const double across =
            Along(loads.coordinates, law.partner, pose)
                .rate([&](int b) { return motion[b].velocity; }, [&](int b) { return motion[b].omega; });
        const double speed = std::hypot(now.rate, across);
        now.series[2] = {speed, 0.0, 0.0};
        if (!(speed > 0.0)) return law.own;
        return (law.own * now.rate + law.other * across < 0.0 ? -now.rate : now.rate) / speed;
    }

    void pull(const Along& along, double size) {
        for (int s = 0; s < along.p.slot_count; ++s) {
            const Attachment<D>& a = along.attachment(s);
            if (a.is_point) force[a.body] += size * along.g[s];
            torque[a.body] += moment(along.spoke[s], Point<D>(size * along.g[s]));
        }
    }

    bool apply(const Loads<D>& loads, int l, const Pose<D>& pose, const Motion<D>& motion, double t,
               const std::vector<double>& expected) {
        const Law& law = loads.laws[l];
        const Along along(loads.coordinates, l, pose);
        Variables now(along, motion, t, law, expected.data());
        const double part = along_sliding(loads, law, pose, motion, now);
        given[l] = law.program < 0 ? 0.0 : part * loads.programs.value(law.program, now.series, held);
        const double pushed = given[l] * load_of(law);
        const double size = pushed - law.stiffness * (now.at - law.free) - law.damping * now.rate;
        (law.loses ? dissipation : power) += (law.loses ? -pushed : pushed) * now.rate;
        dissipation += law.damping * now.rate * now.rate;
        if (law.apart >= 0) lost[law.apart] = -pushed * now.rate;
        if (!std::isfinite(size)) return false;
        pull(along, size);
        return true;
    }

    bool apply(const Bushing<D>& bushing, const Pose<D>& pose, const Motion<D>& motion) {
        const Deflection<D> bent(bushing, pose);
        if (!(bent.cosine() >= least_cosine_)) return false;
        const auto rate = bent.rate([&](int b) { return motion[b].velocity; }, [&](int b) { return motion[b].omega; });
        const auto viscous = (bushing.damping * rate).eval();
        dissipation += viscous.dot(rate);
        bent.pull(bushing.preload - bushing.stiffness * bent.value() - viscous, force, torque);
        return true;
    }

    bool apply(const Loads<D>& loads, const BodyForce<D>& given, const Pose<D>& pose, const Motion<D>& motion,
               double t) {
        const Series variables[3] = {{t, 1.0, 0.0}, {}, {}};
        Column<3> components;
        for (int k = 0; k < 3; ++k) components[k] = loads.programs.run(given.programs[k], variables).x;
        if (!components.allFinite()) return false;
        const Rotation<D>& A = pose[given.body].rotation;
        if (given.is_torque) {
            Turn<D> vector = given.torque_map * components;
            if (given.in_body) vector = to_global(A, vector);
            torque[given.body] += vector;
            power += vector.dot(motion[given.body].omega);
        } else {
            Point<D> vector = given.force_map * components;
            if (given.in_body) vector = A * vector.eval();
            const Point<D> arm = A * given.point;
            const Turn<D> twist = moment(arm, vector);
            force[given.body] += vector;
            torque[given.body] += twist;
            power += vector.dot(motion[given.body].velocity) + twist.dot(motion[given.body].omega);
        }
        return true;
    }
};

}  // namespace mbproj
