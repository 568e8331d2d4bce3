/// The time update: carries a state and its covariance on to a later time (002 step a, eq. 4.14).
///
///   p + v dt + a dt^2 / 2,   R exp(w dt + alpha dt^2 / 2),   P <- F P F^T + Q
/// with each axis's chain from chain_step.hpp (eqs 4.5, 4.7 for PV). Small turns are about the body's axes, which turn
/// meanwhile: F carries dphi by exp(-w dt), and dw by the right Jacobian, so that the covariance is right at low rates too.
/// `state_transition` is F as a matrix, for those who need it; `advance` never forms it: by blocks of 6 (pose, velocity,
/// acceleration), whose chains are diagonal, only dphi's rows and columns need 3x3 matrices (002 section 4.5.2).
/// Numerics: P comes out exactly symmetric, and positive definite if it came in so: each variance is raised by
/// `rounding_floor` of itself, far more than rounding can take away. (Where a sum cancels, what cancels has been raised by
/// the step before.)
/// Bad input: precondition t >= state.t. A turn that is no finite number is refused: false, and the state stays.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <type_traits>
#include <utility>

#include <holdfast/assert.hpp>
#include <holdfast/tracking/chain_step.hpp>
#include <holdfast/tracking/process_model.hpp>
#include <holdfast/tracking/target_state.hpp>

namespace holdfast {

/// Relative rise of every variance in each step of a filter. Rounding in 18 dimensions may take away about 1e-14 of it.
inline constexpr double rounding_floor = 1e-12;

namespace detail {

/// The six axes' chains over one step: entry (i, j) of each axis's A and Q, i <= j.
template <int Order>
struct SixChains {
  std::array<std::array<Vector6, Order>, Order> A;
  std::array<std::array<Vector6, Order>, Order> Q;
};

template <int Order>
[[nodiscard]] SixChains<Order> six_chains(const ProcessModel<Order>& model, double dt) {
  SixChains<Order> chains;
  ChainStep<Order> unit = chain_step<Order>(1.0, model.decay[0], dt);
  for (std::size_t i = 0; i < Order; ++i) {
    for (std::size_t j = i; j < Order; ++j) {
      chains.A[i][j].setConstant(unit.A(i, j));
      chains.Q[i][j] = unit.Q(i, j) * model.intensity;
    }
  }
  for (int axis = 1; axis < 6; ++axis) {
    if (model.decay[axis] == model.decay[0]) continue;
    unit = chain_step<Order>(1.0, model.decay[axis], dt);
    for (std::size_t i = 0; i < Order; ++i) {
      for (std::size_t j = i; j < Order; ++j) {
        chains.A[i][j][axis] = unit.A(i, j);
        chains.Q[i][j][axis] = unit.Q(i, j) * model.intensity[axis];
      }
    }
  }
  return chains;
}

/// How far the chains move the nominal state, whose pose counts from zero.
template <int Order>
[[nodiscard]] std::array<Vector6, Order> nominal_movement(const TargetState<Order>& state,
                                                          const SixChains<Order>& chains) {
  std::array<Vector6, Order> from;  // [0] is zero
  if constexpr (Order >= 2) from[1] << state.velocity.v_WB, state.velocity.w_WB_B;
  if constexpr (Order >= 3) from[2] << state.acceleration.a_WB, state.acceleration.alpha_WB_B;
  std::array<Vector6, Order> to;
  for (std::size_t i = 0; i < Order; ++i) {
    to[i].setZero();
    for (std::size_t j = std::max<std::size_t>(i, 1); j < Order; ++j) to[i] += chains.A[i][j].cwiseProduct(from[j]);
  }
  return to;
}

/// What a step's turn does to dphi: E dphi + J v, where v is what the chains add to it. Of a turn below a milliradian J is
/// (I + E) / 2 to a ten millionth, and half the work is saved: E (dphi + v/2) + v/2.
struct TurnTransition {
  Matrix3 E;  ///< exp(-turn)
  Matrix3 J;  ///< the turn's right Jacobian; not filled in when small
  bool small;

