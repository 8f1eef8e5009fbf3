// Models of mechanisms from records, in the plane and in space.
#include <array>
#include <map>
#include <memory>
#include <tuple>

#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bind/from_numpy.hpp"
#include "bind/functions.hpp"
#include "kinematics/loads.hpp"
#include "model/decompositions.hpp"

namespace mbproj {

namespace {

constexpr int none = -1;  // the least index where there may be none

// A model while it is read. What a record names has been read before it.
template <class D> class Reading {
public:
    explicit Reading(Record& given) : given_(given) {}

    Model<D> read() {
        model_.thresholds = given_.object<Thresholds>("thresholds");
        add_bodies();
        model_.length = given_.positive("length");
        Record constraints = given_.part("constraints"), coordinates = given_.part("coordinates");
        model_.constraints = primitive_set(constraints);
        model_.coordinates = primitive_set(coordinates);
        for (const Instance<D>& p : model_.coordinates.instances) model_.counts_turns.push_back(is_angle(p.kind));
        add_joints(constraints);
        model_.row_scale = given_.numbers("row_scale", model_.constraints.rows);
        for (const double scale : model_.row_scale)
            if (!(scale > 0.0)) given_.refuse("row_scale", "is not positive");
        Record programs = given_.part("programs");
        model_.programs = programs_of(programs);
        model_.first_rate = given_.index("first_rate", model_.programs.start.size());
        add_bearings();
        add_loads();
        add_driven_rows();
        add_stops();
        add_couplings();
        add_followers();
        model_.loads = loads_;
        add_layout();
        add_channels();
        add_switches();
        add_flywheels();
        add_actions();
        return std::move(model_);
    }

private:
    std::size_t coordinates() const { return model_.coordinates.instances.size(); }
    std::size_t bodies_and_ground() const { return model_.bodies.size() + 1; }

    void add_bodies() {
        const Thresholds& below = model_.thresholds;
        Columns<Body<D>> bodies(given_);
        bodies("mass", &Body<D>::mass)("inertia", &Body<D>::inertia);
        double heaviest = 0.0;
        for (const Body<D>& body : bodies.items) heaviest = std::max(heaviest, body.mass);
        for (Body<D>& body : bodies.items) {
            const TurnMatrix<D> skew = body.inertia - body.inertia.transpose();
            if (!(skew.norm() <= below.rounding * body.inertia.norm())) given_.refuse("inertia", "is not symmetric");
            const auto [least, most] = eigenvalue_range(body.inertia);
            if (!(body.mass >= 0.0 && least >= -below.no_digits * most))
                given_.refuse("mass or inertia", "is negative");
            body.is_light = !(body.mass > below.no_digits * heaviest && least > below.no_digits * most);
            body.inverse_root.setIdentity();
            if (!body.is_light) body.inverse_root = inverse_root(body.inertia);
        }
        model_.bodies = std::move(bodies.items);
        model_.gravity = matrix_at<D::axes>(given_.numbers("gravity", D::axes).data());
    }

    // Instances and the points and vectors in their slots, which are consecutive. Rows follow one another, but an instance
    // that `joins` is of the row before. Points and vectors that several instances use are stored once.
    PrimitiveSet<D> primitive_set(Record& given) const {
        using I = Instance<D>;
        using A = Attachment<D>;
        Columns<A> places(given);
        places("local", &A::local)("is_point", &A::is_point).index("body", &A::body, bodies_and_ground());
        Columns<I> instances(given);
        instances.index("kind", &I::kind, std::size(forms)).index("slot_count", &I::slot_count, most_slots + 1);
        instances("parameters", &I::parameters)("offset", &I::offset)("weight", &I::weight)("joins", &I::coupled);
        const std::vector<nb::object> follows = given.list("follows", instances.count());
        const std::vector<int> first = given.indices("first_slot", {instances.count()}, places.count()).values;

        PrimitiveSet<D> set;
        std::map<std::tuple<int, bool, std::array<double, D::axes>>, int> known;
        const auto stored = [&](A& place) {
            std::array<double, D::axes> local;
            std::copy_n(&place.local[0], D::axes, local.begin());
            const auto [at, is_new] =
                known.try_emplace({place.body, place.is_point, local}, static_cast<int>(set.attachments.size()));
            place.size = place.is_point ? place.local.largest() : 0.0;
            if (is_new) set.attachments.push_back(place);
            return at->second;
        };
        for (I& p : instances.items) {
            const std::size_t i = set.instances.size();
            if (!on_curve::takes(p.kind, p.slot_count)) given.refuse("slot_count", "is not that of its kind");
            if (!follow(p, follows[i])) given.refuse("follows", "is given to a kind that follows none, or is missing");
            if (first[i] + static_cast<std::size_t>(p.slot_count) > places.count())
                given.refuse("first_slot", "holds an index out of range");
            for (int s = 0; s < p.slot_count; ++s) p.slots[s] = stored(places.items[first[i] + s]);
            for (int k = form_of(p.kind).parameters; k < most_parameters; ++k)
                if (p.parameters[k] != 0.0) given.refuse("parameters", "has more than its kind takes");
            p.rows = p.coupled ? 0 : p.kind == Kind::coincident ? D::axes : 1;
            set.rows += p.rows;
            p.row = set.rows - std::max(p.rows, 1);
            p.curve = -1;
            if (p.coupled) {
                const bool follows_one = i > 0 && set.instances.back().row == p.row;
                if (!follows_one || p.kind == Kind::coincident || set.instances.back().kind == Kind::coincident)
                    given.refuse("joins", "couples what is no coordinate");
                set.instances.back().coupled = true;
            }
            set.instances.push_back(std::move(p));
        }
        return set;
    }

    // Takes what an instance follows: a rope, a space curve, two plane curves, or one. False where it is something else.
    static bool follow(Instance<D>& p, const nb::object& of) {
        if (p.kind == Kind::rope) {
            Record rope(of, "follows.");
            p.path = std::make_shared<RopePath>(rope_path_of(rope));
            return p.slot_count == 2 + static_cast<int>(p.path->radii.size());
        }
        if (is_in_space(p.kind)) return nb::try_cast(of, p.wire) && p.wire;
        if (!p.on_line()) return of.is_none();
        if (!is_of_two(p.kind)) return nb::try_cast(of, p.line) && p.line;
        std::pair<std::shared_ptr<const PlaneCurve>, std::shared_ptr<const PlaneCurve>> two;
        if (!nb::try_cast(of, two)) return false;
        std::tie(p.line, p.other) = two;
        return p.line && p.other;
    }

    // Adds a joint that is a run of instances of the constraints.
    void add_joint(std::size_t begin, std::size_t end, const char* name) {
        const PrimitiveSet<D>& set = model_.constraints;
        Joint joint{static_cast<int>(begin), static_cast<int>(end), set.instances[begin].row, 0, {}};
        for (std::size_t i = begin; i < end; ++i) {
            const Instance<D>& p = set.instances[i];
            joint.rows += p.rows;
            for (int s = 0; s < p.slot_count; ++s) {
                const int body = set.attachments[p.slots[s]].body;
                const bool known = std::find(joint.bodies.begin(), joint.bodies.end(), body) != joint.bodies.end();
                if (body < model_.size() && !known) joint.bodies.push_back(body);
            }
        }
        if (joint.rows > 6) given_.refuse(name, "makes a joint of more than six rows");
        if (joint.bodies.empty()) given_.refuse(name, "makes a joint between the ground and itself");
        model_.joints.push_back(std::move(joint));
    }

    // The instances of one owner are a joint. Owners without instances have none.
    void add_joints(Record& constraints) {
        const std::size_t count = model_.constraints.instances.size();
        const std::vector<int> owner = constraints.indices("owner", {count}, 1u << 30).values;
        if (!std::is_sorted(owner.begin(), owner.end())) constraints.refuse("owner", "does not increase");
        for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
            while (end < count && owner[end] == owner[begin]) ++end;
            joint_of_owner_[owner[begin]] = static_cast<int>(model_.joints.size());
            add_joint(begin, end, "constraints.owner");
        }
    }
    int joint_of_owner(int owner, const Record& given) const {
        const auto found = joint_of_owner_.find(owner);
        if (found == joint_of_owner_.end()) given.refuse("joint", "holds an index out of range");
        return found->second;
    }

