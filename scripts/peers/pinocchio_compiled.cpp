// Pinocchio called from C++: no Python between the steps. The models are those of pinocchio_models.py.
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/constrained-dynamics.hpp>

#include "runge_kutta.hpp"

namespace pin = pinocchio;
using Eigen::Map, Eigen::VectorXd, Eigen::Vector3d, Eigen::Matrix3d;
using Models = std::vector<pin::RigidConstraintModel, Eigen::aligned_allocator<pin::RigidConstraintModel>>;
using Datas = std::vector<pin::RigidConstraintData, Eigen::aligned_allocator<pin::RigidConstraintData>>;

namespace {

pin::SE3 shift(double x, double y, double z) { return {Matrix3d::Identity(), Vector3d(x, y, z)}; }

pin::Inertia inertia(double mass, double x, double y, double z, double centre) {
    return {mass, Vector3d(centre, 0, 0), pin::Symmetric3(Matrix3d(Vector3d(x, y, z).asDiagonal()))};
}

struct Base {
    pin::Model model;
    Base() { model.gravity.linear() = Vector3d(0, 0, -9.8); }
    template <class Joint>
    pin::JointIndex add(pin::JointIndex parent, const Joint &joint, const pin::SE3 &place, const pin::Inertia *body) {
        const auto index = model.addJoint(parent, joint, place, "joint" + std::to_string(model.njoints));
        if (body) model.appendBodyToJoint(index, *body);
        return index;
    }
    int size() const { return 2 * model.nv; }
};

struct Chain : Base {
    pin::Data data;
    VectorXd zero;
    explicit Chain(int links) {
        pin::JointIndex parent = 0;
        const auto bar = inertia(1.0, 0.01 / 6, 1.01 / 12, 1.01 / 12, 0.5);
        for (int i = 0; i < links; ++i) parent = add(parent, pin::JointModelRY(), shift(i ? 1.0 : 0.0, 0, 0), &bar);
        data = pin::Data(model);
        zero = VectorXd::Zero(links);
    }
    void derivative(const double *y, double *dy) {
        const int n = model.nv;
        const Map<const VectorXd> q(y, n), v(y + n, n);
        Map<VectorXd>(dy, n) = v;
        Map<VectorXd>(dy + n, n) = pin::aba(model, data, q, v, zero);
    }
};

struct SliderCrank : Base {
    pin::Data data;
    Models ball;
    Datas ball_data;
    VectorXd zero = VectorXd::Zero(4);
    pin::ProximalSettings accuracy{1e-14, 0.0, 1};
    SliderCrank() {
        const auto crank_body = inertia(0.12, 1e-4, 1e-4, 1e-5, 0.0), slider_body = inertia(2.0, 1e-4, 1e-4, 1e-4, 0.0),
                   rod_body = inertia(0.5, 4e-4, 4e-3, 4e-3, -0.15);
        const auto crank = add(0, pin::JointModelRX(), shift(0, 0.1, 0.12), &crank_body);
        const auto slider = add(0, pin::JointModelPX(), shift(0.2, 0, 0), &slider_body);
        const auto cross = add(slider, pin::JointModelRX(), pin::SE3::Identity(), nullptr);
        Matrix3d axes;
        const double root = std::sqrt(5.0);
        axes << 2 / 3., 0, -root / 3, -1 / 3., -2 / root, -2 / (3 * root), -2 / 3., 1 / root, -4 / (3 * root);
        const auto rod = add(cross, pin::JointModelRY(), pin::SE3(axes, Vector3d::Zero()), &rod_body);
        data = pin::Data(model);
        ball.emplace_back(pin::CONTACT_3D, model, crank, shift(0, 0, 0.08), rod, shift(-0.3, 0, 0));
        ball_data.emplace_back(ball[0]);
        pin::initConstraintDynamics(model, data, ball, ball_data);
    }
    void derivative(const double *y, double *dy) {
        const Map<const VectorXd> q(y, 4), v(y + 4, 4);
        Map<VectorXd>(dy, 4) = v;
        Map<VectorXd>(dy + 4, 4) = pin::constraintDynamics(model, data, q, v, zero, ball, ball_data, accuracy);
    }
};

}  // namespace

extern "C" {

void *chain_model(int links) { return new Chain(links); }
void *slider_crank_model() { return new SliderCrank; }

long chain(const Tableau *tableau, void *model, double *y, double duration, long steps, double tolerance) {
    return integrate(*static_cast<Chain *>(model), *tableau, y, duration, steps, tolerance);
}

long slider_crank(const Tableau *tableau, void *model, double *y, double duration, long steps, double tolerance) {
    return integrate(*static_cast<SliderCrank *>(model), *tableau, y, duration, steps, tolerance);
}

}
