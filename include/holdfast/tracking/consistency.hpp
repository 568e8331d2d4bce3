/// Is a filter as sure as it may be? Normalised squared errors, and the bounds that their mean should keep (Bar-Shalom, Li
/// and Kirubarajan, Estimation with Applications to Tracking and Navigation, 5.4).
///
///   NEES   d^T P^-1 d        of the error d against the truth: simulations only
///   NIS    y^T S^-1 y        of the innovation (Innovation::nis): in the field too
/// If all is as modelled each is chi-square with as many degrees of freedom as numbers. The mean of N independent ones then
/// lies between the 2.5 % and 97.5 % quantiles of chi-square with N times as many degrees, divided by N. A mean above says
/// too sure, below too shy. Innovations of one run are independent; errors of one run are not: take NEES from
/// independent runs at one time.
/// Bad input: NEES is nothing when P has no positive inverse; values that are not finite are not taken.
#pragma once

#include <cmath>
#include <optional>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/cholesky.hpp>
#include <holdfast/tracking/chi_square.hpp>
#include <holdfast/tracking/target_state.hpp>

namespace holdfast {

/// d^T P^-1 d.
template <int Size>
[[nodiscard]] std::optional<double> normalised_square(const VectorOf<double, Size>& d,
                                                      const MatrixOf<double, Size>& P) {
  MatrixOf<double, Size> L;
  if (!cholesky<Size>(P, L)) return std::nullopt;
  const double square = squared_distance<Size>(L, d);
  if (!std::isfinite(square)) return std::nullopt;
  return square;
}

/// NEES of the whole error state: 6 Order degrees of freedom.
template <int Order>
[[nodiscard]] std::optional<double> nees(const TargetState<Order>& estimate, const TargetState<Order>& truth) {
  return normalised_square<6 * Order>(estimate.error_of(truth), estimate.P);
}

/// NEES of the pose alone: 6 degrees of freedom.
template <int Order>
[[nodiscard]] std::optional<double> pose_nees(const TargetState<Order>& estimate, const TargetState<Order>& truth) {
  return normalised_square<6>(Vector6(estimate.error_of(truth).template head<6>()),
                              Matrix6(estimate.P.template topLeftCorner<6, 6>()));
}

/// Mean of NEES or NIS values against its bounds.
class ConsistencyMean {
 public:
  explicit ConsistencyMean(int degrees_of_freedom) : degrees_(degrees_of_freedom) {
    HOLDFAST_ASSERT(degrees_of_freedom > 0, "a squared error has at least one degree of freedom");
  }

  void add(std::optional<double> square) {
    if (!square || !std::isfinite(*square)) return;
    sum_ += *square;
    ++count_;
  }

  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] double expected() const { return degrees_; }
  [[nodiscard]] double mean() const { return count_ > 0 ? sum_ / count_ : std::nan(""); }

  struct Bounds {
    double low, high;
    [[nodiscard]] bool contains(double mean) const { return low <= mean && mean <= high; }
  };

  /// Where the mean lies with this probability if the values are independent. Precondition: count() > 0.
  [[nodiscard]] Bounds bounds(double probability = 0.95) const {
    HOLDFAST_ASSERT(count_ > 0, "bounds of no values");
    const double tail = 0.5 * (1.0 - probability);
    const int degrees = degrees_ * count_;
    return {chi_square_quantile(tail, degrees) / count_, chi_square_quantile(1.0 - tail, degrees) / count_};
  }

  [[nodiscard]] bool consistent(double probability = 0.95) const {
    return count_ > 0 && bounds(probability).contains(mean());
  }

 private:
  int degrees_;
  int count_ = 0;
  double sum_ = 0.0;
};

}  // namespace holdfast
