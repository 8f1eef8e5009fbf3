// The rows of the loops' joints that are held, and how they couple: the structure of S, which depends on the rows
// alone. A body couples all its joints with each other. A body that moves by a hinge passes the rows of its other
// joints on to its parent. A shaft is a body with many joints and one freedom on a hinge to the ground. It is divided
// into equal pieces, one for each joint, each welded to the next: S then has a band in place of a full block, and one
// more row for each weld. Pieces of m/k are positive definite wherever the body is, so that nothing else changes.
#pragma once

#include <numeric>
#include <optional>

#include "solver/block_cholesky.hpp"
#include "solver/elimination_order.hpp"

namespace mbproj {

// Which joints of the loops have rows in S.
enum class LoopRows {
    reduced,       // without the hinges by which bodies move; shared bodies are divided into pieces
    hinges_first,  // with these hinges, before the others
    all,           // with these hinges, in the order of the model's joints
};

template <class D> class RowLayout final {
public:
    static constexpr int F = Size<D>::freedoms;

    // A joint and some of its rows: those held, or those left out. The joint of a weld is -1.
    struct JointRows {
        int joint, count;
        int rows[F];
        bool operator==(const JointRows& other) const {
            return joint == other.joint && count == other.count && std::equal(rows, rows + count, other.rows);
        }
    };
    // A joint of a list and one of its bodies, by its number in the loops, or a piece of the body. It has as many columns of Y as
    // the joint has rows.
    struct Incidence {
        int held, body, piece;
        int hinged = -1;              // its number among incidences of hinged bodies, or -1; -1 for a weld
        int row = 0, count = 0;       // its first row of S and the number of its rows
        int passed_on[2] = {-1, -1};  // incidences of hinged bodies that pass rows on to this body, or -1
        bool acts = true;             // whether the joint acts on the body itself
        bool has_one_entry = false;   // whether each column of Y has one entry, as for a body with one freedom
        bool is_weld = false;
        Matrix<F, F> Y = Matrix<F, F>::Zero();
    };
    struct Product {  // incidences a and b share a body: YᵀY goes to this block of S
        int a, b;
        std::size_t offset;
    };
    // A flywheel of inertia I with a row: one more coordinate, with the half-inverse 1/√I, and -1 in that row.
    struct Flywheel {
        int row;             // of S
        std::size_t offset;  // of its diagonal entry
        double y;            // its entry of Y
        bool is_compliant;   // whether it stands for a stiff force
    };

    RowLayout(const Model<D>& model, const EliminationOrder<D>& order, LoopRows which)
        : model_(model), order_(order), joints_(order.loop_joints), place_(model.size(), -1),
          hinge_of_(order.loop_bodies.size(), -1) {
        const bool reduced = which == LoopRows::reduced;
        if (!reduced)
            for (std::size_t h = 0; h < order.loop_hinges.size(); ++h)
                joints_.insert(joints_.begin() + h, order.loop_hinges[h].joint());
        if (which == LoopRows::hinges_first) first_ = static_cast<int>(order.loop_hinges.size());
        if (which == LoopRows::all) std::sort(joints_.begin(), joints_.end());
        for (std::size_t b = 0; b < order.loop_bodies.size(); ++b) place_[order.loop_bodies[b]] = static_cast<int>(b);
        if (reduced)
            for (std::size_t h = 0; h < order.loop_hinges.size(); ++h)
                hinge_of_[place_[order.loop_hinges[h].child()]] = static_cast<int>(h);
    }

    // Leaves out these rows of the model, ascending, and holds the others: their matrix, or nothing where none changes.
    std::optional<BlockCholesky> leave_out(const std::vector<int>& rows) {
        std::vector<JointRows> held;
        for (int h = 0; h < static_cast<int>(joints_.size()); ++h) {
            JointRows some{joints_[h], 0, {}};
            for (int r = 0; r < model_.joints[some.joint].rows; ++r)
                if (!std::binary_search(rows.begin(), rows.end(), model_.joints[some.joint].row + r))
                    some.rows[some.count++] = r;
            if (some.count) held.push_back(some);
        }
        if (held.size() == of_joints_ && std::equal(held.begin(), held.end(), held_.begin()) && is_arranged_)
            return std::nullopt;
        is_arranged_ = true;
        of_joints_ = held.size();
        held_ = std::move(held);
        return arrange();
    }

    // The joints that are held; the welds come last.
    const std::vector<JointRows>& held() const { return held_; }
    const std::vector<Incidence>& incidences() const { return incidences_; }
    std::vector<Incidence>& incidences() { return incidences_; }
    const std::vector<Product>& products() const { return products_; }
    const std::vector<Flywheel>& flywheels() const { return flywheels_; }
    const std::vector<int>& compliant() const { return compliant_; }  // the compliant joints among those held
    // The number of hinges that come before the other joints.
    int first() const { return first_; }
    // The numbers of rows that are held, and of joints in `held`.
    int count() const { return count_; }
    int joints() const { return static_cast<int>(of_joints_); }
    int hinged() const { return hinged_; }
    // The hinge by which a body of the loops moves, or -1; and the place in the loops of a body of the model.
    int hinge_of(int body) const { return hinge_of_[body]; }
    int place(int body) const { return place_[body]; }
    // The number of bodies and pieces; the first piece of a body has the number of the body.
    int pieces() const { return static_cast<int>(body_of_.size()); }
    int body_of(int piece) const { return body_of_[piece]; }
    // √k for a body of k pieces.
    double root(int body) const { return roots_[body]; }

private:
    BlockCholesky arrange() {
        incidences_.clear();
        products_.clear();
        hinged_ = 0;
        body_of_.resize(order_.loop_bodies.size());
        std::iota(body_of_.begin(), body_of_.end(), 0);
        roots_.assign(body_of_.size(), 1.0);
        std::vector<std::vector<int>> touching(body_of_.size());
        for (std::size_t h = 0; h < held_.size(); ++h)
            for (const int body : model_.joints[held_[h].joint].bodies) {
                const int b = place_[body];
                touching[b].push_back(static_cast<int>(incidences_.size()));
                const int hinged = hinge_of_[b] >= 0 ? hinged_++ : -1;
                add_incidence(static_cast<int>(h), b, b, hinged);
            }
        for (std::size_t i = 0, count = incidences_.size(); i < count; ++i)
            if (incidences_[i].hinged >= 0)
                pass_on(incidences_[i].held, incidences_[i].body, incidences_[i].hinged, touching);
        for (int b = 0, bodies = static_cast<int>(roots_.size()); b < bodies; ++b)
            if (is_taken_apart(b, touching[b])) take_apart(b, touching);
        return couple(touching);
    }

    // The rows of a joint of a hinged body also act on the parent from which it moves.
    void pass_on(int held, int body, int hinged, std::vector<std::vector<int>>& touching) {
        const int parent = order_.loop_hinges[hinge_of_[body]].parent();
        if (parent == model_.size()) return;
        std::vector<int>& of_parent = touching[place_[parent]];
        const auto is_same = [&](int i) { return incidences_[i].held == held; };
        auto at = std::find_if(of_parent.begin(), of_parent.end(), is_same);
        if (at == of_parent.end()) {
            at = of_parent.insert(of_parent.end(), static_cast<int>(incidences_.size()));
            add_incidence(held, place_[parent], place_[parent], -1);
            incidences_.back().acts = false;
        }
        int* passed_on = incidences_[*at].passed_on;
        passed_on[passed_on[0] < 0 ? 0 : 1] = hinged;
    }

    bool is_taken_apart(int b, const std::vector<int>& joints) const {
        return hinge_of_[b] >= 0 && order_.loop_hinges[hinge_of_[b]].freedoms() == 1 &&
               static_cast<int>(joints.size()) >= model_.thresholds.fewest_shared;
    }

    void take_apart(int b, std::vector<std::vector<int>>& touching) {
        const std::vector<int> joints = std::move(touching[b]);
        roots_[b] = sqrt(static_cast<double>(joints.size()));
        touching[b] = {joints[0]};
        for (std::size_t j = 1; j < joints.size(); ++j) {
            const int before = incidences_[joints[j - 1]].piece, piece = pieces();
            body_of_.push_back(b);
            touching.push_back({joints[j]});
            incidences_[joints[j]].piece = piece;
            weld(b, before, touching[before], 1.0);
            weld(b, piece, touching[piece], -1.0);
            held_.push_back({-1, 1, {}});
        }
    }
    void weld(int b, int piece, std::vector<int>& touching, double sign) {
        touching.push_back(static_cast<int>(incidences_.size()));
        add_incidence(static_cast<int>(held_.size()), b, piece, -1);
        incidences_.back().is_weld = true;
        incidences_.back().Y(0, 0) = sign;
    }
    void add_incidence(int held, int body, int piece, int hinged) {
        incidences_.push_back({held, body, piece});
        Incidence& at = incidences_.back();
        at.hinged = hinged;
        at.has_one_entry = hinge_of_[body] >= 0 && order_.loop_hinges[hinge_of_[body]].freedoms() == 1;
    }

    BlockCholesky couple(const std::vector<std::vector<int>>& touching) {
        std::vector<int> sizes;
        for (const JointRows& some : held_) sizes.push_back(some.count);
        std::vector<std::pair<int, int>> couplings;
        for (const auto& joints : touching)
            for (const int a : joints)
                for (const int b : joints) couplings.push_back({incidences_[a].held, incidences_[b].held});
        count_ = std::accumulate(sizes.begin(), sizes.end(), 0);
        BlockCholesky cholesky(std::move(sizes), couplings, first_);
        for (Incidence& at : incidences_) {
            at.row = cholesky.row(at.held);
            at.count = held_[at.held].count;
        }
        for (const auto& joints : touching)
            for (std::size_t a = 0; a < joints.size(); ++a)
                for (std::size_t b = 0; b <= a; ++b) add_product(joints[a], joints[b], cholesky);
        add_flywheels(cholesky);
        return cholesky;
    }

    void add_product(int a, int b, const BlockCholesky& cholesky) {
        const auto target = cholesky.target(incidences_[a].held, incidences_[b].held);
        products_.push_back(target.transposed ? Product{b, a, target.offset} : Product{a, b, target.offset});
    }

    void add_flywheels(const BlockCholesky& cholesky) {
        flywheels_.clear();
        compliant_.clear();
        for (int h = 0; h < joints(); ++h)
            if (const int joint = held_[h].joint; model_.holds_flywheel(joint)) {
                const double inertia = model_.flywheels[model_.joints[joint].row - model_.constraints.rows];
                flywheels_.push_back({cholesky.row(h), cholesky.target(h, h).offset, -1.0 / sqrt(inertia), false});
            }
        for (int h = 0; h < joints(); ++h) {
            if (!model_.is_compliant(held_[h].joint)) continue;
            compliant_.push_back(h);
            for (int r = 0; r < held_[h].count; ++r) {
                const std::size_t diagonal = cholesky.target(h, h).offset + r * (held_[h].count + 1);
                flywheels_.push_back({cholesky.row(h) + r, diagonal, -1.0, true});
            }
        }
    }

    const Model<D>& model_;
    const EliminationOrder<D>& order_;
    std::vector<int> joints_;
    int first_ = 0;
    std::vector<int> place_, hinge_of_;
    std::vector<JointRows> held_;
    std::size_t of_joints_ = 0;  // the number of joints in `held_`, without welds
    bool is_arranged_ = false;
    std::vector<Incidence> incidences_;
    std::vector<Product> products_;
    std::vector<Flywheel> flywheels_;
    std::vector<int> compliant_, body_of_;
    std::vector<double> roots_;
    int count_ = 0, hinged_ = 0;
};

}  // namespace mbproj
