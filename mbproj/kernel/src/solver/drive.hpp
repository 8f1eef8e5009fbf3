// The values, rates and accelerations that motions prescribe at a time; and the work of motions and forces.
#pragma once

#include "kinematics/loads.hpp"
#include "model/model.hpp"
#include "model/settings.hpp"

namespace mbproj {

template <class D> class Drive final {
public:
    explicit Drive(const Model<D>& model) : model_(model), found_(model.driven.size()) {}

    std::size_t size() const { return found_.size(); }
    bool empty() const { return found_.empty(); }
    const Series<Scalar<D>>& operator[](std::size_t k) const { return found_[k]; }
    // The coordinate's value that motion k prescribes.
    Scalar<D> prescribed(std::size_t k) const { return model_.driven[k].start + found_[k].x; }

    bool is_at_rest() const {
        return std::all_of(found_.begin(), found_.end(), [](const Series<Scalar<D>>& each) { return each.d == 0.0; });
    }

    // Subtracts the prescribed values from the driven rows of C.
    void close(Scalar<D>* C) const {
        for (std::size_t k = 0; k < found_.size(); ++k) {
            const DrivenRow<D>& driven = model_.driven[k];
            const Scalar<D> wanted = prescribed(k);
            C[driven.row] =
                driven.is_angle ? nearest(C[driven.row] - remainder(wanted, 2.0 * M_PI)) : C[driven.row] - wanted;
        }
    }

    // The power of the motions, with these multipliers.
    Scalar<D> power(const Scalar<D>* lambda) const {
        Scalar<D> sum = 0.0;
        for (std::size_t k = 0; k < found_.size(); ++k) sum -= lambda[model_.driven[k].row] * found_[k].d;
        return sum;
    }

    // Evaluates the motions at t. Accelerations may jump: they are evaluated inside the window. Values and rates are
    // continuous: they are those at t, so that joints close to round-off. False where one is not finite.
    bool set(double t, const TimeWindow& window) {
        bool finite = true;
        for (std::size_t k = 0; k < found_.size(); ++k) {
            found_[k] = at(k, t);
            const double seen = window.clamped(t);
            if (seen != t) found_[k].dd = at(k, seen).dd;
            finite = finite && found_[k].finite();
        }
        return finite;
    }

private:
    Series<Scalar<D>> at(std::size_t k, const Scalar<D>& t) const {
        const Series<Scalar<D>> time[3] = {{t, 1.0, 0.0}, {}, {}};
        return model_.programs.run(model_.driven[k].program, time);
    }

    const Model<D>& model_;
    std::vector<Series<Scalar<D>>> found_;
};

// The rates of the quadratures in a slope: the power supplied, the dissipated power, and the losses integrated apart.
template <class D> void set_work(const Block& work, const Applied<D>& applied, const Drive<D>& drive,
                                 const Scalar<D>* lambda, Scalar<D>* slope) {
    if (!work.size) return;
    slope[work.first] = applied.power + drive.power(lambda);
    slope[work.first + 1] = applied.dissipation;
    std::copy(applied.lost.begin(), applied.lost.end(), slope + work.first + 2);
}

}  // namespace mbproj
