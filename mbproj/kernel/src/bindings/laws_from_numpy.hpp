// The laws of contacts and dry friction at an instant, with NumPy arrays: for the time loop in Python.
#pragma once

#include "bindings/loads_from_numpy.hpp"
#include "laws/friction_balance.hpp"

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

inline nb::object contact_problem_of(const Thresholds& thresholds, Numbers2 B, Numbers1 b,
                                     const std::vector<ConeNumbers>& given, double give) {
    const std::size_t size = b.size();
    require(B, {size, size}, "B");
    std::vector<Cone> cones;
    for (const auto& [push, tangents, most, slides] : given) {
        if (push != -1) index_below(push, size, "push");
        for (const int k : tangents) index_below(k, size, "tangents");
        if (!slides.empty() && slides.size() != tangents.size()) refuse("slides", "do not fit the tangents");
        cones.push_back({push, tangents, most, slides});
    }
    Eigen::VectorXd y;
    if (!contact_problem(matrix(B, "B"), vector(b, "b"), cones, give, thresholds, y)) return nb::none();
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

// How stops share, or None, with B of their rows, and of what each push does with the friction that slides by it.
inline nb::object shares_by(const Thresholds& thresholds, const Numbers2& B, const Numbers2& pulled,
                            const Numbers1& push) {
    require(B, {push.size(), push.size()}, "B");
    require(pulled, {push.size(), push.size()}, "pulled");
    Shares found;
    if (!shares_of(matrix(B, "B"), matrix(pulled, "pulled"), vector(push, "push"), thresholds, found))
        return nb::none();
    return shares_told(found);
}

inline nb::object forces_of(const Thresholds& thresholds, const BalanceNumbers& given) {
    Eigen::VectorXd y;
    if (!given.problem.forces(given.loads, thresholds, y)) return nb::none();
    return array_of_vector(y);
}

inline void add_laws(nb::module_& m) {
    m.def("contact_problem", &contact_problem_of, nb::arg("thresholds"), nb::arg("B"), nb::arg("b"), nb::arg("cones"),
          nb::arg("give"), "The forces of contacts and frictions that hold at an instant; None where none hold.");
    m.def("shares_of", &shares_by, nb::arg("thresholds"), nb::arg("B"), nb::arg("pulled"), nb::arg("push"),
          "How stops that push share, where their rows depend on each other; None where they do not.");
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
