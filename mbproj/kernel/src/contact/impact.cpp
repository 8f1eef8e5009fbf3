// The laws of Newton, Poisson and Stronge.
#include "contact/impact.hpp"

#include "contact/one_sided.hpp"
#include "model/decompositions.hpp"
#include "model/semidefinite.hpp"

namespace mbproj {

namespace {

// The rates without the part that no impulse changes, where that is slower than rates at rest, `slow`: round-off of rows that
// depend on each other. No impulses would end it, however large.
Eigen::VectorXd changeable(const Eigen::MatrixXd& B, const Eigen::VectorXd& rate, const Eigen::VectorXd& slow,
                           double none) {
    std::vector<Eigen::Index> able;
    for (Eigen::Index k = 0; k < rate.size(); ++k)
        if (B(k, k) > 0.0) able.push_back(k);
    const Eigen::VectorXd size = B.diagonal()(able).cwiseSqrt(), unit = size.cwiseInverse();
    SemidefiniteCholesky cholesky;
    cholesky.factor(unit.asDiagonal() * B(able, able) * unit.asDiagonal(), none);
    if (cholesky.full()) return rate;
    const Eigen::MatrixXd N = cholesky.root();
    const Eigen::VectorXd own = size.cwiseProduct(N * least_squares(N, rate(able).cwiseProduct(unit)));
    Eigen::VectorXd found = rate;
    found(able) = own;
    return ((rate - found).array().abs() <= slow.array()).all() ? found : rate;
}

}  // namespace

Strike Impact::strike(ImpactLaw law, const Eigen::MatrixXd& B, const Vector& rate, const Vector& restitution,
                      const Vector& slow, const Rubbing& rubbing, const std::vector<bool>& moves,
                      const Thresholds& thresholds) {
    rubbing_ = &rubbing, moves_ = &moves, thresholds_ = &thresholds;
    taken = Vector::Zero(rate.size());
    Vector rests(rate.size());
    rests.head(slow.size()) = slow;
    for (Eigen::Index k = 0; k < rubbing.size(); ++k)
        rests[slow.size() + k] = slow[rubbing.by[static_cast<std::size_t>(k)]];
    const Vector before = changeable(B, rate, rests, thresholds.no_push);
    const bool opens = law == ImpactLaw::newton    ? newton(B, before, restitution)
                       : law == ImpactLaw::poisson ? poisson(B, before, restitution)
                                                   : energetic(B, before, restitution, slow);
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

// The path along the normal impulses of Newton's law: it ends at Newton's impulses where no sliding stops or turns, and stops
// have one restitution. Where it does turn, some gaps may still close at the end: they come to rest.
bool Impact::energetic(const Eigen::MatrixXd& B, const Vector& before, const Vector& e, const Vector& slow) {
    constexpr int most_paths = 500;
    const auto closes = [&] { return (after.head(e.size()).array() < -slow.array()).any(); };
    impulse = Vector::Zero(before.size()), after = before;
    if (!along_path(B, e)) return false;
    const Vector none = Vector::Zero(e.size());
    for (int path = 1; closes(); ++path)
        if (path > most_paths || !along_path(B, none)) return false;
    return true;
}

// Adds a path from the rates `after` on. Where friction leaves no impulses by Newton's law, those without friction lead it.
// A path that cannot be followed leaves Newton's impulses where they create no energy, or those of compression, which never do
// (Moreau 1988).
bool Impact::along_path(const Eigen::MatrixXd& B, const Vector& e) {
    const Eigen::Index stops = e.size();
    Vector b = after, lead, z, done;
    b.head(stops) += e.cwiseProduct(after.head(stops).cwiseMin(0.0));
    const Vector none = Vector::Zero(stops);
    const bool is_newtons = impulses(B, b, none, lead);
    if (!is_newtons && !one_sided(B.topLeftCorner(stops, stops), b.head(stops), thresholds_->no_push, lead))
        return false;
    const auto creates = [&](const Vector& impulse) {
        return impulse.dot(after + 0.5 * (B * impulse)) > thresholds_->creates_energy * std::abs(impulse.dot(after));
    };
    if (rubbing_->size() == 0 ||
        !follow_impulse(B, after, lead.head(stops), e, *rubbing_, *moves_, *thresholds_, z, done)) {
        z = lead;
        if ((!is_newtons || creates(z)) && !impulses(B, after, none, z)) return false;
        done = 0.5 * z.cwiseProduct(after + after + B * z);
    }
    impulse += z, taken -= done, after += B * z;
    return true;
}

// Impulses work at the mean of the rates before and after.
void Impact::work(const Eigen::MatrixXd& B, const Vector& before, const Vector& z) {
    after = before + B * z;
    taken -= 0.5 * z.cwiseProduct(before + after);
}

}  // namespace mbproj