    void add_bearings() {
        using B = Bearing<D>;
        if (!given_.has("bearings")) return;
        Columns<B> bearings(given_.part("bearings"));
        Record& given = bearings.given();
        bearings.index("joint", &B::joint, 1u << 30).index("body", &B::body, bodies_and_ground());
        bearings("point", &B::point)("axis", &B::axis)("radial", &B::radial)("axial", &B::axial);
        bearings("length", &B::length, false)("preload", &B::preload);
        const std::vector<nb::object> parts = given.list("parts", bearings.count());
        for (std::size_t b = 0; b < parts.size(); ++b) {
            bearings.items[b].joint = joint_of_owner(bearings.items[b].joint, given);
            std::vector<std::tuple<int, int, double>> own;
            if (!nb::try_cast(parts[b], own)) given.wrong_type("parts");
            for (const auto& [owner, row, part] : own) {
                const Joint& joint = model_.joints[joint_of_owner(owner, given)];
                if (row < 0 || row >= joint.rows) given.refuse("parts", "holds an index out of range");
                bearings.items[b].parts.emplace_back(joint.row + row, part);
            }
        }
        model_.bearings = std::move(bearings.items);
    }

    void add_loads() {
        if (!given_.has("loads")) return;
        Record given = given_.part("loads");
        loads_ = std::make_shared<Loads<D>>();
        add_laws(given.part("laws"));
        add_forces_on_bodies(given.part("on_bodies"));
        add_bushings(given.part("bushings"));
    }
    void add_laws(Record given) {
        using L = Law<D>;
        Record along = given.part("coordinates");
        loads_->coordinates = primitive_set(along);
        Columns<L> laws(given);
        laws("stiffness", &L::stiffness)("damping", &L::damping)("free", &L::free)("loses", &L::loses);
        laws.index("joint_coordinate", &L::coordinate, coordinates(), none);
        laws.index("program", &L::program, model_.first_rate, none);
        laws.index("bearing", &L::bearing, model_.bearings.size(), none);
        laws.index("partner", &L::partner, laws.count(), none);
        int apart = 0;
        laws.each("apart", {laws.count()}, [&](L& law, const double* is) { law.apart = *is != 0.0 ? apart++ : -1; });
        laws.each("sliding", {laws.count(), 2}, [](L& law, const double* at) { law.own = at[0], law.other = at[1]; });
        if (loads_->coordinates.instances.size() != laws.count()) given.refuse("stiffness", "has a wrong shape");
        for (std::size_t l = 0; l < laws.count(); ++l)
            if (laws.items[l].coordinate < 0 && is_angle(loads_->coordinates.instances[l].kind))
                given.refuse("joint_coordinate", "leaves an angle out");
        loads_->laws = std::move(laws.items);
    }
    // `axes` (.., 3, 3) take components to the axes of a plane and its normal, or to those of space.
    void add_forces_on_bodies(Record given) {
        using F = BodyForce<D>;
        constexpr int turns = Size<D>::turns;
        Columns<F> forces(std::move(given));
        forces("point", &F::point)("is_torque", &F::is_torque)("in_body", &F::in_body);
        forces.index("body", &F::body, bodies_and_ground()).index("program", &F::programs, model_.first_rate);
        forces.each("axes", {forces.count(), 3, 3}, [](F& force, const double* rows) {
            force.force_map = matrix_by_rows<D::axes, 3>(rows);
            force.torque_map = matrix_by_rows<turns, 3>(rows + 3 * (3 - turns));
        });
        loads_->on_bodies = std::move(forces.items);
    }
    void add_bushings(Record given) {
        using B = Bushing<D>;
        Columns<B> bushings(std::move(given));
        bushings("origin", &B::origin)("turn", &B::turn)("stiffness", &B::stiffness)("damping", &B::damping);
        bushings("preload", &B::preload)("turns_freely", &B::turns_freely);
        bushings.index("body", &B::body, bodies_and_ground());
        if constexpr (D::axes == 2) bushings("map", &B::map);
        for (B& one : bushings.items) {
            if constexpr (D::axes == 3) one.map.setIdentity();
            const auto turning = one.damping.template block<Size<D>::turns, Size<D>::turns>(D::axes, D::axes);
            one.sees_pose = D::axes == 3 && turning.squaredNorm() > 0.0;
        }
        loads_->bushings = std::move(bushings.items);
    }

