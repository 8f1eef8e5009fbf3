// The laws of contacts and dry friction at an instant, and the decompositions that they use, with NumPy arrays: for tests.
#pragma once

#include <nanobind/stl/pair.h>

#include "algebra/decompositions.hpp"
#include "bindings/loads_from_numpy.hpp"
#include "laws/coulomb_problem.hpp"
#include "laws/impact.hpp"
#include "laws/one_sided.hpp"

namespace mbproj {

// The cone of a contact: its push, its tangents, the most that it holds, and the parts with which it slides.
using ConeNumbers = std::tuple<int, std::vector<int>, double, std::vector<double>>;

inline Eigen::VectorXd vector(const Numbers1& array, const char* name) {
    const std::vector<double> found = numbers(array, name);
    return Eigen::Map<const Eigen::VectorXd>(found.data(), static_cast<Eigen::Index>(found.size()));
}
inline nb::object array_of_vector(const Eigen::VectorXd& found) {
    return array_of(std::vector<double>(found.begin(), found.end()), static_cast<std::size_t>(found.size()));
}

inline std::vector<Cone> cones_of(const std::vector<ConeNumbers>& given, std::size_t size) {
    std::vector<Cone> cones;
    for (const auto& [push, tangents, most, slides] : given) {
        if (push != -1) index_below(push, size, "push");
        for (const int k : tangents) index_below(k, size, "tangents");
        if (!slides.empty() && slides.size() != tangents.size()) refuse("slides", "do not fit the tangents");
        cones.push_back({push, tangents, most, slides});
    }
    return cones;
}

inline nb::object contact_problem_of(const Thresholds& thresholds, const Numbers2& B, const Numbers1& b,
                                     const std::vector<ConeNumbers>& given) {
    require(B, {b.size(), b.size()}, "B");
    Eigen::VectorXd y;
    if (!contact_problem(matrix(B, "B"), vector(b, "b"), cones_of(given, b.size()), thresholds, y)) return nb::none();
    return array_of_vector(y);
}

inline nb::object coulomb_problem_of(const Thresholds& thresholds, const Numbers2& B, const Numbers1& b,
                                     const std::vector<ConeNumbers>& given) {
    require(B, {b.size(), b.size()}, "B");
    Eigen::VectorXd y, a;
    if (!coulomb_problem(matrix(B, "B"), vector(b, "b"), cones_of(given, b.size()), thresholds, y, a))
        return nb::none();
    return array_of_vector(y);
}

// The numbers of stops, then of frictions: B of their rows and b. For each friction its static and its sliding force, the
// direction in which it slides, an acceleration of round-off size, its stop and its partner.
struct BalanceNumbers {
    FrictionBalance problem;
    FrictionBalance::Loads loads;

