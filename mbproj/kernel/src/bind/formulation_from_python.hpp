// A formulation in Python, as mbproj.motion.formulations.full_in_loop has it, for the time loop. The loop runs without the
// interpreter's lock and without small numbers: both are as usual while Python answers. What it throws stops the run, and is
// thrown when the loop has come back.
#pragma once

#include <exception>

#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bind/from_numpy.hpp"
#include "step/flush_to_zero.hpp"
#include "step/run.hpp"

namespace mbproj {

class [[gnu::visibility("hidden")]] FormulationFromPython final : public Formulation {
public:
    FormulationFromPython(const Equations& equations, nb::object own)
        : equations_(equations), model_(equations.mechanism()), own_(std::move(own)) {}
    ~FormulationFromPython() override {
        const nb::gil_scoped_acquire locked;
        own_.reset();
    }

    bool accelerate(const AskedState& at, const std::vector<double>& forces, bool watched, double* slope,
                    double* lambda) override {
        return ask([&] {
            const nb::object found =
                own_.attr("accelerate")(asked(at), array_of(std::vector<double>(forces), forces.size()), watched);
            if (found.is_none()) return false;
            const auto [a, multipliers] = nb::cast<std::pair<Numbers2, Numbers1>>(found);
            const auto bodies = static_cast<std::size_t>(model_.size());
            const auto rows = static_cast<std::size_t>(model_.row_count());
            const auto [freedoms, pose, state] = model_.sizes();
            if (a.shape(0) != bodies || a.shape(1) != static_cast<std::size_t>(freedoms) ||
                multipliers.shape(0) != rows)
                refuse("accelerations", "have a wrong shape");
            for (std::size_t b = 0; b < bodies; ++b)
                std::copy_n(a.data() + freedoms * b, freedoms, slope + state * b + pose);
            std::copy_n(multipliers.data(), rows, lambda);
            return true;
        });
    }
    Projected project(long step, const AskedState& at, double* y) override {
        Projected done;
        done.regular = ask([&] {
            const nb::object found = own_.attr("project")(step, asked(at));
            if (found.is_none()) return false;
            const auto [bodies, counts] = nb::cast<std::pair<Numbers1, std::vector<int>>>(found);
            if (bodies.shape(0) != static_cast<std::size_t>(model_.layout.bodies.size) || counts.size() != 6)
                refuse("a projection", "has a wrong shape");
            std::copy_n(bodies.data(), bodies.shape(0), y);
            done.projections = counts[0], done.position_passes = counts[1], done.velocity_passes = counts[2];
            done.failures = counts[3], done.fallbacks = counts[4], done.near_singular = counts[5] != 0;
            return true;
        });
        return done;
    }

    void begin_step() override { call("begin_step"); }
    void enter_end() override { call("enter_end"); }
    void arrive(const double* y) override {
        ask([&] { return own_.attr("arrive")(state(y)), true; });
    }
    void take_back() override { call("take_back"); }

    std::vector<double> save() override {
        std::vector<double> found;
        ask([&] { return found = nb::cast<std::vector<double>>(own_.attr("save")()), true; });
        return found;
    }
    bool resume(const std::vector<double>& saved) override {
        return ask([&] { return nb::cast<bool>(own_.attr("resume")(saved)); });
    }
    void rethrow() override {
        if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
    }

private:
    template <class Ask> bool ask(const Ask& question) {
        if (thrown_) return false;
        const nb::gil_scoped_acquire locked;
        const KeepDenormals kept;
        try {
            return question();
        } catch (...) {
            thrown_ = std::current_exception();
            return false;
        }
    }
    void call(const char* what) {
        ask([&] { return own_.attr(what)(), true; });
    }
    nb::object state(const double* y) const {
        const int size = model_.layout.size();
        return array_of(std::vector<double>(y, y + size), size);
    }
    // (t, y, first and last time seen, branches or None, rows of contacts as coordinates and values).
    nb::object asked(const AskedState& at) const {
        nb::object branches = nb::none();
        if (const std::size_t count = equations_.programs().op.size(); at.branches)
            branches = array_of(std::vector<double>(at.branches, at.branches + count), count);
        std::vector<std::pair<int, double>> rows;
        for (const ContactRow& row : at.rows) rows.emplace_back(row.coordinate, row.at);
        return nb::make_tuple(at.t, state(at.y), at.window.first, at.window.last, branches, rows);
    }

    const Equations& equations_;
    const Mechanism& model_;
    nb::object own_;
    std::exception_ptr thrown_;
};

}  // namespace mbproj
