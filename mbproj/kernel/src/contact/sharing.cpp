#include "contact/sharing.hpp"

#include "contact/contact_problem.hpp"

namespace mbproj {

bool Sharing::find(double t, const Vector& y, const ContactState& state, const std::vector<FrictionLaw>& laws,
                   int stops, const std::vector<ContactRow>& near, std::vector<int>& found) {
    found.clear();
    std::vector<ContactRow> rows = near;
    const auto first = static_cast<Eigen::Index>(rows.size());
    for (int k = 0; k < static_cast<int>(laws.size()); ++k)
        if (!has(state.sliding, k) && (laws[k].stop < 0 || state.touches(laws[k].stop)))
            rows.push_back({stops + k, 1.0, 0.0});
    if (rows.size() < 2) return true;
    border_->hold(rows);
    equations_.set_pose(t, y.data());
    equations_.set_velocities(y.data(), false);
    if (!equations_.factor(Metric::mass) || !border_->factor()) return false;
    const std::vector<Vector> open = balanced_with_themselves(rows, state, first);
    if (open.empty()) return true;
    const auto takes_part = [&](Eigen::Index k) {
        return std::any_of(open.begin(), open.end(),
                           [&](const Vector& y) { return std::abs(y[k]) > thresholds_.no_part; });
    };
    std::vector<int> stop, friction;
    for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(rows.size()); ++k)
        if (takes_part(k)) (k < first ? stop : friction).push_back(rows[static_cast<std::size_t>(k)].coordinate);
    if (!border_->factor(true)) return false;
    Eigen::MatrixXd own(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(open.size()));
    for (std::size_t k = 0; k < open.size(); ++k)
        own.col(static_cast<Eigen::Index>(k)) =
            open[k].cwiseQuotient(border_->operator_of_rows().diagonal().cwiseSqrt().cwiseMax(Limits::min()));
    const Eigen::MatrixXd lambda = border_->reactions() * own;
    const double size = own.cwiseAbs().maxCoeff();
    for (const auto& [k, way] : state.sliding) {
        const bool by_load = laws[k].bearing >= 0 && changes(laws[k].bearing, lambda, size);
        if (by_load || has(stop, laws[k].stop)) friction.push_back(stops + k);
    }
    std::sort(stop.begin(), stop.end()), std::sort(friction.begin(), friction.end());
    found = stop;
    found.insert(found.end(), friction.begin(), friction.end());
    for (const int joint : are_walls(rows, open) ? std::vector<int>() : loaded(t, y, rows, own, lambda, size))
        found.push_back(stops + static_cast<int>(laws.size()) + joint);
    return true;
}

void Sharing::find_least(double t, const double* y, const ContactState& state, const std::vector<FrictionLaw>& laws,
                         int stops, std::vector<ContactRow> rows, std::vector<double>& forces) {
    const std::size_t touching = rows.size();
    std::vector<Cone> cones;
    for (std::size_t at = 0; at < touching; ++at) {
        cones.push_back({static_cast<int>(at), {}, 0.0, {}});
        for (int k = 0; k < static_cast<int>(laws.size()); ++k) {
            if (laws[k].stop != rows[at].coordinate) continue;
            cones[at].most = std::max(cones[at].most, (1.0 + thresholds_.slips) * laws[k].fixed);
            if (has(state.sliding, k)) continue;
            cones[at].tangents.push_back(static_cast<int>(rows.size()));
            rows.push_back({stops + k, 1.0, 0.0});
        }
    }
    if (touching < 2 || rows.size() == touching) return;  // the forces at one point are unique
    border_->hold(rows);
    equations_.set_pose(t, y);
    if (!equations_.factor(Metric::mass) || !border_->factor()) return;
    for (Cone& cone : cones) {  // rows along which nothing can move have no force
        auto& own = cone.tangents;
        own.erase(std::remove_if(own.begin(), own.end(), [&](int row) { return !border_->moves(row); }), own.end());
    }
    Vector borne(static_cast<Eigen::Index>(rows.size())), least;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        borne[row] = border_->moves(row) ? forces[rows[k].coordinate] : 0.0;
    }
    const Eigen::MatrixXd& B = border_->operator_of_rows();
    if (!contact_problem(B, -B * borne, cones, thresholds_, least)) return;
    for (std::size_t k = 0; k < rows.size(); ++k) forces[rows[k].coordinate] = least[static_cast<Eigen::Index>(k)];
}

