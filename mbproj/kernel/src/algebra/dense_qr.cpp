// The loops' equations by an orthogonal factorisation, by Eigen.
#include <Eigen/QR>

#include "algebra/decompositions.hpp"

namespace mbproj {

struct DenseQr::Factor {
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> of;
};

void DenseQr::factor(const Eigen::MatrixXd& Y) {
    factor_ = std::make_shared<const Factor>(Factor{Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(Y)});
}

void DenseQr::solve(Eigen::VectorXd& w, const Eigen::VectorXd& c, Eigen::VectorXd& lambda) const {
    const auto& qr = factor_->of;
    const auto rows = c.size();
    const auto R = qr.matrixQR().topRows(rows).template triangularView<Eigen::Upper>();
    Eigen::VectorXd along = qr.householderQ().adjoint() * w;
    const Eigen::VectorXd wanted = R.adjoint().solve(Eigen::VectorXd(qr.colsPermutation().transpose() * c));
    lambda = qr.colsPermutation() * Eigen::VectorXd(R.solve(along.head(rows) - wanted));
    along.head(rows) = wanted;
    w = qr.householderQ() * along;
}

}  // namespace mbproj
