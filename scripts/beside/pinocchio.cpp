// Pinocchio called from C++: no Python between the steps. The model is that of by_pinocchio.py, joint by joint.
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/constrained-dynamics.hpp>

#include "runge_kutta.hpp"

namespace pin = pinocchio;
using Eigen::Map, Eigen::VectorXd, Eigen::Vector3d, Eigen::Matrix3d;
using Models = std::vector<pin::RigidConstraintModel, Eigen::aligned_allocator<pin::RigidConstraintModel>>;
using Datas = std::vector<pin::RigidConstraintData, Eigen::aligned_allocator<pin::RigidConstraintData>>;

namespace {

Matrix3d rows(const double *numbers) { return Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers); }

struct System {
    pin::Model model;
    pin::Data data;
    Models balls;
    Datas ball_data;
    VectorXd zero;
    pin::ProximalSettings accuracy{1e-14, 0.0, 1};

    int size() const { return 2 * model.nv; }

    void derivative(const double *y, double *dy) {
        const int n = model.nv;
        const Map<const VectorXd> q(y, n), v(y + n, n);
        Map<VectorXd>(dy, n) = v;
        if (balls.empty())
            Map<VectorXd>(dy + n, n) = pin::aba(model, data, q, v, zero);
        else
            Map<VectorXd>(dy + n, n) = pin::constraintDynamics(model, data, q, v, zero, balls, ball_data, accuracy);
    }
};

}  // namespace

extern "C" {

void *create(const double *gravity) {
    auto *system = new System;
    system->model.gravity.linear() = Map<const Vector3d>(gravity);
    return system;
}

// `which`: hinges about x, y, z, slides along x, y, z. `place`: nine numbers of the rotation, three of the origin. `body`:
// mass, centre, nine numbers of the inertia about it; a mass of zero is none.
void add(void *system, int parent, int which, const double *place, const double *body) {
    pin::Model &model = static_cast<System *>(system)->model;
    const pin::SE3 at(rows(place), Map<const Vector3d>(place + 9));
    const pin::JointModel joints[] = {pin::JointModelRX(), pin::JointModelRY(), pin::JointModelRZ(),
                                      pin::JointModelPX(), pin::JointModelPY(), pin::JointModelPZ()};
    const auto joint = model.addJoint(parent, joints[which], at, "joint" + std::to_string(model.njoints));
    if (body[0] > 0.0) {
        const pin::Inertia inertia(body[0], Map<const Vector3d>(body + 1), pin::Symmetric3(rows(body + 4)));
        model.appendBodyToJoint(joint, inertia);
    }
}

void close_loop(void *system, int first, const double *one, int second, const double *other) {
    auto &own = *static_cast<System *>(system);
    const pin::SE3 here(Matrix3d::Identity(), Map<const Vector3d>(one)), there(Matrix3d::Identity(), Map<const Vector3d>(other));
    own.balls.emplace_back(pin::CONTACT_3D, own.model, first, here, second, there);
}

void ready(void *system) {
    auto &own = *static_cast<System *>(system);
    own.data = pin::Data(own.model);
    own.zero = VectorXd::Zero(own.model.nv);
    for (const auto &ball : own.balls) own.ball_data.emplace_back(ball);
    if (!own.balls.empty()) pin::initConstraintDynamics(own.model, own.data, own.balls, own.ball_data);
}

long advance(const Tableau *tableau, void *system, double *y, double duration, long steps, double tolerance) {
    return integrate(*static_cast<System *>(system), *tableau, y, duration, steps, tolerance);
}

}