std::vector<Sharing::Vector> Sharing::balanced_with_themselves(const std::vector<ContactRow>& rows,
                                                               const ContactState& state, Eigen::Index first) const {
    const Eigen::MatrixXd& B = border_->operator_of_rows();
    std::vector<Eigen::Index> sure, counts;
    for (Eigen::Index k = 0; k < B.rows(); ++k)
        if (border_->moves(k) && (k >= first || state.touches(rows[static_cast<std::size_t>(k)].coordinate)))
            sure.push_back(k);
    const std::vector<Eigen::Index> own = independent(B, sure, thresholds_.no_push);
    std::vector<Vector> found;
    for (Eigen::Index k = 0; k < B.rows(); ++k) {
        if (!border_->moves(k) || std::binary_search(own.begin(), own.end(), k)) continue;
        const Vector part = solved(B(own, own), B(own, std::vector<Eigen::Index>{k}).col(0));
        const double left = B(k, k) - part.dot(B(own, std::vector<Eigen::Index>{k}).col(0));
        if (left > thresholds_.no_push * B(k, k)) continue;
        Vector open = Vector::Zero(B.rows());
        open[k] = 1.0;
        for (std::size_t i = 0; i < own.size(); ++i)
            open[own[i]] = -part[static_cast<Eigen::Index>(i)] * std::sqrt(B(own[i], own[i]) / B(k, k));
        found.push_back(open);
    }
    return found;
}

bool Sharing::are_walls(const std::vector<ContactRow>& rows, const std::vector<Vector>& open) const {
    for (const Vector& each : open) {
        int coordinate = -1;
        for (std::size_t k = 0; k < rows.size(); ++k) {
            if (std::abs(each[static_cast<Eigen::Index>(k)]) <= thresholds_.no_part) continue;
            const int own = model_.stops.joint_coordinate[rows[k].coordinate];
            if (own < 0 || (coordinate >= 0 && own != coordinate)) return false;
            coordinate = own;
        }
    }
    return true;
}

bool Sharing::changes(int number, const Eigen::MatrixXd& lambda, double size) const {
    const double arm = equations_.arm(number);
    for (Eigen::Index k = 0; k < lambda.cols(); ++k) {
        const Vector own = lambda.col(k);
        if (equations_.load(number, equations_.supports(number, own.data())) > thresholds_.no_part * arm * size)
            return true;
    }
    return false;
}

std::vector<int> Sharing::loaded(double t, const Vector& y, const std::vector<ContactRow>& rows,
                                 const Eigen::MatrixXd& own, const Eigen::MatrixXd& lambda, double size) const {
    if (joints_in_space) {
        Eigen::MatrixXd forces =
            Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(model_.stops.bound.size()), own.cols());
        for (std::size_t k = 0; k < rows.size(); ++k)
            forces.row(rows[k].coordinate) = rows[k].sign * own.row(static_cast<Eigen::Index>(k));
        return joints_in_space(t, y, forces);
    }
    std::vector<int> found;
    const auto behind = model_.driven_count() + model_.flywheel_count();
    for (int j = 0; j < model_.first_stiff() - static_cast<int>(behind); ++j)
        if (bears(model_.joints[j], lambda, size)) found.push_back(j);
    return found;
}

bool Sharing::bears(const Joint& joint, const Eigen::MatrixXd& lambda, double size) const {
    if (joint.rows == 0 || joint.bushing >= 0) return false;
    for (Eigen::Index k = 0; k < lambda.cols(); ++k)
        if (equations_.borne(joint, &lambda(0, k)) > thresholds_.no_part * size * model_.length) return true;
    return false;
}

}  // namespace mbproj