    // The last rows of the constraints, one for each function of time: the last programs.
    void add_driven_rows() {
        using Row = DrivenRow<D>;
        Columns<Row> rows(given_.part("motions"));
        rows("start", &Row::start).index("joint_coordinate", &Row::coordinate, coordinates());
        const std::vector<Instance<D>>& instances = model_.constraints.instances;
        const std::size_t count = rows.count(), programs = model_.programs.size();
        if (count > instances.size() || count > programs) given_.refuse("motions", "do not fit the constraints");
        for (std::size_t k = 0; k < count; ++k) {
            const Instance<D>& p = instances[instances.size() - count + k];
            Row& row = rows.items[k];
            row.row = p.row, row.is_angle = is_angle(p.kind);
            row.program = static_cast<int>(programs - count + k);
            if (p.rows != 1) given_.refuse("constraints", "has a driven row that is not one");
            if (model_.programs.names(row.program, 1))
                given_.refuse("programs", "have a motion that is no function of the time");
        }
        model_.driven = std::move(rows.items);
    }

    // The coordinates that stops limit, and then those of frictions, one instance each.
    void add_stops() {
        if (!given_.has("contacts")) return;
        Record given = given_.part("contacts"), along = given.part("coordinates");
        model_.stop_coordinates = primitive_set(along);
        const std::size_t count = model_.stop_coordinates.instances.size();
        model_.stops.joint_coordinate = given.indices("joint_coordinate", {count}, coordinates(), none).values;
        model_.stops.bound = given.numbers("bound", count);
    }

