// The laws of contacts and dry friction at an instant, from records, and the decompositions that they use: for tests.
#include <nanobind/eigen/dense.h>

#include "bind/from_numpy.hpp"
#include "bind/record.hpp"
#include "contact/coulomb_problem.hpp"
#include "contact/impact.hpp"
#include "contact/one_sided.hpp"
#include "model/decompositions.hpp"

namespace mbproj {

namespace {

using Vector = Eigen::VectorXd;

Vector vector(Record& given, const char* name, std::size_t size = Record::any) {
    const std::vector<double> found = given.numbers(name, size);
    return Eigen::Map<const Vector>(found.data(), static_cast<Eigen::Index>(found.size()));
}
nb::object array(const Vector& found) {
    return array_of(std::vector<double>(found.begin(), found.end()), found.size());
}

// B of some rows, and the accelerations, or the rates, without the forces along them.
struct Rows {
    RowMajor B;
    Vector b;
    explicit Rows(Record& given) : b(vector(given, "b")) { B = given.matrix("B", size(), size()); }
    std::size_t size() const { return static_cast<std::size_t>(b.size()); }
};

std::vector<Cone> cones_of(Record& given, std::size_t rows) {
    std::vector<Cone> cones;
    for (const nb::object& each : given.list("cones")) {
        Record one(each, "cones.");
        Cone cone{one.index("push", rows, -1), one.indices("tangents", {Record::any}, rows).values, one.number("most"),
                  one.numbers("slides")};
        if (!cone.slides.empty() && cone.slides.size() != cone.tangents.size())
            one.refuse("slides", "do not fit the tangents");
        cones.push_back(std::move(cone));
    }
    return cones;
}

nb::object contact_problem_of(Record& given) {
    const Rows rows(given);
    Vector y;
    const auto thresholds = given.object<Thresholds>("thresholds");
    return contact_problem(rows.B, rows.b, cones_of(given, rows.size()), thresholds, y) ? array(y) : nb::none();
}

nb::object coulomb_problem_of(Record& given) {
    const Rows rows(given);
    Vector y, a;
    const auto thresholds = given.object<Thresholds>("thresholds");
    return coulomb_problem(rows.B, rows.b, cones_of(given, rows.size()), thresholds, y, a) ? array(y) : nb::none();
}

nb::object one_sided_of(Record& given) {
    const Rows rows(given);
    Vector z;
    return one_sided(rows.B, rows.b, given.object<Thresholds>("thresholds").no_push, z) ? array(z) : nb::none();
}

// Rows of stops, then of frictions.
struct BalanceOfLoads {
    Thresholds thresholds;
    FrictionBalance problem;
    FrictionBalance::Loads loads;
};

BalanceOfLoads balance_of(Record& given) {
    const Rows rows(given);
    BalanceOfLoads made{given.object<Thresholds>("thresholds"), {}, {}};
    FrictionBalance& problem = made.problem;
    problem.B = rows.B, problem.b = rows.b;
    problem.fixed = vector(given, "static");
    const auto count = static_cast<std::size_t>(problem.fixed.size()), stops = rows.size() - count;
    if (count > rows.size()) given.refuse("static", "has a wrong shape");
    problem.stops = static_cast<Eigen::Index>(stops);
    problem.sliding = vector(given, "sliding", count);
    problem.direction = vector(given, "direction", count);
    problem.still = vector(given, "still", count);
    problem.stop = given.indices("stop", {count}, stops, -1).values;
    problem.partner = given.indices("partner", {count}, count, -1).values;
    for (const int able : given.indices("able", {rows.size()}, 2).values) problem.able.push_back(able != 0);
    problem.up = problem.down = std::vector<bool>(count);
    made.loads = [by = given.take("loads"), count](const Vector& y, Vector& found) {
        nb::dict answer;
        answer["loads"] = by(array(y));
        Record own(answer);
        found = vector(own, "loads", count);
    };
    return made;
}

// The rows that hold, the parts of each stop, which are idle, which have no share, whether the motion depends on it.
nb::tuple shares_told(const Shares& found) {
    const RowMajor parts = found.parts;
    return nb::make_tuple(
        std::vector<long>(found.rows.begin(), found.rows.end()),
        array_of(std::vector<double>(parts.data(), parts.data() + parts.size()), parts.rows(), parts.cols()),
        found.idle, found.apart, found.decides);
}

// The forces y, or None; then the directions, which are stuck, the parts of static forces; and how stops share, or None.
nb::tuple decide(BalanceOfLoads& self) {
    Balanced found;
    FrictionBalance& problem = self.problem;
    if (!problem.decide(self.loads, self.thresholds, found))
        return nb::make_tuple(nb::none(), array(problem.direction));
    const nb::object shares = found.shared ? nb::object(shares_told(found.shares)) : nb::none();
    return nb::make_tuple(array(found.y), array(found.direction), found.stuck, array(found.part), shares);
}

nb::object forces(const BalanceOfLoads& self) {
    Vector y;
    return self.problem.forces(self.loads, self.thresholds, y) ? array(y) : nb::none();
}

// The impulses of stops and their tangents, the rates afterwards and the energy that each takes; None where the law has no answer.
// Of each tangent its `partner`, or -1, and the stop `by` which it rubs.
nb::object strike_of(Record& given) {
    const Rows rows(given);
    const Vector restitution = vector(given, "restitution");
    const auto stops = static_cast<std::size_t>(restitution.size()), tangents = rows.size() - stops;
    if (stops > rows.size()) given.refuse("restitution", "has a wrong shape");
    const Rubbing rubbing{given.numbers("coefficient", tangents),
                          given.indices("partner", {tangents}, tangents, -1).values,
                          given.indices("by", {tangents}, stops).values};
    const auto thresholds = given.object<Thresholds>("thresholds");
    const auto law = impact_laws[given.index("law", std::size(impact_laws))];
    const Vector slow = Vector::Constant(restitution.size(), thresholds.stop_rests);
    Impact impact;
    if (impact.strike(law, rows.B, rows.b, restitution, slow, rubbing, std::vector<bool>(rows.size(), true),
                      thresholds) != Strike::done)
        return nb::none();
    return nb::make_tuple(array(impact.impulse), array(impact.after), array(impact.taken));
}

void require_rows(const char* name, Eigen::Index rows, Eigen::Index wanted) {
    if (rows != wanted) refuse(name, "has a wrong shape");
}

// Q R of Y: the nearest w - Yλ with Yᵀ(w - Yλ) = c, and λ.
nb::tuple nearest(const Eigen::MatrixXd& Y, Vector w, const Vector& c) {
    require_rows("w", w.size(), Y.rows()), require_rows("c", c.size(), Y.cols());
    if (Y.rows() < Y.cols()) refuse("Y", "has more columns than rows");
    PivotedQr qr;
    qr.factor(Y);
    Vector lambda;
    qr.solve(w, c, lambda);
    return nb::make_tuple(w, lambda);
}

int determinant_sign_of(int size, const std::vector<std::tuple<int, int, double>>& given) {
    std::vector<Entry> entries;
    for (const auto& [row, column, value] : given)
        entries.push_back({index_below(row, size, "row"), index_below(column, size, "column"), value});
    return determinant_sign(size, entries);
}

// Of a symmetric matrix of three rows: its least and largest eigenvalue, R with RᵀR = A, K⁻¹ with A = K Kᵀ, and |A⁻¹|.
nb::tuple small_decompositions(const Eigen::Matrix3d& given) {
    const Matrix<3, 3> A = matrix_at<3, 3>(given.data()), R = root<3>(A), inverse = inverse_root<3>(A);
    const auto [least, most] = eigenvalue_range<3>(A);
    const auto as_array = [](const Matrix<3, 3>& of) {
        return Eigen::Matrix3d(Eigen::Map<const Eigen::Matrix3d>(of.data()));
    };
    return nb::make_tuple(least, most, as_array(R), as_array(inverse), norm_of_inverse<3>(A));
}

void bind_decompositions(nb::module_& m) {
    m.def("solved", [](const Eigen::MatrixXd& A, const Vector& b) {
        require_rows("A", A.rows(), b.size()), require_rows("A", A.cols(), b.size());
        return solved(A, b);
    });
    m.def("least_squares", [](const Eigen::MatrixXd& A, const Vector& b) {
        require_rows("A", A.rows(), b.size());
        return least_squares(A, b);
    });
    m.def("nearest", &nearest);
    m.def("determinant_sign", &determinant_sign_of);
    m.def("small_decompositions", &small_decompositions);
}

}  // namespace

void bind_laws(nb::module_& m) {
    bind_decompositions(m);
    record_function(m, "contact_problem", &contact_problem_of,
                    "The forces of contacts and frictions that hold at an instant; None where none hold.");
    record_function(
        m, "coulomb_problem", &coulomb_problem_of,
        "The forces of contacts and frictions by Coulomb's law, which may slip; None where none are found.");
    record_function(m, "one_sided", &one_sided_of,
                    "The pushes of stops that only push; None where none open the gaps.");
    record_function(m, "strike", &strike_of,
                    "The impulses of an impact, the rates afterwards and the energy taken; None without an answer.");
    record_class(m, "FrictionBalance", &balance_of).def("decide", &decide).def("forces", &forces);
}

}  // namespace mbproj
