// Decompositions of matrices.
#include "model/decompositions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "model/cholesky.hpp"

namespace mbproj {

namespace {

using DenseMatrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Index = Eigen::Index;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// 0 x = 0 has the solution 0.
double quotient(double a, double b) { return a == 0.0 ? 0.0 : a / b; }

// to += factor * from.
void add(double factor, const double* from, Index size, double* to) {
    for (Index i = 0; i < size; ++i) to[i] += factor * from[i];
}

double inner(const double* a, const double* b, Index size) {
    double sum = 0.0;
    for (Index i = 0; i < size; ++i) sum += a[i] * b[i];
    return sum;
}

// A square matrix, whose number (i, j) is at[i * row + j * column].
struct Square {
    const double* at;
    Index row, column, size;

    double operator()(Index i, Index j) const { return at[i * row + j * column]; }
    // x_i -= Σ (i, j) x_j over the columns from..end: the sum first, so that x is rounded once.
    void subtract(Index i, Index from, Index end, double* x) const {
        double sum = 0.0;
        for (Index j = from; j < end; ++j) sum += (*this)(i, j) * x[j];
        x[i] -= sum;
    }
};
constexpr Index panel = 8;  // columns that are solved before the other rows are changed

// x = L⁻¹ x, with ones on the diagonal of L.
void solve_lower(const Square& L, double* x) {
    for (Index from = 0, end; from < L.size; from = end) {
        end = std::min(from + panel, L.size);
        for (Index j = from; j < end; ++j)
            for (Index i = j + 1; i < end; ++i) x[i] -= L(i, j) * x[j];
        for (Index i = end; i < L.size; ++i) L.subtract(i, from, end, x);
    }
}
// x = U⁻¹ x.
void solve_upper(const Square& U, double* x) {
    for (Index end = U.size, from; end > 0; end = from) {
        from = std::max(end - panel, Index{0});
        for (Index j = end; j-- > from;) {
            x[j] = quotient(x[j], U(j, j));
            for (Index i = from; i < j; ++i) x[i] -= U(i, j) * x[j];
        }
        for (Index i = 0; i < from; ++i) U.subtract(i, from, end, x);
    }
}

// P A = L U with partial pivoting, by outer products (Golub & Van Loan, alg. 3.4.1).
class Lu final {
public:
    explicit Lu(const DenseMatrix& A) : LU_(A), pivots_(A.rows()) {
        const Index size = LU_.rows();
        for (Index k = 0; k < size; ++k) {
            Index pivot = k;
            for (Index i = k + 1; i < size; ++i)
                if (std::abs(LU_(i, k)) > std::abs(LU_(pivot, k))) pivot = i;
            pivots_[k] = pivot;
            if (LU_(pivot, k) == 0.0) continue;
            if (pivot != k)
                for (Index j = 0; j < size; ++j) std::swap(LU_(k, j), LU_(pivot, j));
            for (Index i = k + 1; i < size; ++i) LU_(i, k) /= LU_(k, k);
            const double* const multiples = &LU_(0, k);
            for (Index j = k + 1; j < size; ++j) add(-LU_(k, j), multiples + k + 1, size - k - 1, &LU_(0, j) + k + 1);
        }
    }

