#include "validate/hunt/local_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace backbend::validate {
namespace {

using Index = std::size_t;

/// 1, x, y, z, xx, xy, ...: of an offset in units of the neighbourhood's radius.
void terms_of(std::span<const double> offset, std::vector<double>& terms) {
  terms.assign(1, 1.0);
  for (const double x : offset) terms.push_back(x);
  for (Index i = 0; i < offset.size(); ++i)
    for (Index j = i; j < offset.size(); ++j) terms.push_back(offset[i] * offset[j]);
}

/// Solves A x = b for a symmetric positive definite A, row by row; A is destroyed. False where it
/// is not.
bool solve_cholesky(std::vector<double>& a, std::vector<double>& b) {
  const Index n = b.size();
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j <= i; ++j) {
      double sum = a[i * n + j];
      for (Index k = 0; k < j; ++k) sum -= a[i * n + k] * a[j * n + k];
      if (i == j) {
        if (!(sum > 0.0)) return false;
        a[i * n + i] = std::sqrt(sum);
      } else {
        a[i * n + j] = sum / a[j * n + j];
      }
    }
  }
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < i; ++k) b[i] -= a[i * n + k] * b[k];
    b[i] /= a[i * n + i];
  }
  for (Index i = n; i-- > 0;) {
    for (Index k = i + 1; k < n; ++k) b[i] -= a[k * n + i] * b[k];
    b[i] /= a[i * n + i];
  }
  return true;
}

}  // namespace

LocalModel::LocalModel(Index axes, std::vector<double> points)
    : axes_(axes), points_(std::move(points)) {}

std::vector<Index> LocalModel::nearest(std::span<const double> point, Index wanted,
                                       std::ptrdiff_t without) const {
  std::vector<std::pair<double, Index>> far;
  far.reserve(count());
  for (Index i = 0; i < count(); ++i) {
    if (static_cast<std::ptrdiff_t>(i) == without) continue;
    double square = 0.0;
    for (Index a = 0; a < axes_; ++a) {
      const double d = points_[i * axes_ + a] - point[a];
      square += d * d;
    }
    far.emplace_back(square, i);
  }
  wanted = std::min(wanted, far.size());
  std::partial_sort(far.begin(), far.begin() + static_cast<std::ptrdiff_t>(wanted), far.end());
  std::vector<Index> out(wanted);
  for (Index i = 0; i < wanted; ++i) out[i] = far[i].second;
  return out;
}

LocalModel::Estimate LocalModel::at(std::span<const double> point, std::ptrdiff_t without) const {
  const Index terms = 1 + axes_ + axes_ * (axes_ + 1) / 2;
  // Twice as many points as terms: fewer follow every error, more reach too far.
  const std::vector<Index> known = nearest(point, 2 * terms + 4, without);
  if (known.size() < terms + 2) return {};
  std::vector<double> offset(axes_), row;
  const auto offset_of = [&](Index i) {
    for (Index a = 0; a < axes_; ++a) offset[a] = points_[i * axes_ + a] - point[a];
    return std::sqrt(std::inner_product(offset.begin(), offset.end(), offset.begin(), 0.0));
  };
  const double radius = std::max(offset_of(known.back()), 1e-12);
  std::vector<double> a(terms * terms, 0.0), b(terms, 0.0), rows, weights;
  for (const Index i : known) {
    const double far = offset_of(i) / radius;
    for (double& d : offset) d /= radius;
    terms_of(offset, row);
    const double weight = 1.0 / (0.1 + far * far);
    for (Index r = 0; r < terms; ++r)
      for (Index c = 0; c <= r; ++c) a[r * terms + c] += weight * row[r] * row[c];
    rows.insert(rows.end(), row.begin(), row.end());
    weights.push_back(weight);
  }
  for (Index r = 0; r < terms; ++r) {
    a[r * terms + r] *= 1.0 + 1e-9;  // points in a plane leave a direction open
    a[r * terms + r] += 1e-9;
    for (Index c = 0; c < r; ++c) a[c * terms + r] = a[r * terms + c];
  }
  // The value at the point itself is the first coefficient.
  b[0] = 1.0;
  if (!solve_cholesky(a, b)) return {};
  Estimate out;
  double squares = 0.0;
  for (Index n = 0; n < known.size(); ++n) {
    const double share =
        weights[n] * std::inner_product(b.begin(), b.end(),
                                        rows.begin() + static_cast<std::ptrdiff_t>(n * terms), 0.0);
    out.weight.emplace_back(known[n], share);
    squares += share * share;
  }
  out.spread = std::sqrt(1.0 + squares);
  return out;
}

}  // namespace backbend::validate
