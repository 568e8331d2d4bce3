/// Multiple constraints at a time (MCAAT): the same filter as SCAAT, fed with N measurements in one update.
///
/// SCAAT's rival (002 sections 3.7 and E.3.1): measurements are collected until there are N, stacked, and taken as one of the
/// time of the newest: the simultaneity assumption. With N = 1 it is SCAAT. Sources are calibrated as there; the
/// stacked system is
///   S = H P H^T + blockdiag(H_b (P_b + residual) H_b^T + R),  K = P H^T S^-1,  P <- P - K S K^T,
/// and each source is corrected by its own rows. A source that is in a window twice is corrected once.
/// `Sources` is a DeviceTable, or anything with its `for_sighting` and `store`.
/// Nothing here allocates. Bad input: a measurement that the state cannot give is left out of the window's update, and
/// McaatStatus tells when nothing could be updated.
#pragma once

#include <Eigen/Cholesky>

#include <holdfast/tracking/advance.hpp>
#include <holdfast/tracking/device_estimate.hpp>
#include <holdfast/tracking/measurement.hpp>
#include <holdfast/tracking/observation_window.hpp>

namespace holdfast {

enum class McaatStatus {
  collecting,      ///< the window is not full yet
  updated,         ///< there is a new estimate
  time_backwards,  ///< older than the last estimate: ignored
  nothing_seen,    ///< the state could give none of the window's measurements
  not_positive     ///< the innovation's covariance has no inverse: nothing changed but the time
};

template <int Order, Measurement M, int Capacity = 16>
class McaatFilter {
 public:
  static_assert(M::sensor_size == 0, "sensors are not calibrated here");

  McaatFilter(const TargetState<Order>& start, const ProcessModel<Order>& model, const WindowShape& shape)
      : window_(shape), state_(start), model_(model) {}

  template <typename Sources>
  [[nodiscard]] McaatStatus add(HostTime t, const M& measurement, int source, Sources& sources) {
    if (t < state_.t) return McaatStatus::time_backwards;
    if (!window_.add({measurement, source})) return McaatStatus::collecting;
    advance(state_, model_, t);
    return update(sources);
  }

  [[nodiscard]] const TargetState<Order>& state() const { return state_; }

 private:
  static constexpr int m = M::size;
  static constexpr int b = M::source_size;
  static constexpr int n = 6 * Order;
  static constexpr int rows_at_most = Capacity * m;
  using Stacked = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::DontAlign, rows_at_most, rows_at_most>;
  using StackedColumns = Eigen::Matrix<double, n, Eigen::Dynamic, Eigen::DontAlign, n, rows_at_most>;
  using StackedH = Eigen::Matrix<double, Eigen::Dynamic, M::state_size, Eigen::DontAlign, rows_at_most, M::state_size>;
  using StackedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::DontAlign, rows_at_most, 1>;

  struct Observation {
    M measurement;
    int source = 0;
  };
  struct SourceInWindow {
    int index = 0;
    DeviceEstimate<b> estimate;
    MatrixOf<double, b, m> C;  // covariance of its error with its measurement
  };

  template <typename Sources>
  [[nodiscard]] McaatStatus update(Sources& sources) {
    const int most = static_cast<int>(window_.observations().size());
    StackedH H(most * m, M::state_size);
    StackedVector residual(most * m);
    Stacked S = Stacked::Zero(most * m, most * m);
    std::array<SourceInWindow, Capacity> used;
    int count = 0;
    for (const Observation& observation : window_.observations()) {
      SourceInWindow& source = used[static_cast<std::size_t>(count)];
      source.index = observation.source;
      source.estimate = sources.for_sighting(observation.source);
      Linearization<M> linear;
      if (!observation.measurement.linearize(state_, source.estimate.x, {}, linear)) continue;
      if (!linear.residual.allFinite()) continue;
      source.C.noalias() = source.estimate.P * linear.H_source.transpose();
      H.template middleRows<m>(count * m) = linear.H;
      residual.template segment<m>(count * m) = linear.residual;
      S.template block<m, m>(count * m, count * m) =
          linear.R + linear.H_source * source.C +
          linear.H_source * source.estimate.residual_variance.asDiagonal() * linear.H_source.transpose();
      ++count;
    }
    if (count == 0) return McaatStatus::nothing_seen;
    const int rows = count * m;
    const StackedColumns C = state_.P.template leftCols<M::state_size>() * H.topRows(rows).transpose();
    Stacked S_used = S.topLeftCorner(rows, rows);
    S_used.noalias() += H.topRows(rows) * C.template topRows<M::state_size>();
    const Eigen::LLT<Stacked> cholesky(S_used);
    if (cholesky.info() != Eigen::Success) return McaatStatus::not_positive;
    const Stacked S_inverse = cholesky.solve(Stacked::Identity(rows, rows));
    const StackedVector weighted = S_inverse * residual.head(rows);

    const StackedColumns K = C * S_inverse;
    state_.P.noalias() -= K * C.transpose();
    state_.P = (0.5 * (state_.P + state_.P.transpose())).eval();
    state_.add(typename TargetState<Order>::Error(C * weighted));
    for (int i = 0; i < count; ++i) {
      SourceInWindow& source = used[static_cast<std::size_t>(i)];
      if (source.estimate.locked) continue;
      source.estimate.x.noalias() += source.C * weighted.template segment<m>(i * m);
      source.estimate.P.noalias() -= source.C * S_inverse.template block<m, m>(i * m, i * m) * source.C.transpose();
      sources.store(source.index, source.estimate);
    }
    return McaatStatus::updated;
  }

  ObservationWindow<Observation, Capacity> window_;
  TargetState<Order> state_;
  ProcessModel<Order> model_;
};

}  // namespace holdfast