    // x = A⁻¹ x.
    void solve(double* x) const {
        for (Index k = 0; k < LU_.rows(); ++k) std::swap(x[k], x[pivots_[k]]);
        const Square both{LU_.data(), 1, LU_.rows(), LU_.rows()};
        solve_lower(both, x);
        solve_upper(both, x);
    }

private:
    DenseMatrix LU_;
    std::vector<Index> pivots_;
};

// The reflection 1 - τ v vᵀ that leaves of x only its first number.
struct Reflection {
    double tau, first;
};
// Turns x into v, whose first number is 1 (Golub & Van Loan, alg. 5.1.1, with the sign that cancels no digits).
Reflection reflection(double* x, Index size) {
    const double rest = inner(x + 1, x + 1, size - 1), first = x[0];
    x[0] = 1.0;
    if (rest <= std::numeric_limits<double>::min()) {
        std::fill(x + 1, x + size, 0.0);
        return {0.0, first};
    }
    const double length = std::sqrt(first * first + rest), now = first >= 0.0 ? -length : length;
    for (Index i = 1; i < size; ++i) x[i] /= first - now;
    return {(now - first) / now, now};
}

// Reflects the numbers first, rest[1], rest[2], ... by v.
void apply(double tau, const double* v, Index size, double& first, double* rest) {
    if (tau == 0.0) return;
    const double along = inner(v + 1, rest + 1, size - 1) + first;
    first -= tau * along;
    for (Index i = 1; i < size; ++i) rest[i] -= along * (tau * v[i]);
}

// The eigenvalues of a symmetric matrix, ascending, and their unit vectors.
template <int N> struct Principal {
    Column<N> values;
    Matrix<N, N> axes;
};

// A tridiagonal matrix with the diagonal d and e beside it, and the rotation that made it so.
template <int N> struct Tridiagonal {
    double d[N], e[N] = {};
    Matrix<N, N> axes = Matrix<N, N>::Identity();

    explicit Tridiagonal(const Matrix<N, N>& A) {
        for (int k = 0; k < N; ++k) d[k] = A(k, k);
        for (int k = 0; k + 1 < N; ++k) e[k] = A(k + 1, k);
        if constexpr (N == 3) {
            const double square = A(2, 0) * A(2, 0);
            if (square <= std::numeric_limits<double>::min()) return;
            // A reflection takes the first column's (e0, A20) to (its length, 0).
            const double length = std::sqrt(e[0] * e[0] + square), part = 1.0 / length;
            const double c = e[0] * part, s = A(2, 0) * part;
            const double change = 2.0 * c * e[1] + s * (d[2] - d[1]);
            d[1] += s * change, d[2] -= s * change;
            e[0] = length, e[1] -= c * change;
            axes << 1.0, 0.0, 0.0, 0.0, c, s, 0.0, s, -c;
        }
    }

    // A QR step with Wilkinson's shift on rows first to last (Golub & Van Loan, alg. 8.3.2).
    void step(int first, int last) {
        const double half = 0.5 * (d[last - 1] - d[last]), beside = e[last - 1];
        const double more = std::max(std::abs(half), std::abs(beside)),
                     less = std::min(std::abs(half), std::abs(beside));
        const double length = more * std::sqrt(1.0 + (less / more) * (less / more));
        const double shift =
            half == 0.0 ? std::abs(beside) : beside * beside / (half + (half > 0.0 ? length : -length));
        double x = d[first] - (d[last] - shift), z = e[first];
        for (int k = first; k < last && z != 0.0; ++k) {
            // The rotation that takes (x, z) to (r, 0).
            const bool steep = std::abs(x) <= std::abs(z);
            const double t = steep ? x / z : z / x, root = std::copysign(std::sqrt(1.0 + t * t), steep ? z : x);
            const double part = 1.0 / root, s = steep ? -part : -t * part, c = steep ? t * part : part;
            const double s_e = s * d[k] + c * e[k], s_d = s * e[k] + c * d[k + 1];
            d[k] = c * (c * d[k] - s * e[k]) - s * (c * e[k] - s * d[k + 1]);
            d[k + 1] = s * s_e + c * s_d;
            e[k] = c * s_e - s * s_d;
            if (k > first) e[k - 1] = c * e[k - 1] - s * z;
            x = e[k];
            if (k + 1 < last) z = -s * e[k + 1], e[k + 1] *= c;
            for (int i = 0; i < N; ++i) {
                const double before = axes(i, k);
                axes(i, k) = c * before - s * axes(i, k + 1);
                axes(i, k + 1) = s * before + c * axes(i, k + 1);
            }
        }
    }
};

// Golub & Van Loan, alg. 8.3.3. The matrix is scaled so that no square overflows.
template <int N> Principal<N> principal(Matrix<N, N> A) {
    constexpr int most_steps = 30 * N;  // two or three a value are usual
    const double largest = A.largest(), scale = N > 1 && largest > 0.0 ? largest : 1.0;
    Tridiagonal<N> T(Matrix<N, N>(A / scale));
    for (int step = 0, first = 0, last = N - 1; step < most_steps; ++step) {
        for (int k = first; k < last; ++k) {
            const double digits = T.e[k] / epsilon;
            if (digits * digits <= std::abs(T.d[k]) + std::abs(T.d[k + 1])) T.e[k] = 0.0;
        }
        while (last > 0 && T.e[last - 1] == 0.0) --last;
        if (last == 0) break;
        first = last - 1;
        while (first > 0 && T.e[first - 1] != 0.0) --first;
        T.step(first, last);
    }
    Principal<N> found;
    for (int k = 0; k < N; ++k) {
        double* const least = std::min_element(T.d + k, T.d + N);
        const int at = static_cast<int>(least - T.d);
        found.values[k] = scale * *least;
        found.axes.col(k) = T.axes.col(at);
        *least = T.d[k], T.axes.col(at) = T.axes.col(k);
    }
    return found;
}

}  // namespace

Vector solved(const DenseMatrix& A, const Vector& b) {
    Vector x = b;
    Lu(A).solve(x.data());
    return x;
}

DenseMatrix solved_columns(const DenseMatrix& A, const DenseMatrix& B) {
    DenseMatrix X = B;
    const Lu lu(A);
    for (Index c = 0; c < X.cols(); ++c) lu.solve(X.data() + c * X.rows());
    return X;
}

Vector least_squares(const DenseMatrix& A, const Vector& b) {
    PivotedQr qr;
    qr.factor(A);
    return qr.least_squares(b);
}

// Gaussian elimination with partial pivoting. Each row is kept from its first number that is not 0 to its last, so that the
// work follows the profile of the matrix. Rows wait at the column in which they begin.
int determinant_sign(int size, const std::vector<Entry>& entries) {
    struct Row {
        int first, end, next;  // its columns, and another row that begins in the same one
        std::size_t at;        // the place of its first number
    };
    std::vector<Row> rows(size, {size, 0, -1, 0});
    std::vector<int> waiting(size, -1), row_of(size);
    std::vector<double> numbers;
    for (const Entry& each : entries) {
        Row& row = rows[each.row];
        row.first = std::min(row.first, each.column), row.end = std::max(row.end, each.column + 1);
    }
    for (Row& row : rows) {
        if (row.first >= row.end) return 0;
        row.at = numbers.size();
        numbers.resize(row.at + row.end - row.first);
    }
    for (const Entry& each : entries) numbers[rows[each.row].at + each.column - rows[each.row].first] = each.value;
    const auto wait = [&](int r) {
        Row& row = rows[r];
        while (row.first < row.end && numbers[row.at] == 0.0) ++row.first, ++row.at;
        if (row.first == row.end) return false;
        row.next = waiting[row.first], waiting[row.first] = r;
        return true;
    };
    for (int r = 0; r < size; ++r)
        if (!wait(r)) return 0;
    const auto first = [&](int r) { return numbers[rows[r].at]; };
    int sign = 1;
    for (int column = 0; column < size; ++column) {
        int pivot = waiting[column];
        if (pivot < 0) return 0;
        for (int r = pivot; r >= 0; r = rows[r].next)
            if (std::abs(first(r)) > std::abs(first(pivot))) pivot = r;
        row_of[column] = pivot;
        if (first(pivot) < 0.0) sign = -sign;
        const Row& by = rows[pivot];
        for (int r = waiting[column], next; r >= 0; r = next) {
            Row& row = rows[r];
            next = row.next;
            if (r == pivot) continue;
            if (row.end < by.end) {  // it becomes longer, at another place
                const std::size_t before = std::exchange(row.at, numbers.size());
                numbers.resize(row.at + by.end - column);
                std::copy_n(&numbers[before], row.end - column, &numbers[row.at]);
                row.end = by.end;
            }
            add(-first(r) / first(pivot), &numbers[by.at], by.end - column, &numbers[row.at]);
            numbers[row.at] = 0.0;
            if (!wait(r)) return 0;
        }
    }
    // The sign of the order of the pivots: each exchange changes it.
    for (int k = 0; k < size; ++k)
        for (; row_of[k] != k; sign = -sign) std::swap(row_of[k], row_of[row_of[k]]);
    return sign;
}

void PivotedQr::factor(const DenseMatrix& Y) {
    rows_ = Y.rows(), columns_ = Y.cols(), size_ = std::min(rows_, columns_);
    R_.resize(rows_ * columns_), v_.resize(rows_ * size_), tau_.resize(size_), pivots_.resize(columns_);
    for (Index i = 0; i < rows_; ++i)
        for (Index j = 0; j < columns_; ++j) R(i, j) = Y(i, j);
    std::iota(pivots_.begin(), pivots_.end(), 0);
    const auto length_from = [this](Index row, Index column) {
        double sum = 0.0;
        for (Index i = row; i < rows_; ++i) sum += R(i, column) * R(i, column);
        return std::sqrt(sum);
    };
    // The lengths of the columns below row k, and what they were when they were last computed from their numbers.
    std::vector<double> length(columns_), computed, along(columns_);
    for (Index j = 0; j < columns_; ++j) length[j] = length_from(0, j);
    computed = length;
    for (Index k = 0; k < size_; ++k) {
        const Index pivot = std::max_element(length.begin() + k, length.end()) - length.begin();
        if (pivot != k) {
            for (Index i = 0; i < rows_; ++i) std::swap(R(i, k), R(i, pivot));
            std::swap(length[k], length[pivot]);
            std::swap(computed[k], computed[pivot]);
            std::swap(pivots_[k], pivots_[pivot]);
        }
        double* const v = &v_[k * rows_];
        for (Index i = k; i < rows_; ++i) v[i] = R(i, k);
        const Reflection found = reflection(v + k, rows_ - k);
        tau_[k] = found.tau, R(k, k) = found.first;
        if (found.tau != 0.0) {
            std::fill(along.begin() + k, along.end(), 0.0);
            for (Index i = k + 1; i < rows_; ++i) add(v[i], &R(i, k) + 1, columns_ - k - 1, &along[k] + 1);
            for (Index j = k + 1; j < columns_; ++j) {
                along[j] += R(k, j);
                R(k, j) -= found.tau * along[j];
            }
            for (Index i = k + 1; i < rows_; ++i) add(-found.tau * v[i], &along[k] + 1, columns_ - k - 1, &R(i, k) + 1);
        }
        for (Index j = k + 1; j < columns_; ++j) {
            if (length[j] == 0.0) continue;
            const double part = std::abs(R(k, j)) / length[j], rest = std::max((1.0 + part) * (1.0 - part), 0.0);
            const double since = length[j] / computed[j];
            // The difference has lost half of its digits (Drmač & Bujanović, LAPACK Working Note 176).
            if (rest * (since * since) <= std::sqrt(epsilon))
                length[j] = computed[j] = length_from(k + 1, j);
            else
                length[j] *= std::sqrt(rest);
        }
    }
}

Index PivotedQr::rank() const {
    double most = 0.0;
    for (Index k = 0; k < size_; ++k) most = std::max(most, std::abs(R(k, k)));
    Index found = 0;
    while (found < size_ && std::abs(R(found, found)) > epsilon * static_cast<double>(size_) * most) ++found;
    return found;
}

void PivotedQr::reflect(Index k, Vector& x) const { apply(tau_[k], &v_[k * rows_ + k], rows_ - k, x[k], &x[k]); }

// R = (T 0) Z of the independent rows (Golub & Van Loan, sect. 5.4): reflections from the right.
Vector PivotedQr::least_squares(Vector b) const {
    const Index rank = this->rank(), beyond = columns_ - rank;
    for (Index k = 0; k < rank; ++k) reflect(k, b);
    std::vector<double> T(R_.begin(), R_.begin() + rank * columns_), z(rank * (beyond + 1)), tau(rank);
    const auto t = [&](Index row) { return T.data() + row * columns_; };
    for (Index k = rank; beyond > 0 && k-- > 0;) {
        double* const own = &z[k * (beyond + 1)];
        own[0] = t(k)[k];
        std::copy(t(k) + rank, t(k) + columns_, own + 1);
        const Reflection found = reflection(own, beyond + 1);
        tau[k] = found.tau, t(k)[k] = found.first;
        for (Index i = 0; i < k; ++i) {
            const double part = found.tau * (inner(t(i) + rank, own + 1, beyond) + t(i)[k]);
            t(i)[k] -= part;
            add(-part, own + 1, beyond, t(i) + rank);
        }
    }
    Vector y = Vector::Zero(columns_), x(columns_);
    std::copy_n(b.data(), rank, y.data());
    solve_upper({T.data(), columns_, 1, rank}, y.data());
    for (Index k = 0; k < rank; ++k)
        if (beyond > 0) apply(tau[k], &z[k * (beyond + 1)], beyond + 1, y[k], y.data() + rank - 1);
    for (Index k = 0; k < columns_; ++k) x[pivots_[k]] = y[k];
    return x;
}

void PivotedQr::solve(Vector& w, const Vector& c, Vector& lambda) const {
    for (Index k = 0; k < columns_; ++k) reflect(k, w);
    std::vector<double> wanted(columns_), along(columns_, 0.0);
    for (Index j = 0; j < columns_; ++j) {
        for (Index i = j; j % panel == 0 && i < std::min(j + panel, columns_); ++i)
            wanted[i] = c[pivots_[i]] - std::exchange(along[i], 0.0);
        wanted[j] = quotient(wanted[j] - along[j], R(j, j));
        for (Index i = j + 1; i < columns_; ++i) along[i] += R(j, i) * wanted[j];
    }
    for (Index k = 0; k < columns_; ++k) along[k] = w[k] - wanted[k];
    solve_upper({R_.data(), columns_, 1, columns_}, along.data());
    lambda.resize(columns_);
    for (Index k = 0; k < columns_; ++k) lambda[pivots_[k]] = along[k];
    std::copy(wanted.begin(), wanted.end(), w.data());
    for (Index k = columns_; k-- > 0;) reflect(k, w);
}

template <int N> EigenvalueRange eigenvalue_range(const Matrix<N, N>& A) {
    const Principal<N> found = principal<N>(A);
    return {found.values[0], found.values[N - 1]};
}

template <int N> Matrix<N, N> root(const Matrix<N, N>& A) {
    const Principal<N> found = principal<N>(A);
    Matrix<N, N> R;
    for (int k = 0; k < N; ++k) R.row(k) = std::sqrt(std::max(found.values[k], 0.0)) * found.axes.col(k).transpose();
    return R;
}

template <int N> Matrix<N, N> inverse_root(const Matrix<N, N>& A) {
    Cholesky<N> cholesky;
    cholesky.factor(A);
    Matrix<N, N> found = Matrix<N, N>::Identity();
    for (int c = 0; c < N; ++c) {
        Column<N> x = found.col(c);
        cholesky.forward(x);
        found.col(c) = x;
    }
    return found;
}

template <int N> double norm_of_inverse(const Matrix<N, N>& A) {
    double sum = 0.0;
    for (const double value : principal<N>(A).values) sum += 1.0 / (value * value);
    return std::sqrt(sum);
}

template EigenvalueRange eigenvalue_range(const Matrix<1, 1>&);
template EigenvalueRange eigenvalue_range(const Matrix<3, 3>&);
template Matrix<1, 1> inverse_root(const Matrix<1, 1>&);
template Matrix<3, 3> inverse_root(const Matrix<3, 3>&);
template double norm_of_inverse(const Matrix<1, 1>&);
template double norm_of_inverse(const Matrix<3, 3>&);
template Matrix<1, 1> root(const Matrix<1, 1>&);
template Matrix<2, 2> root(const Matrix<2, 2>&);
template Matrix<3, 3> root(const Matrix<3, 3>&);

}  // namespace mbproj
