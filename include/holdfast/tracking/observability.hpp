/// Can these measurements determine the state at all? The condition of 002 eq. 5.3 over a window (section 5.1.3).
///
///   M = sum over i of A_i^T H_i^T R_i^-1 H_i A_i,   A_i carries an error of now back to measurement i's time
/// is what the window's measurements say about the error of now (target_state.hpp), were there no process noise: the
/// smallest eigenvalue must be above zero (eq. 5.3's beta_1) and the largest bounded (beta_2). A single sighting never
/// determines a pose; a window must.
/// Scale: eigenvalues of M compare metres with radians and with m/s. Here dp is in m and dphi in rad, of like effect 1 m away;
/// a velocity counts by what it moves within the window's time T: dv = s / T, da = 2 s / T^2. So eigenvalues are 1/m^2, and
/// directions have comparable numbers. What is below `rank_tolerance` times the largest eigenvalue is not observable.
/// Only what 5.3 names counts: sources and sensors are taken to be known.
/// Not for the hot path. Bad input: a measurement without positive R, or back in time, is refused: `add` says false.
#pragma once

#include <array>
#include <cstdio>
#include <limits>
#include <string>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <holdfast/geometry/cholesky.hpp>
#include <holdfast/tracking/advance.hpp>
#include <holdfast/tracking/measurement.hpp>

namespace holdfast {

template <int Order>
struct Observability {
  static constexpr int size = 6 * Order;
  static constexpr double rank_tolerance = 1e-10;

  int measurements = 0;
  int rank = 0;                              ///< of `size`
  VectorOf<double, size> eigenvalues;        ///< rising; the first size - rank are as good as zero
  MatrixOf<double, size> directions;         ///< unit vectors of the scaled error, one a column, as the eigenvalues
  VectorOf<double, size> unobservable_part;  ///< of each of the error's numbers: 0 determined, 1 not touched at all

  [[nodiscard]] bool complete() const { return rank == size; }
  /// Largest eigenvalue by smallest: infinite when something is not observable.
  [[nodiscard]] double condition() const {
    return complete() ? eigenvalues[size - 1] / eigenvalues[0] : std::numeric_limits<double>::infinity();
  }

  /// "position x", "turn about z", "acceleration y", ...: a number of the error state.
  [[nodiscard]] static std::string error_name(int i) {
    constexpr std::array<const char*, 6> kinds{"position ",      "turn about ",   "velocity ",
                                               "turning about ", "acceleration ", "turning faster about "};
    return std::string(kinds[static_cast<std::size_t>(i / 3)]) + "xyz"[i % 3];
  }

  /// A column of `directions` in words, its largest numbers first: "0.80 position x - 0.60 turn about y".
  [[nodiscard]] std::string describe(int direction) const {
    VectorOf<double, size> rest = directions.col(direction);
    Eigen::Index largest = 0;
    rest.cwiseAbs().maxCoeff(&largest);
    if (rest[largest] < 0.0) rest = -rest;
    std::string words;
    while (rest.cwiseAbs().maxCoeff(&largest) >= 0.1) {
      char number[16];
      std::snprintf(number, sizeof number, "%.2f ", std::abs(rest[largest]));
      if (!words.empty()) words += rest[largest] < 0.0 ? " - " : " + ";
      words += number + error_name(static_cast<int>(largest));
      rest[largest] = 0.0;
    }
    return words;
  }

  /// All that cannot be observed, a line each; empty when everything can.
  [[nodiscard]] std::string unobservable() const {
    std::string lines;
    for (int i = 0; i < size - rank; ++i) lines += describe(i) + "\n";
    return lines;
  }
};

template <int Order>
class ObservabilityWindow {
 public:
  static constexpr int size = 6 * Order;

  explicit ObservabilityWindow(const ProcessModel<Order>& model) : model_(model) {}

  void clear() { count_ = 0; }

  /// A measurement linearised at `state`, in the order of time.
  template <int Size, int StateSize, int SourceSize, int SensorSize>
  [[nodiscard]] bool add(const TargetState<Order>& state,
                         const LinearizationOf<Size, StateSize, SourceSize, SensorSize>& linear) {
    static_assert(StateSize <= size);
    MatrixOf<double, Size> L;
    if (!cholesky<Size>(linear.R, L) || !linear.H.allFinite()) return false;
    if (count_ > 0 && state.t < newest_.t) return false;
    if (count_ == 0) {
      information_.setZero();
      begin_ = state.t;
    } else if (state.t > newest_.t) {
      // Of any size one solver: each fixed size would be compiled anew.
      const MatrixOf<double, size> back = Eigen::MatrixXd(state_transition(newest_, model_, state.t)).inverse();
      information_ = (back.transpose() * information_ * back).eval();
    }
    const MatrixOf<double, Size, StateSize> white = whitened_by<Size, StateSize>(L, linear.H);
    information_.template topLeftCorner<StateSize, StateSize>() += white.transpose() * white;
    newest_ = state;
    ++count_;
    return true;
  }

  /// M, in the error's own units.
  [[nodiscard]] const MatrixOf<double, size>& information() const { return information_; }

  /// Precondition: something was added.
  [[nodiscard]] Observability<Order> report() const {
    HOLDFAST_ASSERT(count_ > 0, "there is nothing to observe by");
    VectorOf<double, size> scale = VectorOf<double, size>::Ones();
    const double T = to_seconds(newest_.t - begin_);
    if (Order >= 2 && T > 0.0) scale.template segment<6>(Order >= 2 ? 6 : 0).setConstant(1.0 / T);
    if (Order >= 3 && T > 0.0) scale.template segment<6>(Order >= 3 ? 12 : 0).setConstant(2.0 / (T * T));
    using Plain = Eigen::Matrix<double, size, size>;  // Eigen's solver wants its own alignment
    const Eigen::SelfAdjointEigenSolver<Plain> eigen(Plain(scale.asDiagonal() * information_ * scale.asDiagonal()));
    Observability<Order> found;
    found.measurements = count_;
    found.eigenvalues = eigen.eigenvalues();
    found.directions = eigen.eigenvectors();
    const double least = Observability<Order>::rank_tolerance * found.eigenvalues[size - 1];
    found.unobservable_part.setZero();
    for (int i = 0; i < size; ++i) {
      if (found.eigenvalues[i] > least) {
        ++found.rank;
      } else {
        found.unobservable_part += found.directions.col(i).cwiseAbs2();
      }
    }
    return found;
  }

 private:
  ProcessModel<Order> model_;
  MatrixOf<double, size> information_ = MatrixOf<double, size>::Zero();
  TargetState<Order> newest_;
  HostTime begin_;
  int count_ = 0;
};

}  // namespace holdfast
