// RATTLE on rigid bodies with joints: Hairer, Lubich & Wanner, Geometric Numerical Integration (2006), VII.1.4; a body is
// its place and its rotation matrix, whose mass matrix is constant (VII.5).
#include <algorithm>
#include <cmath>
#include <vector>

namespace {

// A scalar row of two bodies, each by 12 numbers: r, then the columns of A. `kind` 0: part `axis` of r + A s of both agrees; 1:
// (A u)·(A v) is as at the start; 2: (A u)·(r + A t - r - A s) is; 3: columns `axis` and `other` of one body are orthonormal.
struct Row {
    int kind, first, second, axis, other;
    double u[3], v[3];
    double start;
};

class Rattle {
public:
    Rattle(int bodies, const double *masses, const double *pull, int rows, const Row *given)
        : n_(12 * bodies), w_(masses, masses + n_), pull_(pull, pull + n_), rows_(given, given + rows), G_(rows * 24),
          S_(rows * rows), x_(rows) {}

    // `angle` is that by which a body's numbers `turned` have gone round, as x and y of a plane.
    void run(double h, long steps, double *q, double *v, double *angle, const int *turned) {
        const int body = turned[0], one = turned[1], other = turned[2];
        for (Row &row : rows_)
            if (row.kind == 1 || row.kind == 2) row.start = 0, row.start = value(row, q);
        factor(q);
        std::vector<double> G(G_), reached(n_);
        for (long step = 0; step < steps; ++step) {
            for (int i = 0; i < n_; ++i) v[i] += h / 2 * pull_[i] / w_[i], reached[i] = q[i] + h * v[i];
            double last = 1e300;
            for (int round = 0; round < 50; ++round) {
                double open = 0;
                for (std::size_t r = 0; r < rows_.size(); ++r)
                    x_[r] = value(rows_[r], reached.data()), open = std::max(open, std::abs(x_[r]));
                if (open < 1e-15 || (round > 3 && open >= last)) break;
                last = open;
                solve();
                spread([&](int i, double part) { reached[i] -= part / w_[i], v[i] -= part / (w_[i] * h); });
            }
            const double before = std::atan2(q[12 * body + other], q[12 * body + one]);
            std::copy_n(reached.data(), n_, q);
            *angle += std::remainder(std::atan2(q[12 * body + other], q[12 * body + one]) - before, 2 * std::acos(-1.0));
            factor(q);
            for (int i = 0; i < n_; ++i) v[i] += h / 2 * pull_[i] / w_[i];
            for (std::size_t r = 0; r < rows_.size(); ++r) {
                x_[r] = 0;
                each(r, [&](int i, double part) { x_[r] += part * v[i]; });
            }
            solve();
            spread([&](int i, double part) { v[i] -= part / w_[i]; });
        }
    }

private:
    static void place(const double *q, const double *s, double *p) {
        for (int k = 0; k < 3; ++k) p[k] = q[k] + turned(q, s, k);
    }
    static double turned(const double *q, const double *s, int k) { return q[3 + k] * s[0] + q[6 + k] * s[1] + q[9 + k] * s[2]; }

    double value(const Row &row, const double *q, double *left = nullptr, double *right = nullptr) const {
        const double *a = q + 12 * row.first, *b = q + 12 * row.second;
        double sum = 0;
        if (left) std::fill_n(left, 12, 0.0), std::fill_n(right, 12, 0.0);
        if (row.kind == 0) {
            const int k = row.axis;
            if (left) {
                left[k] = 1, right[k] = -1;
                for (int c = 0; c < 3; ++c) left[3 + 3 * c + k] = row.u[c], right[3 + 3 * c + k] = -row.v[c];
            }
            return a[k] + turned(a, row.u, k) - b[k] - turned(b, row.v, k);
        }
        for (int k = 0; k < 3; ++k) {
            if (row.kind == 3) {
                const double *one = a + 3 + 3 * row.axis, *two = a + 3 + 3 * row.other;
                sum += one[k] * two[k];
                if (left) left[3 + 3 * row.axis + k] += two[k], left[3 + 3 * row.other + k] += one[k];
                continue;
            }
            const double e = turned(a, row.u, k);
            const double far = row.kind == 1 ? turned(b, row.v, k) : b[k] + turned(b, row.v, k) - a[k];
            sum += e * far;
            if (!left) continue;
            for (int c = 0; c < 3; ++c) left[3 + 3 * c + k] = row.u[c] * far, right[3 + 3 * c + k] = e * row.v[c];
            if (row.kind == 2) left[k] = -e, right[k] = e;
        }
        return row.kind == 3 ? sum - (row.axis == row.other) : sum - row.start;
    }
    template <class Visit> void each(std::size_t r, const Visit &visit) const {
        for (int k = 0; k < 12; ++k) {
            visit(12 * rows_[r].first + k, G_[24 * r + k]);
            if (rows_[r].kind != 3) visit(12 * rows_[r].second + k, G_[24 * r + 12 + k]);
        }
    }
    template <class Visit> void spread(const Visit &visit) const {
        for (std::size_t r = 0; r < rows_.size(); ++r) each(r, [&](int i, double part) { visit(i, part * x_[r]); });
    }
    // S = G W⁻¹ Gᵀ = L Lᵀ
    void factor(const double *q) {
        const int m = static_cast<int>(rows_.size());
        std::vector<double> full(n_);
        for (int r = 0; r < m; ++r) value(rows_[r], q, &G_[24 * r], &G_[24 * r + 12]);
        for (int r = 0; r < m; ++r) {
            std::fill(full.begin(), full.end(), 0.0);
            each(r, [&](int i, double part) { full[i] += part / w_[i]; });
            for (int k = r; k < m; ++k) {
                double sum = 0;
                each(k, [&](int i, double part) { sum += part * full[i]; });
                S_[k * m + r] = sum;
            }
        }
        for (int i = 0; i < m; ++i)
            for (int j = 0; j <= i; ++j) {
                double sum = S_[i * m + j];
                for (int k = 0; k < j; ++k) sum -= S_[i * m + k] * S_[j * m + k];
                S_[i * m + j] = i == j ? std::sqrt(sum) : sum / S_[j * m + j];
            }
    }
    void solve() {
        const int m = static_cast<int>(rows_.size());
        for (int i = 0; i < m; ++i) {
            for (int k = 0; k < i; ++k) x_[i] -= S_[i * m + k] * x_[k];
            x_[i] /= S_[i * m + i];
        }
        for (int i = m - 1; i >= 0; --i) {
            for (int k = i + 1; k < m; ++k) x_[i] -= S_[k * m + i] * x_[k];
            x_[i] /= S_[i * m + i];
        }
    }

    int n_;
    std::vector<double> w_, pull_;
    std::vector<Row> rows_;
    std::vector<double> G_, S_, x_;
};

}  // namespace

extern "C" {

void rattle(int bodies, const double *masses, const double *pull, int rows, const void *given, double h, long steps, double *q,
            double *v, double *angle, const int *turned) {
    Rattle(bodies, masses, pull, rows, static_cast<const Row *>(given)).run(h, steps, q, v, angle, turned);
}
}
