// The loops' equations by an orthogonal factorisation of Y itself, which S = YᵀY squares the condition of: for neighbours
// whose masses differ by more than S has digits for. Dense, and used only there.
#pragma once

#include <Eigen/QR>

#include "model/dimension.hpp"

namespace mbproj {

class DenseQr final {
public:
    // Y P = Q R with the columns, which are the constraints' rows, in the order of their remaining lengths.
    void factor(const Eigen::MatrixXd& Y) { qr_.compute(Y); }

    // The w next to the one given with Yᵀw = c, and the λ by which it is moved: w - Yλ.
    void solve(Eigen::VectorXd& w, const Eigen::VectorXd& c, Eigen::VectorXd& lambda) const {
        const auto rows = c.size();
        const auto R = qr_.matrixQR().topRows(rows).template triangularView<Eigen::Upper>();
        Eigen::VectorXd along = qr_.householderQ().adjoint() * w;
        const Eigen::VectorXd wanted = R.adjoint().solve(Eigen::VectorXd(qr_.colsPermutation().transpose() * c));
        lambda = qr_.colsPermutation() * Eigen::VectorXd(R.solve(along.head(rows) - wanted));
        along.head(rows) = wanted;
        w = qr_.householderQ() * along;
    }

private:
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr_;
};

}  // namespace mbproj
