// The forces on a bearing's two supports, and along its axis, or a contact's push; linear in the multipliers.
#pragma once

#include "model/matrix.hpp"
#include "model/scalar.hpp"

namespace mbproj {

// In the plane the third number of a force is 0.
struct Supports {
    Column<3> first = Column<3>::Zero(), second = Column<3>::Zero();
    double along = 0.0;

    void add(const Supports& other, double part) {
        first += part * other.first;
        second += part * other.second;
        along += part * other.along;
    }
    // The load of a bearing without the preload.
    template <class Bearing> double load(const Bearing& bearing) const {
        if (bearing.is_push()) return along;
        return bearing.radial * (first.norm() + second.norm()) + bearing.axial * abs(along);
    }
    // The change of the load where the supports change by `change`.
    template <class Bearing> double slope(const Bearing& bearing, const Supports& change) const {
        if (bearing.is_push()) return change.along;
        const auto part = [](const Column<3>& f, const Column<3>& by) {
            const double size = f.norm();
            return size > 0.0 ? f.dot(by) / size : by.norm();
        };
        return bearing.radial * (part(first, change.first) + part(second, change.second)) +
               bearing.axial * (along < 0.0 ? -change.along : change.along);
    }
};

}  // namespace mbproj
