// From NumPy arrays to bushings.
#pragma once

#include "bindings/from_numpy.hpp"
#include "kinematics/bushings.hpp"

namespace mbproj {

template <class D> struct Bushings { std::vector<Bushing<D>> each; };

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

}  // namespace mbproj