    BalanceNumbers(const Numbers2& B, const Numbers1& b, const std::vector<Numbers1>& each, std::vector<int> stop,
                   std::vector<int> partner, std::vector<bool> able, nb::callable by) {
        const std::size_t size = b.size(), count = stop.size();
        require(B, {size, size}, "B");
        if (count > size || partner.size() != count || able.size() != size || each.size() != 4)
            refuse("frictions", "do not fit the rows");
        for (const int k : stop) optional_index(k, size - count, "stop");
        for (const int k : partner) optional_index(k, count, "partner");
        for (const Numbers1& one : each) require(one, {count}, "frictions");
        const std::vector<bool> none(count);
        problem = {static_cast<Eigen::Index>(size - count),
                   matrix(B, "B"),
                   vector(b, "b"),
                   vector(each[0], "static"),
                   vector(each[1], "sliding"),
                   vector(each[2], "direction"),
                   vector(each[3], "still"),
                   std::move(stop),
                   std::move(partner),
                   std::move(able),
                   none,
                   none};
        loads = [by = std::move(by), count](const Eigen::VectorXd& y, Eigen::VectorXd& found) {
            found = vector(nb::cast<Numbers1>(by(array_of_vector(y))), "loads");
            if (found.size() != static_cast<Eigen::Index>(count)) refuse("loads", "are not one of each friction");
        };
    }
};

// The rows that hold, the parts of each stop, which are idle, which have no share, whether the motion depends on it.
inline nb::tuple shares_told(const Shares& found) {
    const RowMajor parts = found.parts;
    return nb::make_tuple(std::vector<long>(found.rows.begin(), found.rows.end()),
                          array_of(std::vector<double>(parts.data(), parts.data() + parts.size()),
                                   static_cast<std::size_t>(parts.rows()), static_cast<std::size_t>(parts.cols())),
                          found.idle, found.apart, found.decides);
}

// The forces y, or None; then the directions, which are stuck, the parts of static forces; and how stops share, or None.
inline nb::tuple decided(const Thresholds& thresholds, BalanceNumbers& given) {
    Balanced found;
    FrictionBalance& problem = given.problem;
    const bool is_one = problem.decide(given.loads, thresholds, found);
    if (!is_one) return nb::make_tuple(nb::none(), array_of_vector(problem.direction));
    const nb::object shares = found.shared ? nb::object(shares_told(found.shares)) : nb::none();
    return nb::make_tuple(array_of_vector(found.y), array_of_vector(found.direction), found.stuck,
                          array_of_vector(found.part), shares);
}

inline nb::object one_sided_of(const Thresholds& thresholds, const Numbers2& B, const Numbers1& b) {
    require(B, {b.size(), b.size()}, "B");
    Eigen::VectorXd z;
    if (!one_sided(matrix(B, "B"), vector(b, "b"), thresholds.no_push, z)) return nb::none();
    return array_of_vector(z);
}

// The impulses of stops and their tangents, the rates afterwards and the energy that each takes; None where the law has no answer.
// `rubbing`: of each tangent its partner, or -1, and its stop.
inline nb::object strike_of(const Thresholds& thresholds, int law, const Numbers2& B, const Numbers1& before,
                            const Numbers1& restitution, const Numbers1& coefficient,
                            const std::vector<std::pair<int, int>>& rubbing) {
    const std::size_t size = before.size(), stops = restitution.size();
    require(B, {size, size}, "B");
    require(coefficient, {rubbing.size()}, "coefficient");
    if (stops + rubbing.size() != size) refuse("rubbing", "does not fit the rows");
    Rubbing own{numbers(coefficient, "coefficient"), {}, {}};
    for (const auto& [partner, by] : rubbing) {
        own.partner.push_back(optional_index(partner, rubbing.size(), "rubbing"));
        own.by.push_back(index_below(by, stops, "rubbing"));
    }
    const Eigen::VectorXd slow = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(stops), thresholds.stop_rests);
    Impact impact;
    const Strike found = impact.strike(static_cast<ImpactLaw>(index_below(law, std::size(impact_laws), "law")),
                                       matrix(B, "B"), vector(before, "before"), vector(restitution, "restitution"),
                                       slow, own, std::vector<bool>(size, true), thresholds);
    if (found != Strike::done) return nb::none();
    return nb::make_tuple(array_of_vector(impact.impulse), array_of_vector(impact.after),
                          array_of_vector(impact.taken));
}

inline nb::object forces_of(const Thresholds& thresholds, const BalanceNumbers& given) {
    Eigen::VectorXd y;
    if (!given.problem.forces(given.loads, thresholds, y)) return nb::none();
    return array_of_vector(y);
}

// Q R of Y: the nearest w - Yλ with Yᵀ(w - Yλ) = c, and λ.
inline nb::object nearest_of(const Numbers2& Y, const Numbers1& w, const Numbers1& c) {
    require(w, {Y.shape(0)}, "w"), require(c, {Y.shape(1)}, "c");
    if (Y.shape(0) < Y.shape(1)) refuse("Y", "has more columns than rows");
    PivotedQr qr;
    qr.factor(matrix(Y, "Y"));
    Eigen::VectorXd moved = vector(w, "w"), lambda;
    qr.solve(moved, vector(c, "c"), lambda);
    return nb::make_tuple(array_of_vector(moved), array_of_vector(lambda));
}

