// Settings, bodies, primitives, joints and bushings from records.
#pragma once

#include <memory>
#include <optional>
#include <tuple>

#include <nanobind/stl/shared_ptr.h>

#include "algebra/decompositions.hpp"
#include "bindings/record.hpp"
#include "kinematics/bushings.hpp"
#include "model/model.hpp"
#include "model/settings.hpp"
#include "stepping/samples.hpp"

namespace mbproj {

// Times at which steps end: (time, left, right, actions, asks) of each.
using BreakNumbers = std::vector<std::tuple<double, double, double, std::vector<int>, bool>>;

inline std::vector<Break> breaks_of(const BreakNumbers& given) {
    std::vector<Break> breaks;
    for (const auto& [time, left, right, actions, asks] : given) {
        const bool after_last = breaks.empty() || left >= breaks.back().right;
        if (!(std::isfinite(time) && left < right && after_last)) refuse("breaks", "do not increase");
        breaks.push_back({time, left, right, actions, asks});
    }
    return breaks;
}

// Checks that the settings fit each other.
inline void check_settings(const Tableau& tableau, const ProjectionSettings& projection, const Steps& steps) {
    if (projection.every < 1 || projection.max_iterations < 1) refuse("every or max_iterations", "is not positive");
    for (const double number : {projection.alpha, projection.beta, projection.tolerance, projection.threshold})
        if (!std::isfinite(number)) refuse("projection", "holds a number that is not finite");
    if (!steps.fixed() && tableau.error.rows() == 0) refuse("tableau", "estimates no error");
}

// Checks that every array of a tableau has the shape for its s stages.
inline void check_tableau(const Tableau& t, int most_stages) {
    const Eigen::Index s = t.stages(), extra = static_cast<Eigen::Index>(t.extra_c.size());
    const bool embedded = t.error.rows() > 0;
    if (s < 1) refuse("b", "has a wrong shape");
    if (t.a.rows() != s || t.a.cols() != s) refuse("a", "has a wrong shape");
    if (static_cast<Eigen::Index>(t.c.size()) != s) refuse("c", "has a wrong shape");
    if (embedded && (t.error.rows() > 2 || t.error.cols() != s + 1)) refuse("error", "has a wrong shape");
    if (t.extra_a.rows() != extra || (extra && t.extra_a.cols() != s + 1 + extra))
        refuse("extra_a", "has a wrong shape");
    if (embedded && (t.dense.rows() != s + 1 + extra || t.dense.cols() < 1)) refuse("dense", "has a wrong shape");
    if (s + 1 + extra > most_stages) refuse("b", "has too many stages");
    if (t.order < 1 || (embedded && t.error_order < 1)) refuse("order", "is not positive");
}

// Checks a stiffly accurate method: its first stage is explicit, and each stage depends on none after it.
inline void check_implicit_tableau(const Tableau& t, int most_stages) {
    const Eigen::Index s = t.stages();
    require_positive(t.gamma, "gamma");
    if (s < 2 || s > most_stages) refuse("b", "has a wrong shape");
    if (t.a.rows() != s || t.a.cols() != s) refuse("a", "has a wrong shape");
    if (static_cast<Eigen::Index>(t.c.size()) != s) refuse("c", "has a wrong shape");
    if (t.error.cols() != s) refuse("error", "has a wrong shape");
    if (t.dense.rows() != s || t.dense.cols() < 1) refuse("dense", "has a wrong shape");
    if (t.order < 1 || t.error_order < 1) refuse("order", "is not positive");
    if (t.splitting.rows() != s || t.splitting.cols() != s) refuse("splitting", "has a wrong shape");
    if (!t.a.row(0).isZero(0.0)) refuse("a", "does not begin with the start of the step");
    for (Eigen::Index i = 0; i < s; ++i) {
        if (t.splitting(i, i) != (i ? t.gamma : 0.0)) refuse("splitting", "does not have gamma on its diagonal");
        if (t.a(s - 1, i) != t.b[i]) refuse("b", "is not the last stage");
        for (Eigen::Index j = i + 1; j < s; ++j)
            if (t.splitting(i, j) != 0.0) refuse("splitting", "is not lower triangular");
    }
}

// 5k - 2 numbers for k centres: the radii; the directions and the two weights of the spans; which circles the rope may leave, and
// the length that is subtracted.
inline std::shared_ptr<const RopePath> rope_path(const std::vector<double>& numbers) {
    const auto centres = static_cast<std::ptrdiff_t>((numbers.size() + 2) / 5);
    if (numbers.size() % 5 != 3 || centres < 2 || centres > most_centres) refuse("paths", "has a wrong length");
    auto path = std::make_shared<RopePath>();
    auto from = numbers.begin();
    const auto take = [&](std::vector<double>& into, std::ptrdiff_t count) {
        into.assign(from, from + count);
        from += count;
    };
    take(path->radii, centres), take(path->directions, centres - 1);
    take(path->by_length, centres - 1), take(path->by_angle, centres - 1);
    take(path->lifts, centres);
    path->wound = numbers.back();
    for (const double angle : path->directions) {
        path->cosine.push_back(std::cos(angle));
        path->sine.push_back(std::sin(angle));
    }
    return path;
}

// What instances follow: of each the number of its own among all, or -1 where its kind follows none.
template <class T> struct Followed {
    const char* name;
    Integers1 number;
    std::vector<std::shared_ptr<T>> all;

    std::shared_ptr<T> of(std::size_t instance, bool follows) const {
        const int64_t own = number.data()[instance];
        if (follows != (own >= 0)) refuse(name, "is given to a kind that follows none, or is missing");
        return follows ? all[index_below(own, all.size(), name)] : nullptr;
    }
};

template <class D> std::vector<Attachment<D>> attachments_of(Record& given) {
    const auto bodies = given.take<std::size_t>("bodies");
    const auto body = given.take<Integers1>("body");
    const std::size_t count = body.size();
    const auto is_point = given.array<Integers1>("is_point", {count});
    const auto local = given.array<Numbers2>("local", {count, D::axes});
    std::vector<Attachment<D>> made;
    for (std::size_t a = 0; a < count; ++a) {
        const Point<D> at = matrix_at<D::axes>(local.data() + D::axes * a);
        const bool point = is_point.data()[a] != 0;
        made.push_back({index_below(body.data()[a], bodies + 1, "body"), point, at, point ? at.largest() : 0.0});
    }
    return made;
}

// Attachments (body, is_point, local), instances (kind, slots, parameters, offset, weight); rows follow one another, but an instance that
// `joins` is of the row before.
template <class D> PrimitiveSet<D> primitive_set(Record& given) {
    PrimitiveSet<D> set;
    set.attachments = attachments_of<D>(given);
    const auto kind = given.take<Integers1>("kind");
    const std::size_t attachments = set.attachments.size(), instances = kind.size();
    const auto slots = given.array<Integers2>("slots", {instances, most_slots});
    const auto parameters = given.array<Numbers2>("parameters", {instances, most_parameters});
    const auto offset = given.array<Numbers1>("offset", {instances});
    const auto weight = given.array<Numbers1>("weight", {instances});
    const auto joins = given.array<Integers1>("joins", {instances});
    const auto number = [&](const char* name) { return given.array<Integers1>(name, {instances}); };
    const auto curves = given.take<std::vector<std::shared_ptr<PlaneCurve>>>("lines");
    const Followed<PlaneCurve> line{"line", number("line"), curves}, other{"other", number("other"), curves};
    const Followed<SpaceCurve> wire{"wire", number("wire"),
                                    given.take<std::vector<std::shared_ptr<SpaceCurve>>>("wires")};
    Followed<const RopePath> path{"path", number("path"), {}};
    for (const auto& numbers : given.take<std::vector<std::vector<double>>>("paths"))
        path.all.push_back(rope_path(numbers));
    for (std::size_t i = 0; i < instances; ++i) {
        Instance<D> p{};
        p.kind = static_cast<Kind>(index_below(kind.data()[i], std::size(forms), "kind"));
        p.wire = wire.of(i, is_in_space(p.kind));
        p.line = line.of(i, p.on_line() && !is_in_space(p.kind));
        p.other = other.of(i, is_of_two(p.kind));
        p.path = path.of(i, p.kind == Kind::rope);
        p.slot_count = p.path ? 2 + static_cast<int>(p.path->radii.size()) : form_of(p.kind).slots;
        for (int s = 0; s < p.slot_count; ++s)
            p.slots[s] = index_below(slots.data()[most_slots * i + s], attachments, "slots");
        for (int k = 0; k < most_parameters; ++k) {
            p.parameters[k] = parameters.data()[most_parameters * i + k];
            if (k >= form_of(p.kind).parameters && p.parameters[k] != 0.0)
                refuse("parameters", "has more than its kind takes");
        }
        p.coupled = joins.data()[i] != 0;
        p.rows = p.coupled ? 0 : p.kind == Kind::coincident ? D::axes : 1;
        set.rows += p.rows;
        p.row = set.rows - std::max(p.rows, 1);
        p.offset = offset.data()[i];
        p.weight = weight.data()[i];
        p.curve = -1;
        if (p.coupled) {
            const bool follows = i > 0 && set.instances.back().row == p.row;
            if (!follows || p.kind == Kind::coincident || set.instances.back().kind == Kind::coincident)
                refuse("joins", "couples what is no coordinate");
            set.instances.back().coupled = true;
        }
        set.instances.push_back(p);
    }
    return set;
}

// A joint that is a run of instances.
template <class D> Joint joint_of(const PrimitiveSet<D>& set, int bodies, int begin, int end) {
    Joint joint{begin, end, set.instances[begin].row, 0, {}};
    for (int i = begin; i < end; ++i) {
        const Instance<D>& p = set.instances[i];
        joint.rows += p.rows;
        for (int s = 0; s < p.slot_count; ++s) {
            const int body = set.attachments[p.slots[s]].body;
            if (body > bodies) refuse("constraints", "hold a body of more bodies than the model has");
            const bool known = std::find(joint.bodies.begin(), joint.bodies.end(), body) != joint.bodies.end();
            if (body < bodies && !known) joint.bodies.push_back(body);
        }
    }
    if (joint.rows > 6) refuse("joint_begin", "makes a joint of more than six rows");
    if (joint.bodies.empty()) refuse("joint_begin", "makes a joint between the ground and itself");
    return joint;
}

// The joints as runs of instances: joint j has those from begin[j] to begin[j + 1].
template <class D> std::vector<Joint> joints(Record& given, const PrimitiveSet<D>& set, int bodies) {
    std::vector<Joint> found;
    const auto begin = given.take<Integers1>("joint_begin");
    const auto count = static_cast<int64_t>(set.instances.size());
    if (begin.size() == 0 || begin.data()[0] != 0 || begin.data()[begin.size() - 1] != count)
        refuse("joint_begin", "does not run from the first instance to the last");
    for (std::size_t j = 0; j + 1 < begin.size(); ++j) {
        if (begin.data()[j] >= begin.data()[j + 1] || begin.data()[j + 1] > count)
            refuse("joint_begin", "does not increase");
        found.push_back(
            joint_of(set, bodies, static_cast<int>(begin.data()[j]), static_cast<int>(begin.data()[j + 1])));
    }
    return found;
}

template <class D> std::vector<Body<D>> bodies(Record& given, const Thresholds& below) {
    constexpr int W = Size<D>::turns;
    const auto mass = given.array<Numbers1>("mass", {any_length});
    const auto inertia = given.array<Numbers3>("inertia", {mass.shape(0), W, W});
    std::vector<Body<D>> found;
    const double heaviest = mass.shape(0) ? *std::max_element(mass.data(), mass.data() + mass.shape(0)) : 0.0;
    for (std::size_t b = 0; b < mass.shape(0); ++b) {
        Body<D> body;
        body.mass = mass.data()[b];
        body.inertia = matrix_at<W, W>(inertia.data() + W * W * b);
        const Matrix<W, W> skew = body.inertia - body.inertia.transpose();
        if (!(skew.norm() <= below.rounding * body.inertia.norm())) refuse("inertia", "is not symmetric");
        const auto [least, most] = eigenvalue_range(body.inertia);
        if (!(body.mass >= 0.0 && least >= -below.no_digits * most)) refuse("mass or inertia", "is negative");
        body.is_light = !(body.mass > below.no_digits * heaviest && least > below.no_digits * most);
        body.inverse_root.setIdentity();
        if (!body.is_light) body.inverse_root = inverse_root(body.inertia);
        found.push_back(body);
    }
    return found;
}

template <class D> struct Bushings {
    std::vector<Bushing<D>> each;
};

// Matrix number i of an array.
template <int Rows, int Columns> Matrix<Rows, Columns> matrix_of(const Numbers3& array, std::size_t i) {
    return matrix_by_rows<Rows, Columns>(array.data() + Rows * Columns * i);
}

// Two frames for each bushing: body, origin and rotation, one after the other.
template <class D> Bushings<D> bushings(Record& given) {
    constexpr int N = Bushing<D>::coordinates;
    const auto bodies = given.take<std::size_t>("bodies");
    const auto preload = given.array<Numbers2>("preload", {any_length, N});
    const std::size_t count = preload.shape(0);
    const auto body = given.array<Integers1>("body", {2 * count});
    const auto origin = given.array<Numbers2>("origin", {2 * count, D::axes});
    const auto turn = given.array<Numbers3>("turn", {2 * count, D::axes, D::axes});
    const auto stiffness = given.array<Numbers3>("stiffness", {count, N, N});
    const auto damping = given.array<Numbers3>("damping", {count, N, N});
    const auto map = given.array<Numbers3>("map", {count, 6, N});
    const auto turns_freely = given.array<Integers1>("turns_freely", {count});
    Bushings<D> built;
    for (std::size_t i = 0; i < count; ++i) {
        Bushing<D> one;
        for (int side = 0; side < 2; ++side) {
            one.body[side] = index_below(body.data()[2 * i + side], bodies + 1, "body");
            one.origin[side] = matrix_at<D::axes>(origin.data() + D::axes * (2 * i + side));
            one.turn[side] = matrix_of<D::axes, D::axes>(turn, 2 * i + side);
        }
        one.stiffness = matrix_of<N, N>(stiffness, i);
        one.damping = matrix_of<N, N>(damping, i);
        one.preload = matrix_at<N>(preload.data() + N * i);
        one.map = matrix_of<6, N>(map, i);
        one.turns_freely = turns_freely.data()[i] != 0;
        one.sees_pose =
            D::axes == 3 &&
            one.damping.template block<Size<D>::turns, Size<D>::turns>(D::axes, D::axes).squaredNorm() > 0.0;
        built.each.push_back(one);
    }
    return built;
}

// Checks rows of a model that may be left out.
template <class D>
std::optional<std::vector<int>> rows_from(const Model<D>& model, std::optional<std::vector<int>> rows) {
    if (!rows) return rows;
    for (std::size_t i = 0; i < rows->size(); ++i)
        if ((*rows)[i] < (i ? (*rows)[i - 1] + 1 : 0) || (*rows)[i] >= model.constraints.rows)
            refuse("left_out", "holds an index out of range");
    return rows;
}

}  // namespace mbproj
