/// The time update: carries a state and its covariance on to a later time (002 step a, eq. 4.14).
///
///   p + v dt + a dt^2 / 2,   R exp(w dt + alpha dt^2 / 2),   P <- F P F^T + Q
/// with each axis's chain from chain_step.hpp (eqs 4.5, 4.7 for PV). Small turns are about the body's axes, which turn
/// meanwhile: F carries dphi by exp(-w dt), and dw by the right Jacobian, so that the covariance is right at low rates too.
/// `state_transition` is F as a matrix, for those who need it; `advance` never forms it: by blocks of 6 (pose, velocity,
/// acceleration), whose chains are diagonal, only dphi's rows and columns need 3x3 matrices (002 section 4.5.2).
/// Numerics: P comes out exactly symmetric, and positive definite if it came in so: each variance is raised by
/// `rounding_floor` of the terms that it was summed from, far more than rounding can take away.
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
  const bool alike = (model.decay.array() == model.decay[0]).all();
  for (int axis = 0; axis < 6; ++axis) {
    const ChainStep<Order> unit = chain_step<Order>(1.0, model.decay[axis], dt);
    for (std::size_t i = 0; i < Order; ++i) {
      for (std::size_t j = i; j < Order; ++j) {
        if (alike) {
          chains.A[i][j].setConstant(unit.A(i, j));
          chains.Q[i][j] = unit.Q(i, j) * model.intensity;
        } else {
          chains.A[i][j][axis] = unit.A(i, j);
          chains.Q[i][j][axis] = unit.Q(i, j) * model.intensity[axis];
        }
      }
    }
    if (alike) break;
  }
  return chains;
}

/// How far the chains move the nominal state, whose pose counts from zero.
template <int Order>
[[nodiscard]] std::array<Vector6, Order> nominal_movement(const TargetState<Order>& state,
                                                          const SixChains<Order>& chains) {
  std::array<Vector6, Order> from{};
  from[0].setZero();
  if constexpr (Order >= 2) from[1] << state.velocity.v_WB, state.velocity.w_WB_B;
  if constexpr (Order >= 3) from[2] << state.acceleration.a_WB, state.acceleration.alpha_WB_B;
  std::array<Vector6, Order> to{};
  for (std::size_t i = 0; i < Order; ++i) {
    to[i].setZero();
    for (std::size_t j = i; j < Order; ++j) to[i] += chains.A[i][j].cwiseProduct(from[j]);
  }
  return to;
}

/// What F does to dphi: E dphi + sum over j >= 1 of N[j] (the j-th derivative's turns).
template <int Order>
struct TurnTransition {
  double turn_squared;
  Matrix3 E;
  std::array<Matrix3, Order> N;

  TurnTransition(const Vector3& turn, const SixChains<Order>& chains) : turn_squared(turn.squaredNorm()) {
    const double c = so3::detail::one_minus_cos_over_square(turn_squared);
    const double k = so3::detail::angle_minus_sin_over_cube(turn_squared);
    E = so3::detail::hat_polynomial<double>(turn_squared * k - 1.0, c, turn);  // exp(-turn)
    const Matrix3 J = so3::detail::hat_polynomial<double>(-c, k, turn);        // its right Jacobian
    for (std::size_t j = 1; j < Order; ++j) N[j] = J * chains.A[0][j].template tail<3>().asDiagonal();
  }
};

/// What each variance after the step is summed from at most, were nothing to cancel: the scale of rounding errors.
template <int Order>
[[nodiscard]] VectorOf<double, 6 * Order> summed_variances(const MatrixOf<double, 6 * Order>& P,
                                                           const SixChains<Order>& chains, double turn_squared) {
  const VectorOf<double, 6 * Order> from = P.diagonal();
  VectorOf<double, 6 * Order> to;
  for (int i = 0; i < Order; ++i) {
    Vector6 sum = chains.A[i][i].cwiseAbs2().cwiseProduct(from.template segment<6>(6 * i));
    for (int j = i + 1; j < Order; ++j) sum += chains.A[i][j].cwiseAbs2().cwiseProduct(from.template segment<6>(6 * j));
    to.template segment<6>(6 * i) = sum;
  }
  // What a turn brings from one axis to another.
  to.template segment<3>(3).array() += std::min(1.0, turn_squared) * to.template segment<3>(3).sum();
  return to;
}

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

