// The primitives of curves, ropes and rolling, in numbers.
#include "kinematics/primitives.hpp"

namespace mbproj {

template double outline::value<Plane<double>>(const Instance<Plane<double>>&, const Point<Plane<double>>*,
                                              const Touch<Plane<double>>*);
template void outline::gradient<Plane<double>>(const Instance<Plane<double>>&, const Point<Plane<double>>*,
                                               Point<Plane<double>>*, const Touch<Plane<double>>*);
template double outline::curvature<Plane<double>>(const Instance<Plane<double>>&, const Point<Plane<double>>*,
                                                  const Point<Plane<double>>*, const Touch<Plane<double>>*);
template Touch<Plane<double>> on_curve::touch<Plane<double>>(const Instance<Plane<double>>&,
                                                             const Point<Plane<double>>*, int, int);
template double outline::value<Space<double>>(const Instance<Space<double>>&, const Point<Space<double>>*,
                                              const Touch<Space<double>>*);
template void outline::gradient<Space<double>>(const Instance<Space<double>>&, const Point<Space<double>>*,
                                               Point<Space<double>>*, const Touch<Space<double>>*);
template double outline::curvature<Space<double>>(const Instance<Space<double>>&, const Point<Space<double>>*,
                                                  const Point<Space<double>>*, const Touch<Space<double>>*);
template Touch<Space<double>> on_curve::touch<Space<double>>(const Instance<Space<double>>&,
                                                             const Point<Space<double>>*, int, int);

}  // namespace mbproj
