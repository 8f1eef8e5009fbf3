#include "model/model.hpp"

#include "model/dual.hpp"

namespace mbproj {

template <class D> Model<D>::Model() = default;
template <class D> Model<D>::Model(const Model&) = default;
template <class D> Model<D>::Model(Model&&) noexcept = default;
template <class D> Model<D>& Model<D>::operator=(Model&&) noexcept = default;
template <class D> Model<D>::~Model() = default;

template struct Model<Plane<double>>;
template struct Model<Space<double>>;
template struct Model<Plane<Dual>>;
template struct Model<Space<Dual>>;

}  // namespace mbproj