    void add_couplings() {
        using C = Coupling;
        Columns<C> couplings(given_.part("couplings"));
        Record& given = couplings.given();
        couplings("period", &C::period)("growth", &C::growth).index("row", &C::row, model_.constraints.rows);
        const std::vector<int> own = given.indices("coordinate", {Record::any}, coordinates()).values;
        const std::vector<double> weight = given.numbers("weight", own.size());
        const std::vector<int> first = given.indices("first", {couplings.count()}, own.size()).values;
        couplings.index("program", &C::curve, model_.programs.size(), none);
        for (std::size_t k = 0; k < couplings.count(); ++k) {
            C& coupling = couplings.items[k];
            const int begin = first[k], end = k + 1 < first.size() ? first[k + 1] : static_cast<int>(own.size());
            if (end <= begin) given.refuse("first", "does not increase");
            coupling.coordinates.assign(own.begin() + begin, own.begin() + end);
            coupling.weights.assign(weight.begin() + begin, weight.begin() + end);
            if (coupling.period < 0.0) given.refuse("period", "is negative");
            for (const int coordinate : coupling.coordinates)
                if (model_.coordinates.instances[coordinate].kind == Kind::lap) coupling.rolls = true;
            if (coupling.rolls && coupling.coordinates.size() != 2)
                given.refuse("coordinate", "rolls without a roller");
            if (coupling.curve < 0) continue;
            const int program = std::exchange(coupling.curve, static_cast<int>(model_.curves.size()));
            add_curve_of_row(coupling, program);
        }
        model_.couplings = std::move(couplings.items);
    }
    void add_curve_of_row(const Coupling& coupling, int program) {
        if (model_.programs.names(program, 2))
            given_.refuse("programs", "have a coupling that is no function of its first coordinate");
        std::vector<Instance<D>>& instances = model_.constraints.instances;
        for (std::size_t i = 0; i < instances.size(); ++i)
            if (Instance<D>& p = instances[i]; p.row == coupling.row && p.rows == 1) {
                p.curve = coupling.curve;
                model_.curves.push_back({static_cast<int>(i), program});
            }
    }