/// Column k of dphi in P F^T.
template <int Order>
[[nodiscard]] VectorOf<double, 6 * Order> turned_column(const MatrixOf<double, 6 * Order>& P,
                                                        const TurnTransition<Order>& turns, int k) {
  const Vector3 e = turns.E.row(k).transpose();
  VectorOf<double, 6 * Order> column;
  if constexpr (Order == 1) {
    column = P.template middleCols<3>(3).lazyProduct(e);
  } else {
    const Vector3 n1 = turns.N[1].row(k).transpose();
    column = P.template middleCols<3>(3).lazyProduct(e) + P.template middleCols<3>(9).lazyProduct(n1);
  }
  if constexpr (Order == 3) {
    const Vector3 n2 = turns.N[2].row(k).transpose();
    column += P.template middleCols<3>(15).lazyProduct(n2);
  }
  return column;
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
/// the turns these are diagonal. Columns first, then those rows that are needed. `to` may be `from`.
template <int Order>
void carry_lower(const MatrixOf<double, 6 * Order>& from, const SixChains<Order>& chains,
                 const TurnTransition<Order>& turns, MatrixOf<double, 6 * Order>& to) {
  const VectorOf<double, 6 * Order> floor = rounding_floor * summed_variances<Order>(from, chains, turns.turn_squared);

  const VectorOf<double, 6 * Order> turned[3] = {turned_column(from, turns, 0), turned_column(from, turns, 1),
                                                 turned_column(from, turns, 2)};
  for (int k = 0; k < 3; ++k) {
    if constexpr (Order == 1) to.col(k) = from.col(k);
    if constexpr (Order >= 2) to.col(k) = from.col(k) + chains.A[0][1][k] * from.col(6 + k);
    if constexpr (Order == 3) to.col(k) += chains.A[0][2][k] * from.col(12 + k);
    to.col(3 + k) = turned[k];
  }

  unrolled<3>([&]<int k>(std::integral_constant<int, k>) {
    VectorOf<double, 3 - k> rows = turns.E.template bottomRows<3 - k>().lazyProduct(turned[k].template segment<3>(3));
    for (int j = 1; j < Order; ++j) {
      rows += turns.N[j].template bottomRows<3 - k>().lazyProduct(turned[k].template segment<3>(6 * j + 3));
    }
    to.col(3 + k).template segment<3 - k>(3 + k) = rows;
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
  to.diagonal() += floor;
  mirror_lower<6 * Order, 6>(to);
}

}  // namespace detail

/// F of the error d (target_state.hpp) from state.t to t >= state.t.
template <int Order>
[[nodiscard]] typename TargetState<Order>::Covariance state_transition(const TargetState<Order>& state,
                                                                       const ProcessModel<Order>& model, HostTime t) {
  const detail::SixChains<Order> chains = detail::six_chains(model, to_seconds(t - state.t));
  const detail::TurnTransition<Order> turns(detail::nominal_movement(state, chains)[0].template tail<3>(), chains);
  typename TargetState<Order>::Covariance F = TargetState<Order>::Covariance::Zero();
  for (int i = 0; i < Order; ++i) {
    for (int j = i; j < Order; ++j) F.template block<6, 6>(6 * i, 6 * j).diagonal() = chains.A[i][j];
  }
  F.template block<3, 3>(3, 3) = turns.E;
  for (int j = 1; j < Order; ++j) F.template block<3, 3>(3, 6 * j + 3) = turns.N[j];
  return F;
}

namespace detail {

/// `advance` from one state to another (which may be the same), but for the upper triangle of P beyond the pose's block:
/// for those who correct it next (innovation.hpp), which fills it in.
template <int Order>
bool advance_lower(const TargetState<Order>& from, const ProcessModel<Order>& model, HostTime t,
                   TargetState<Order>& to) {
  HOLDFAST_ASSERT(t >= from.t, "a state is carried forward only");
  const SixChains<Order> chains = six_chains(model, to_seconds(t - from.t));
  const std::array<Vector6, Order> movement = nominal_movement(from, chains);
  const Vector3 turn = movement[0].template tail<3>();
  if (!(turn.squaredNorm() < std::numeric_limits<double>::max())) return false;
  carry_lower<Order>(from.P, chains, TurnTransition<Order>(turn, chains), to.P);
  to.X_WB = Rigid(from.X_WB.q() * so3::exp<double>(turn), from.X_WB.p() + movement[0].template head<3>());
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

}  // namespace detail

template <int Order>
bool advance(TargetState<Order>& state, const ProcessModel<Order>& model, HostTime t) {
  if (t == state.t) return true;
  if (!detail::advance_lower(state, model, t, state)) return false;
  detail::mirror_lower<6 * Order>(state.P);
  return true;
}

}  // namespace holdfast
