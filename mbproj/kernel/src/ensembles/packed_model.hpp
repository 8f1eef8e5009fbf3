// The models of several cases as one whose numbers are packs, and the test whether models are alike enough for that.
#pragma once

#include "elimination/elimination_order.hpp"
#include "ensembles/pack.hpp"
#include "model/settings.hpp"
#include "tangents/model_structure.hpp"

namespace mbproj {

template <int N> Pack norm_of_inverse(const Matrix<N, N, Pack>& A) {
    Pack found;
    for (int k = 0; k < pack_width; ++k) {
        Matrix<N, N> own;
        for (int i = 0; i < N * N; ++i) own[i] = A[i][k];
        found.set(k, norm_of_inverse(own));
    }
    return found;
}

// The numbers that follow from those of `each_number`, in which cases may differ, too.
template <class Model, class Visit> void each_derived_number(Model& model, Visit&& visit) {
    for (auto& body : model.bodies) visit_each(body.inverse_root, visit);
    for (auto* set : {&model.constraints, &model.coordinates})
        for (auto& attachment : set->attachments) visit(attachment.size);
    visit_each(model.row_scale, visit);
    visit(model.length);
    visit(model.rows.even);
}

// The decisions of the scalar kernel by a case's numbers: the order of elimination, and its hinges.
template <class D> std::vector<double> decisions_of(const Model<D>& model) {
    Structure found;
    const EliminationOrder<D> order(model, true);
    const auto add = [&found](const Hinge<D>& hinge) {
        found.add(hinge.child, hinge.parent, hinge.sign, hinge.p1, hinge.p2, hinge.coincident);
        found.add(hinge.translation_count, hinge.rotation_count);
        for (const int i : hinge.translations) found.add(i);
        for (const int i : hinge.rotations) found.add(i);
    };
    for (const Leaf<D>& leaf : order.leaves) found.add(leaf.joint), add(leaf.hinge);
    found.add_all(order.loop_bodies), found.add_all(order.loop_joints);
    for (const LoopHinge<D>& hinge : order.loop_hinges) found.add(hinge.joint(), hinge.child(), hinge.parent());
    found.add(model.rows.redundant);
    found.add_all(model.rows.left_out);
    for (const Coupling& coupling : model.couplings)
        found.add_all(coupling.coordinates), found.add_all(coupling.weights);
    return found.take();
}

// Whether packs compute such a model: bodies, joints and loops, motions, gears, states and forces without branches.
template <class D> bool fits_packs(const Model<D>& model) {
    const auto has_outline = [](const Instance<D>& p) {
        return p.on_line() || p.kind == Kind::rope || is_slip(p.kind) || p.kind == Kind::wheel_height ||
               p.kind == Kind::ellipsoid_height || p.curve >= 0;
    };
    std::vector<const PrimitiveSet<D>*> sets = {&model.constraints, &model.coordinates};
    if (model.loads) sets.push_back(&model.loads->coordinates);
    for (const auto* set : sets)
        if (std::any_of(set->instances.begin(), set->instances.end(), has_outline)) return false;
    for (const Body<D>& body : model.bodies)
        if (body.is_light) return false;
    return model.curves.empty() && model.flywheels.empty() && model.stiff.empty() && model.stops.bound.empty() &&
           model.bearings.empty() && model.actions.empty() && model.switches.empty() &&
           (model.rows.redundant == 0 || !model.rows.pivots.empty());
}

template <class D> class PackedModel final {
public:
    using P = With<D, Pack>;

    // Each lane begins as `first`, which fits.
    explicit PackedModel(const Model<D>& first)
        : model_(with<Pack>(first)), scale_(first.layout.scale.begin(), first.layout.scale.end()),
          structure_(structure_of(first)), decisions_(decisions_of(first)) {
        if (first.loads) model_.loads = loads_ = std::make_shared<Loads<P>>(with<Pack>(*first.loads));
    }

    const Model<P>& model() const { return model_; }
    // The scales of the absolute tolerance, of the numbers of y with error control.
    const std::vector<Pack>& scale() const { return scale_; }

    // Whether a lane can be this case.
    bool takes(const Model<D>& model) const {
        return fits_packs(model) && structure_of(model) == structure_ && decisions_of(model) == decisions_;
    }
    // Makes a lane this case from now on.
    void load(int lane, const Model<D>& from) {
        std::vector<double> numbers;
        const auto note = [&](double number) { numbers.push_back(number); };
        each_number(from, from.loads.get(), note);
        each_derived_number(from, note);
        std::size_t at = 0;
        const auto set = [&](auto& number) {
            if constexpr (std::is_same_v<decltype(number), Pack&>) number.set(lane, numbers[at]);
            ++at;
        };
        each_number(model_, loads_.get(), set);
        each_derived_number(model_, set);
        for (std::size_t i = 0; i < scale_.size(); ++i) scale_[i].set(lane, from.layout.scale[i]);
    }

private:
    Model<P> model_;
    std::shared_ptr<Loads<P>> loads_;  // the model's own
    std::vector<Pack> scale_;
    const std::vector<double> structure_, decisions_;
};

}  // namespace mbproj