    // The followers of curves: the list and number of each, whether it is the second of two curves that touch, and the program
    // whose switches are the curve's knots.
    void add_followers() {
        const Array<int> followers = given_.indices("followers", {Record::any, 4}, 1u << 30);
        for (std::size_t f = 0; f < followers.size(); ++f) {
            const int* row = followers.row(f);
            const Curve curve{row[1], row[3], static_cast<Of>(row[0]), row[2] != 0};
            PrimitiveSet<D>* const set = curve.of == Of::row             ? &model_.constraints
                                         : curve.of == Of::coordinate    ? &model_.coordinates
                                         : curve.of == Of::stop          ? &model_.stop_coordinates
                                         : curve.of == Of::law && loads_ ? &loads_->coordinates
                                                                         : nullptr;
            if (!set || curve.instance >= set->rows || curve.program >= model_.programs.size())
                given_.refuse("followers", "holds an index out of range");
            if (curve.of == Of::coordinate) model_.curves.push_back(curve);
            for (std::size_t i = 0; i < set->instances.size() && curve.of != Of::coordinate; ++i)
                if (set->instances[i].row == curve.instance && set->instances[i].rows == 1)
                    add_follower(*set, {static_cast<int>(i), curve.program, curve.of, curve.second});
        }
    }
    void add_follower(PrimitiveSet<D>& set, const Curve& curve) {
        const Programs& programs = model_.programs;
        Instance<D>& p = set.instances[curve.instance];
        const int code = programs.start[curve.program];
        if (programs.start[curve.program + 1] != code + 2 || programs.op[code + 1] != Op::table)
            given_.refuse("followers", "have a program that is no table");
        const int table = static_cast<int>(programs.operand[code + 1]);
        if (!is_held(p.kind) || (curve.second && !is_of_two(p.kind))) given_.refuse("followers", "have another curve");
        const std::size_t pieces = is_in_space(p.kind) ? p.wire->pieces.size()
                                   : curve.second      ? p.other->pieces.size()
                                                       : p.line->pieces.size();
        if (programs.table_start[table + 1] - programs.table_start[table] != static_cast<int>(pieces))
            given_.refuse("followers", "have another curve");
        (curve.second ? p.other_follower : p.follower) = static_cast<int>(model_.curves.size());
        for (Instance<D>& other : set.instances)  // the arc length there, in the row beside it
            if (curve.of == Of::row && (other.kind == Kind::lap || other.kind == Kind::beside_second) &&
                std::equal(p.slots, p.slots + 4, other.slots))
                other.follower = p.follower;
        model_.curves.push_back(curve);
    }
    // The blocks of y: the name of each, the magnitudes to which the absolute tolerance is relative, and its values at the start,
    // which are 0 where they are not given. Those without magnitudes come last.
    void add_layout() {
        Layout& built = model_.layout;
        const std::pair<const char*, Block*> known[] = {{"bodies", &built.bodies},
                                                        {"states", &built.states},
                                                        {"quadratures", &built.quadratures},
                                                        {"followed", &built.followed}};
        for (const nb::object& each : given_.list("layout")) {
            Record block(each, "layout.");
            std::string name;
            if (!nb::try_cast(block.take("name"), name)) block.wrong_type("name");
            const auto place =
                std::find_if(std::begin(known), std::end(known), [&](auto own) { return name == own.first; });
            if (place == std::end(known) || place->second->size > 0)
                given_.refuse("layout", "has a block that is not known");
            const std::vector<double> scale = block.array("scale", {Record::any}, false).values;
            *place->second = {built.size(), static_cast<int>(scale.size())};
            if (block.has("start")) {
                const std::vector<double> start = block.numbers("start", scale.size());
                built.start.insert(built.start.end(), start.begin(), start.end());
            }
            built.start.resize(place->second->end());
            for (const double size : scale) {
                if (!(size > 0.0)) block.refuse("scale", "is not positive");
                if (!std::isfinite(size)) continue;
                if (built.controlled() < place->second->first)
                    given_.refuse("layout", "has controlled blocks after others");
                built.scale.push_back(size);
            }
        }
        check_layout();
    }
    void check_layout() const {
        const Layout& own = model_.layout;
        int apart = 0;
        bool turns = !model_.couplings.empty();
        for (std::size_t l = 0; loads_ && l < loads_->laws.size(); ++l) {
            apart = std::max(apart, loads_->laws[l].apart + 1);
            turns = turns || is_angle(loads_->coordinates.instances[l].kind);
        }
        if (own.followed.size == 0 && turns) given_.refuse("layout", "does not follow the angles");
        if (own.bodies.first != 0) given_.refuse("layout", "does not begin with the bodies");
        const int programs = model_.programs.size() - static_cast<int>(model_.driven.size() + model_.curves.size());
        if (own.bodies.size != Size<D>::state * model_.size() || own.states.size != programs - model_.first_rate ||
            own.quadratures.size != (loads_ || !model_.driven.empty() ? 2 + apart : 0) ||
            (own.followed.size > 0 && own.followed.size != static_cast<int>(coordinates())))
            given_.refuse("layout", "has a block of a wrong size");
    }

    // The variables of programs: the kind and the number of each channel.
    void add_channels() {
        Columns<Channel> channels(given_.part("channels"));
        channels.index("kind", &Channel::kind, 3).index("index", &Channel::index, 1u << 30);
        for (const Channel& channel : channels.items)
            if (channel.index >=
                (channel.kind == ChannelKind::state ? model_.layout.states.size : static_cast<int>(coordinates())))
                channels.given().refuse("index", "holds an index out of range");
        model_.channels = std::move(channels.items);
        require_variables(model_.programs, variables(), "programs");
    }
    int variables() const { return law_variables + static_cast<int>(model_.channels.size()); }