  TurnTransition(const Vector3& turn, const Quaternion& q_turn, double small_angle = 1e-3)
      : E(q_turn.conjugate().toRotationMatrix()), small(turn.squaredNorm() < small_angle * small_angle) {
    if (!small) J = so3::right_jacobian<double>(turn);
  }
};

/// Calls f(std::integral_constant<int, i>()) for i = 0 to Count - 1: a loop that is certainly unrolled.
template <int Count, typename Function>
void unrolled(const Function& f) {
  [&]<int... i>(std::integer_sequence<int, i...>) {
    (f(std::integral_constant<int, i>()), ...);
  }
  (std::make_integer_sequence<int, Count>());
}

/// The upper triangle of the first `Count` rows and columns takes the lower one's numbers.
template <int Size, int Count = Size>
void mirror_lower(MatrixOf<double, Size>& P) {
  unrolled<Count>([&]<int j>(std::integral_constant<int, j>) {
    P.row(j).template segment<Count - j - 1>(j + 1) = P.col(j).template segment<Count - j - 1>(j + 1).transpose();
  });
}

/// The columns of dphi in P F^T, row by row. With `small` J's rows are not needed: E f + J v = E (f + v/2) + v/2.
template <bool small, int Order, int Rows>
void turn_columns(const MatrixOf<double, Rows, 6 * Order>& from, const SixChains<Order>& chains,
                  const TurnTransition& turn, MatrixOf<double, Rows, 6 * Order>& to) {
  const Matrix3 E = turn.E;
  const Matrix3 J = turn.J;
  double a[Order][3];
  for (std::size_t j = 1; j < Order; ++j) {
    for (int k = 0; k < 3; ++k) a[j][k] = (small ? 0.5 : 1.0) * chains.A[0][j][3 + k];
  }
  for (int i = 0; i < Rows; ++i) {
    double f[3], v[3];
    for (int k = 0; k < 3; ++k) {
      f[k] = from(i, 3 + k);
      v[k] = Order >= 2 ? a[1][k] * from(i, 9 + k) : 0.0;
      if constexpr (Order == 3) v[k] += a[2][k] * from(i, 15 + k);
      if (small) f[k] += v[k];
    }
    for (int k = 0; k < 3; ++k) {
      const double turned = E(k, 0) * f[0] + E(k, 1) * f[1] + E(k, 2) * f[2];
      to(i, 3 + k) = turned + (small ? v[k] : J(k, 0) * v[0] + J(k, 1) * v[1] + J(k, 2) * v[2]);
    }
  }
}

/// The columns of the pose in P F^T, or in that of any rows of covariances with the state's error. `to` is not `from`.
template <int Order, int Rows>
void pose_columns(const MatrixOf<double, Rows, 6 * Order>& from, const SixChains<Order>& chains,
                  const TurnTransition& turn, MatrixOf<double, Rows, 6 * Order>& to) {
  for (int k = 0; k < 3; ++k) {
    if constexpr (Order == 1) to.col(k) = from.col(k);
    if constexpr (Order >= 2) to.col(k) = from.col(k) + chains.A[0][1][k] * from.col(6 + k);
    if constexpr (Order == 3) to.col(k) += chains.A[0][2][k] * from.col(12 + k);
  }
  turn.small ? turn_columns<true, Order, Rows>(from, chains, turn, to)
             : turn_columns<false, Order, Rows>(from, chains, turn, to);
}

/// X F^T, where X's rows are covariances of anything with the state's error. `to` is not `from`.
template <int Order, int Rows>
void carry_rows(const MatrixOf<double, Rows, 6 * Order>& from, const SixChains<Order>& chains,
                const TurnTransition& turn, MatrixOf<double, Rows, 6 * Order>& to) {
  pose_columns<Order, Rows>(from, chains, turn, to);
  for (std::size_t i = 1; i < Order; ++i) {
    const auto at = [](std::size_t block) { return 6 * static_cast<int>(block); };
    to.template middleCols<6>(at(i)) = from.template middleCols<6>(at(i)) * chains.A[i][i].asDiagonal();
    for (std::size_t j = i + 1; j < Order; ++j) {
      to.template middleCols<6>(at(i)) += from.template middleCols<6>(at(j)) * chains.A[i][j].asDiagonal();
    }
  }
}

/// The blocks of velocity and acceleration: these chains do not turn.
template <int Order>
void carry_derivatives(const MatrixOf<double, 6 * Order>& from, const SixChains<Order>& chains,
                       MatrixOf<double, 6 * Order>& to) {
  constexpr int rest = 6 * Order - 6;
  MatrixOf<double, rest, 6 * Order> rows = to.template bottomRows<rest>();
  rows.template rightCols<rest>() = from.template bottomRightCorner<rest, rest>();
  const Vector6& kept = chains.A[Order - 1][Order - 1];
  if constexpr (Order == 3) {
    rows.template middleCols<6>(6) = rows.template middleCols<6>(6) * chains.A[1][1].asDiagonal() +
                                     rows.template middleCols<6>(12) * chains.A[1][2].asDiagonal();
  }
  rows.template rightCols<6>() *= kept.asDiagonal();
  if constexpr (Order == 3) {
    to.template middleRows<6>(6) = chains.A[1][1].asDiagonal() * rows.template topRows<6>();
    to.template middleRows<6>(6) += chains.A[1][2].asDiagonal() * rows.template bottomRows<6>();
  }
  to.template bottomRows<6>() = kept.asDiagonal() * rows.template bottomRows<6>();
}

/// The lower triangle of F P F^T + Q, and all of its block of the pose. F is upper triangular in blocks of 6, and but for
/// the turns these are diagonal. Columns first, then those rows that are needed. `to` is not `from`.
template <int Order>
void carry_lower(const MatrixOf<double, 6 * Order>& from, const SixChains<Order>& chains, const TurnTransition& turn,
                 MatrixOf<double, 6 * Order>& to) {
  pose_columns<Order, 6 * Order>(from, chains, turn, to);

  unrolled<3>([&]<int k>(std::integral_constant<int, k>) {
    Vector3 f = to.template block<3, 1>(3, 3 + k);
    Vector3 v = Vector3::Zero();
    if constexpr (Order >= 2) v = chains.A[0][1].template tail<3>().cwiseProduct(to.template block<3, 1>(9, 3 + k));
    if constexpr (Order == 3) v += chains.A[0][2].template tail<3>().cwiseProduct(to.template block<3, 1>(15, 3 + k));
    auto rows = to.template block<3 - k, 1>(3 + k, 3 + k);
    if (turn.small) {
      v *= 0.5;
      f += v;
      rows = turn.E.template bottomRows<3 - k>().lazyProduct(f) + v.template tail<3 - k>();
    } else {
      rows = turn.E.template bottomRows<3 - k>().lazyProduct(f) + turn.J.template bottomRows<3 - k>().lazyProduct(v);
    }
  });
  for (int j = 1; j < Order; ++j) {
    to.template block<3, 6>(0, 0) += chains.A[0][j].template head<3>().asDiagonal() * to.template block<3, 6>(6 * j, 0);
  }
  to.template block<3, 3>(3, 0) = to.template block<3, 3>(0, 3).transpose();

  if (Order == 3 || (Order == 2 && chains.A[1][Order - 1].minCoeff() < 1.0)) {
    carry_derivatives<Order>(from, chains, to);
  } else if constexpr (Order == 2) {
    to.template bottomRightCorner<6, 6>() = from.template bottomRightCorner<6, 6>();
  }

  for (int i = 0; i < Order; ++i) {
    for (int j = i; j < Order; ++j) to.template block<6, 6>(6 * j, 6 * i).diagonal() += chains.Q[i][j];
  }
  to.diagonal() *= 1.0 + rounding_floor;
  if (!turn.small) {  // what a turn brings from one axis to another may cancel
    double summed = from.template block<3, 3>(3, 3).trace();
    for (int j = 1; j < Order; ++j) {
      summed += chains.A[0][j].template tail<3>().cwiseAbs2().dot(from.diagonal().template segment<3>(6 * j + 3));
    }
    to.diagonal().template segment<3>(3).array() += rounding_floor * summed;
  }
  mirror_lower<6 * Order, 6>(to);
}

}  // namespace detail

/// F of the error d (target_state.hpp) from state.t to t >= state.t.
template <int Order>
[[nodiscard]] typename TargetState<Order>::Covariance state_transition(const TargetState<Order>& state,
                                                                       const ProcessModel<Order>& model, HostTime t) {
  const detail::SixChains<Order> chains = detail::six_chains(model, to_seconds(t - state.t));
  const Vector3 angle = detail::nominal_movement(state, chains)[0].template tail<3>();
  const detail::TurnTransition turn(angle, so3::exp<double>(angle), 0.0);
  typename TargetState<Order>::Covariance F = TargetState<Order>::Covariance::Zero();
  for (int i = 0; i < Order; ++i) {
    for (int j = i; j < Order; ++j) F.template block<6, 6>(6 * i, 6 * j).diagonal() = chains.A[i][j];
  }
  F.template block<3, 3>(3, 3) = turn.E;
  for (int j = 1; j < Order; ++j) {
    F.template block<3, 3>(3, 6 * j + 3) = turn.J * chains.A[0][j].template tail<3>().asDiagonal();
  }
  return F;
}

namespace detail {

/// `advance` from one state to another (not the same), but for the upper triangle of P beyond the pose's block:
/// for those who correct it next (innovation.hpp), which fills it in. `also(chains, turn)` carries whatever else is
/// correlated with the state's error.
template <int Order, typename Also>
bool advance_lower(const TargetState<Order>& from, const ProcessModel<Order>& model, HostTime t, TargetState<Order>& to,
                   const Also& also) {
  HOLDFAST_ASSERT(t >= from.t, "a state is carried forward only");
  const SixChains<Order> chains = six_chains(model, to_seconds(t - from.t));
  const std::array<Vector6, Order> movement = nominal_movement(from, chains);
  const Vector3 turn = movement[0].template tail<3>();
  if (!(turn.squaredNorm() < std::numeric_limits<double>::max())) return false;
  const Quaternion q_turn = so3::exp<double>(turn);
  const TurnTransition turn_transition(turn, q_turn);
  carry_lower<Order>(from.P, chains, turn_transition, to.P);
  also(chains, turn_transition);
  to.X_WB = Rigid(from.X_WB.q() * q_turn, from.X_WB.p() + movement[0].template head<3>());
  if constexpr (Order >= 2) {
    to.velocity.v_WB = movement[1].template head<3>();
    to.velocity.w_WB_B = movement[1].template tail<3>();
  }
  if constexpr (Order >= 3) {
    to.acceleration.a_WB = movement[2].template head<3>();
    to.acceleration.alpha_WB_B = movement[2].template tail<3>();
  }
  to.t = t;
  return true;
}

template <int Order>
bool advance_lower(const TargetState<Order>& from, const ProcessModel<Order>& model, HostTime t,
                   TargetState<Order>& to) {
  return advance_lower(from, model, t, to, [](const auto&, const auto&) {});
}

}  // namespace detail

template <int Order>
bool advance(TargetState<Order>& state, const ProcessModel<Order>& model, HostTime t) {
  if (t == state.t) return true;
  const TargetState<Order> from = state;
  if (!detail::advance_lower(from, model, t, state)) return false;
  detail::mirror_lower<6 * Order>(state.P);
  return true;
}

}  // namespace holdfast
