// The laws of Newton, Poisson and Stronge.
#include "laws/impact.hpp"

#include "laws/impulse_path.hpp"
#include "laws/one_sided.hpp"

namespace mbproj {

Strike Impact::strike(ImpactLaw law, const Eigen::MatrixXd& B, const Vector& before, const Vector& restitution,
                      const Vector& slow, const Rubbing& rubbing, const std::vector<bool>& moves,
                      const Thresholds& thresholds) {
    rubbing_ = &rubbing, moves_ = &moves, thresholds_ = &thresholds;
    taken = Vector::Zero(before.size());
    if (law == ImpactLaw::energetic) return energetic(B, before, restitution, slow);
    const bool opens = law == ImpactLaw::newton ? newton(B, before, restitution) : poisson(B, before, restitution);
    return opens ? Strike::done : Strike::driven_into;
}

// The impulses that change rates b to possible ones: stops push, or are left, and the impulses of frictions are within
// the cones of these pushes and of those `given` before.
bool Impact::impulses(const Eigen::MatrixXd& B, const Vector& b, const Vector& given, Vector& y) const {
    const Eigen::Index frictions = rubbing_->size(), stops = b.size() - frictions;
    if (frictions == 0) return one_sided(B, b, thresholds_->no_push, y);
    const auto count = static_cast<std::size_t>(frictions);
    const Vector coefficient = Eigen::Map<const Vector>(rubbing_->coefficient.data(), frictions);
    const Vector none = Vector::Zero(frictions);
    const std::vector<bool> no(count);
    const FrictionBalance problem{stops,   B,  b, coefficient, coefficient, none, none, rubbing_->by, rubbing_->partner,
                                  *moves_, no, no};
    const auto loads = [&](const Vector& along, Vector& found) {
        found.resize(frictions);
        for (std::size_t k = 0; k < count; ++k)
            found[static_cast<Eigen::Index>(k)] = along[rubbing_->by[k]] + given[rubbing_->by[k]];
    };
    return problem.forces(loads, *thresholds_, y);
}

// The speed of each struck stop after the impact is -e times that before, or larger where it is left. As far as friction allows,
// nothing slides afterwards (Glocker and Pfeiffer 1995).
bool Impact::newton(const Eigen::MatrixXd& B, const Vector& before, const Vector& e) {
    Vector b = before;
    b.head(e.size()) += e.cwiseProduct(before.head(e.size()).cwiseMin(0.0));
    if (!impulses(B, b, Vector::Zero(e.size()), impulse)) return false;
    return work(B, before, impulse), true;
}

// Compression until no gap closes; then each stop pushes at least with e times its impulse of compression.
bool Impact::poisson(const Eigen::MatrixXd& B, const Vector& before, const Vector& e) {
    Vector compression, more;
    if (!impulses(B, before, Vector::Zero(e.size()), compression)) return false;
    work(B, before, compression);
    const Vector between = after;
    Vector least = Vector::Zero(before.size());
    least.head(e.size()) = e.cwiseProduct(compression.head(e.size()));
    if (!impulses(B, between + B * least, least.head(e.size()), more)) return false;
    work(B, between, least + more);
    impulse = compression + least + more;
    return true;
}

// One stop returns e² of the energy that it takes until its gap stops closing; other stops that touch stay passive.
Strike Impact::energetic(const Eigen::MatrixXd& B, const Vector& before, const Vector& e, const Vector& slow) {
    Eigen::Index first;
    before.head(e.size()).minCoeff(&first);
    std::vector<Eigen::Index> rows{first};
    double coefficient = 0.0;
    for (std::size_t k = 0; k < rubbing_->by.size(); ++k)
        if (rubbing_->by[k] == first)
            rows.push_back(e.size() + static_cast<Eigen::Index>(k)), coefficient = rubbing_->coefficient[k];
    if (!(B(first, first) > 0.0)) return Strike::driven_into;
    Vector own, work;
    if (rows.size() == 1) {
        own = Vector::Constant(1, -(1.0 + e[first]) * before[first] / B(first, first));
        work = own * (0.5 * (1.0 - e[first]) * before[first]);
    } else if (!follow_impulse(B(rows, rows), before(rows), coefficient, e[first], *thresholds_, own, work)) {
        return Strike::driven_into;
    }
    impulse = Vector::Zero(before.size());
    for (std::size_t r = 0; r < rows.size(); ++r) impulse[rows[r]] = own[r], taken[rows[r]] = -work[r];
    after = before + B * impulse;
    const auto closing = [&](const Vector& rate) { return (rate.head(e.size()).array() < -slow.array()).count(); };
    return closing(before) > 1 || closing(after) > 0 ? Strike::together : Strike::done;
}

// Impulses work at the mean of the rates before and after.
void Impact::work(const Eigen::MatrixXd& B, const Vector& before, const Vector& z) {
    after = before + B * z;
    taken -= 0.5 * z.cwiseProduct(before + after);
}

}  // namespace mbproj