    // Switches (program, instruction), program after program in the order of their instructions.
    void add_switches() {
        const Programs& programs = model_.programs;
        const Array<int> switches = given_.indices("switches", {Record::any, 2}, programs.op.size());
        for (std::size_t k = 0; k < switches.size(); ++k) {
            const auto [p, at] = std::pair(switches.row(k)[0], switches.row(k)[1]);
            if (p >= programs.size()) given_.refuse("switches", "holds an index out of range");
            if (at < programs.start[p] || at >= programs.start[p + 1] || !is_switching(programs.op[at]))
                given_.refuse("switches", "hold what is no switch of its program");
            if (k > 0 && model_.switches.back().at >= at) given_.refuse("switches", "do not increase");
            int law = -1, curve = -1;
            for (std::size_t l = 0; loads_ && l < loads_->laws.size(); ++l)
                if (loads_->laws[l].program == p) law = static_cast<int>(l);
            for (std::size_t c = 0; c < model_.curves.size(); ++c)
                if (model_.curves[c].program == p) curve = static_cast<int>(c);
            model_.switches.push_back({p, at, law, curve});
        }
    }

    // Flywheels that coordinates turn: their rows follow those of C, and each is a joint of its own.
    void add_flywheels() {
        if (!given_.has("flywheels")) return;
        Record given = given_.part("flywheels"), along = given.part("coordinates");
        const PrimitiveSet<D> turned = primitive_set(along);
        const std::size_t count = turned.instances.size();
        model_.flywheels = given.numbers("inertia", count);
        for (const double I : model_.flywheels)
            if (!(I > 0.0)) given.refuse("inertia", "is not positive");
        if (turned.rows != static_cast<int>(count)) given.refuse("coordinates", "are not one row each");
        PrimitiveSet<D>& set = model_.constraints;
        const int slots = static_cast<int>(set.attachments.size());
        set.attachments.insert(set.attachments.end(), turned.attachments.begin(), turned.attachments.end());
        for (Instance<D> p : turned.instances) {
            for (int s = 0; s < p.slot_count; ++s) p.slots[s] += slots;
            p.row += set.rows;
            set.instances.push_back(p);
            add_joint(set.instances.size() - 1, set.instances.size(), "flywheels");
        }
        model_.row_scale.resize(model_.all_rows(), 1.0);
    }

    // Action a sets the states from start[a] to start[a + 1] to the values of the programs with the same numbers.
    void add_actions() {
        if (!given_.has("actions")) return;
        Record given = given_.part("actions"), programs = given.part("programs");
        model_.action_programs = programs_of(programs);
        require_variables(model_.action_programs, variables(), "programs of actions");
        const std::size_t count = model_.action_programs.size();
        const std::vector<int> state = given.indices("state", {count}, model_.layout.states.size).values;
        const std::vector<int> start = given.indices("start", {Record::any}, count + 1).values;
        if (!std::is_sorted(start.begin(), start.end())) given.refuse("start", "does not increase");
        for (std::size_t a = 0; a + 1 < start.size(); ++a) {
            Action action;
            for (int k = start[a]; k < start[a + 1]; ++k) {
                action.states.push_back(state[k]);
                action.programs.push_back(k);
            }
            model_.actions.push_back(std::move(action));
        }
    }

    Record& given_;
    Model<D> model_;
    std::shared_ptr<Loads<D>> loads_;
    std::map<int, int> joint_of_owner_;
};

template <class D> Model<D> model_of(Record& given) { return Reading<D>(given).read(); }

template <class D> void add_model(nb::module_& m, const char* name) {
    record_class(m, name, &model_of<D>)
        .def_prop_ro("bodies", &Model<D>::size)
        .def_prop_rw(
            "rows", [](const Model<D>& self) { return self.rows; },
            [](Model<D>& self, const UsualRows& rows) {
                rows_from(self, std::make_optional(rows.left_out));
                self.rows = rows;
            });
}

}  // namespace

void bind_models(nb::module_& m) {
    add_model<Plane<double>>(m, "PlaneModel");
    add_model<Space<double>>(m, "SpaceModel");
}

}  // namespace mbproj
