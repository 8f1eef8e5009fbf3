#include "contact/walls.hpp"

namespace mbproj {

int Walls::along(int stop) const {
    for (int k = 0; k < static_cast<int>(laws_.size()); ++k)
        if (is_along(stop, k)) return k;
    return -1;
}

bool Walls::has(const ContactState& state, int stop) const {
    return std::any_of(state.stuck.begin(), state.stuck.end(),
                       [&](const auto& each) { return is_along(stop, each.first); });
}

bool Walls::any(const ContactState& state, int friction, double side) const {
    return std::any_of(state.held.begin(), state.held.end(),
                       [&](int stop) { return is_along(stop, friction) && sides_[stop] == side; });
}

void Walls::remove(const ContactState& state, std::vector<ContactRow>& rows) const {
    const auto is_wall = [&](const ContactRow& row) { return has(state, row.coordinate); };
    rows.erase(std::remove_if(rows.begin(), rows.end(), is_wall), rows.end());
}

std::vector<std::vector<ContactRow>> Walls::take_from(std::vector<ContactRow>& rows) const {
    std::vector<std::vector<ContactRow>> found(laws_.size());
    std::vector<ContactRow> others;
    for (const ContactRow& row : rows) {
        const int k = along(row.coordinate);
        (k < 0 ? others : found[k]).push_back(row);
    }
    rows = std::move(others);
    return found;
}

void Walls::stick(const std::vector<ContactRow>& closed, ContactState& next) const {
    for (const ContactRow& row : closed) {
        const int k = along(row.coordinate);
        if (k < 0 || mbproj::has(next.sliding, k) || next.parts_of(row.coordinate)) continue;
        const auto is_own = [k](const auto& each) { return each.first == k; };
        for (Numbered* all : {&next.stuck, &next.bearing})
            all->erase(std::remove_if(all->begin(), all->end(), is_own), all->end());
        next.stuck.emplace_back(k, row.at);
    }
}

void Walls::share(const ContactState& state, const std::vector<double>& lambda, const std::vector<double>& fixed,
                  std::vector<double>& forces) const {
    for (const int stop : state.held)
        for (const auto& [k, at] : state.stuck) {
            if (!is_along(stop, k)) continue;
            double& force = forces[sides_.size() + k];
            const double load = laws_[k].bearing < 0 ? 1.0 : equations_.load(laws_[k].bearing, lambda.data());
            forces[stop] = push_of(sides_[stop] * force, fixed[static_cast<std::size_t>(k)] * load);
            force -= sides_[stop] * forces[stop];
        }
}

bool Walls::is_along(int stop, int friction) const {
    const auto& coordinates = model_.stops.joint_coordinate;
    return coordinates[stop] >= 0 && coordinates[stop] == coordinates[sides_.size() + friction];
}

}  // namespace mbproj
