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
template <class D> Bushings<D> bushings(std::size_t bodies, const Integers1& body, const Numbers2& origin,
                                        const Numbers3& turn, const Numbers3& stiffness, const Numbers3& damping,
                                        const Numbers2& preload, const Numbers3& map, const Integers1& turns_freely) {
    constexpr int N = Bushing<D>::coordinates;
    const std::size_t count = preload.shape(0);
    require(body, {2 * count}, "bushing body");
    require(origin, {2 * count, D::axes}, "bushing origin");
    require(turn, {2 * count, D::axes, D::axes}, "bushing turn");
    require(stiffness, {count, N, N}, "bushing stiffness");
    require(damping, {count, N, N}, "bushing damping");
    require(preload, {count, N}, "bushing preload");
    require(map, {count, 6, N}, "bushing map");
    require(turns_freely, {count}, "bushing turns_freely");
    Bushings<D> built;
    for (std::size_t i = 0; i < count; ++i) {
        Bushing<D> one;
        for (int side = 0; side < 2; ++side) {
            one.body[side] = index_below(body.data()[2 * i + side], bodies + 1, "bushing body");
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