inline int determinant_sign_of(int size, const std::vector<std::tuple<int, int, double>>& given) {
    std::vector<Entry> entries;
    for (const auto& [row, column, value] : given)
        entries.push_back({index_below(row, size, "row"), index_below(column, size, "column"), value});
    return determinant_sign(size, entries);
}

// Of a symmetric matrix of three rows: its least and largest eigenvalue, R with RᵀR = A, K⁻¹ with A = K Kᵀ, and |A⁻¹|.
inline nb::object small_decompositions_of(const Numbers2& given) {
    require(given, {3, 3}, "A");
    const Matrix<3, 3> A = matrix_at<3, 3>(given.data()), R = root<3>(A), inverse = inverse_root<3>(A);
    const auto rows = [](const Matrix<3, 3>& of) {
        const Matrix<3, 3> by_rows = of.transpose();
        return array_of(std::vector<double>(by_rows.begin(), by_rows.end()), 3, 3);
    };
    const auto [least, most] = eigenvalue_range<3>(A);
    return nb::make_tuple(least, most, rows(R), rows(inverse), norm_of_inverse<3>(A));
}

inline void add_decompositions(nb::module_& m) {
    m.def("solved", [](const Numbers2& A, const Numbers1& b) {
        require(A, {b.size(), b.size()}, "A");
        return array_of_vector(solved(matrix(A, "A"), vector(b, "b")));
    });
    m.def("least_squares", [](const Numbers2& A, const Numbers1& b) {
        require(A, {b.size(), A.shape(1)}, "A");
        return array_of_vector(least_squares(matrix(A, "A"), vector(b, "b")));
    });
    m.def("nearest", &nearest_of);
    m.def("determinant_sign", &determinant_sign_of);
    m.def("small_decompositions", &small_decompositions_of);
}

inline void add_laws(nb::module_& m) {
    add_decompositions(m);
    m.def("contact_problem", &contact_problem_of, nb::arg("thresholds"), nb::arg("B"), nb::arg("b"), nb::arg("cones"),
          "The forces of contacts and frictions that hold at an instant; None where none hold.");
    m.def("coulomb_problem", &coulomb_problem_of, nb::arg("thresholds"), nb::arg("B"), nb::arg("b"), nb::arg("cones"),
          "The forces of contacts and frictions by Coulomb's law, which may slip; None where none are found.");
    m.def("one_sided", &one_sided_of, nb::arg("thresholds"), nb::arg("B"), nb::arg("b"),
          "The pushes of stops that only push; None where none open the gaps.");
    m.def("strike", &strike_of, nb::arg("thresholds"), nb::arg("law"), nb::arg("B"), nb::arg("before"),
          nb::arg("restitution"), nb::arg("coefficient"), nb::arg("rubbing"),
          "The impulses of an impact, the rates afterwards and the energy taken; None where the law has no answer.");
    nb::class_<BalanceNumbers>(m, "FrictionBalance")
        .def(nb::init<const Numbers2&, const Numbers1&, const std::vector<Numbers1>&, std::vector<int>,
                      std::vector<int>, std::vector<bool>, nb::callable>(),
             nb::arg("B"), nb::arg("b"), nb::arg("each"), nb::arg("stop"), nb::arg("partner"), nb::arg("able"),
             nb::arg("loads"))
        .def("decide", [](BalanceNumbers& self, const Thresholds& thresholds) { return decided(thresholds, self); })
        .def("forces",
             [](const BalanceNumbers& self, const Thresholds& thresholds) { return forces_of(thresholds, self); });
}

}  // namespace mbproj
