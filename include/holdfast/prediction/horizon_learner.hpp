/// Learns, from poses as they come, how to weigh what inertial readings tell of the future (motion_trend.hpp), and how
/// far that is off: for each of a few horizons by itself.
///
/// Every pose ends predictions that could have been made before it: the trends remembered from 10, 20, 40, 60, 100 and
/// 200 ms ago are examples for the weights of these horizons (fading_least_squares.hpp), and what was predicted then
/// errs by what the covariance is made of (error_spread.hpp). Nothing is learnt from a pose before it is there.
/// Examples rarely meet a horizon: of those nearer to it than to the others the nearest is taken, and what was learnt
/// counts for their mean. Between these, weights are interpolated, and covariances as powers of time.
/// Covariances are of the error against where the head is: without the poses' noise.
/// Units: s, rad, m. Hot path: nothing here allocates.
/// Bad input: precondition finite trends and poses.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <holdfast/prediction/error_spread.hpp>
#include <holdfast/prediction/motion_trend.hpp>
#include <holdfast/tracking/inertial_spread.hpp>

namespace holdfast {

struct HorizonWeights {
  MotionTrend::TurnWeights turn = usual_turn_weights();
  MotionTrend::MoveWeights move = usual_move_weights();
  Matrix3 turn_covariance = Matrix3::Zero();  ///< B, rad^2
  Matrix3 move_covariance = Matrix3::Zero();  ///< W, m^2
};

namespace detail {

/// Between covariances as if their size were a power of the time, between which `part` lies on a logarithmic scale.
[[nodiscard]] inline Matrix3 between_covariances(const Matrix3& a, const Matrix3& b, double part) {
  const double growth = b.trace() / a.trace(), of_b = std::pow(growth, part - 1.0);
  return (1.0 - part) * of_b * growth * a + part * of_b * b;
}

}  // namespace detail

struct HorizonLearnerSettings {
  double memory_s = 2.0;         ///< of the weights
  double spread_memory_s = 1.0;  ///< of the covariance
  double ridge = 1e-4;
  // Movements below which the usual weights hold.
  double rate = 0.01, angular_acceleration = 0.1, speed = 0.002, acceleration = 0.02, jerk = 0.3;
};

class HorizonLearner {
 public:
  static constexpr std::array horizons{0.01, 0.02, 0.04, 0.06, 0.1, 0.2};

  explicit HorizonLearner(const HorizonLearnerSettings& settings = {}) : settings_(settings) {
    for (std::size_t k = 0; k < horizons.size(); ++k) {
      const double h = horizons[k];
      learners_.push_back({{}, {}, ErrorSpread(1e-3 + 5.0 * h * h, 1e-3 + 1.0 * h * h)});
      met_[k] = h;
      publish(k, h);
    }
  }

  /// Call it with each measured pose that is believed. `noise`: what the poses' was found to be; `usual`: how uncertain
  /// the filter usually is after a pose, and `usual_age_s` how old that is when something is predicted.
  void learn(const TimedPose& pose, const PoseNoise& noise, const PoseSpread& usual, double usual_age_s) {
    noise_ = noise;
    usual_ = usual;
    usual_age_s_ = usual_age_s;
    const double since = learnt_ ? std::max(0.0, to_seconds(pose.t - learnt_until_)) : 0.0;
    learnt_ = true;
    learnt_until_ = pose.t;
    for (std::size_t k = 0; k < horizons.size(); ++k) {
      if (const Moment* moment = nearest(pose.t, k)) learn(k, *moment, pose, since);
    }
  }

  /// Something that might have been predicted from; they come in the order of time.
  void remember(const MotionTrend& trend) {
    Moment& next = moments_[(first_ + count_) % moments_.size()];
    next.trend = trend;
    next.weights = weights_;
    if (count_ < moments_.size()) {
      ++count_;
    } else {
      first_ = (first_ + 1) % moments_.size();
    }
  }
  void forget_moments() {
    count_ = 0;
    learnt_ = false;
  }

  /// For h seconds after the newest reading. Beyond the last horizon the covariance grows with the cube of the time.
  [[nodiscard]] HorizonWeights at(double h) const {
    if (h <= met_.front()) return weights_.front();
    if (h >= met_.back()) {
      HorizonWeights last = weights_.back();
      const double growth = std::pow(h / met_.back(), 3);
      last.turn_covariance *= growth;
      last.move_covariance *= growth;
      return last;
    }
    std::size_t k = 1;
    while (h > met_[k]) ++k;
    const double part = std::log(h / met_[k - 1]) / std::log(met_[k] / met_[k - 1]);
    const HorizonWeights &a = weights_[k - 1], &b = weights_[k];
    return {(1.0 - part) * a.turn + part * b.turn, (1.0 - part) * a.move + part * b.move,
            detail::between_covariances(a.turn_covariance, b.turn_covariance, part),
            detail::between_covariances(a.move_covariance, b.move_covariance, part)};
  }

 private:
  static constexpr double largest_weight = 10.0;  ///< no trend is worth more; bad luck in a few examples may say so

  using AllWeights = std::array<HorizonWeights, horizons.size()>;
  struct Moment {
    MotionTrend trend;
    AllWeights weights;
  };
  struct Learner {
    FadingLeastSquares<MotionTrend::turns> turn;
    FadingLeastSquares<MotionTrend::moves> move;
    ErrorSpread spread;
  };

  /// Between which times an example counts for a horizon: these do not touch.
  static constexpr std::array<double, horizons.size() + 1> edges{0.005, 0.015, 0.03, 0.05, 0.08, 0.15, 0.3};

  [[nodiscard]] const Moment* nearest(HostTime t, std::size_t k) const {
    const Moment* best = nullptr;
    double best_miss = horizons[k];
    for (std::size_t i = 0; i < count_; ++i) {
      const Moment& moment = moments_[(first_ + i) % moments_.size()];
      const double h = to_seconds(t - moment.trend.t) + moment.trend.gap, miss = std::abs(h - horizons[k]);
      if (miss >= best_miss || h < edges[k] || h >= edges[k + 1]) continue;
      best_miss = miss;
      best = &moment;
    }
    return best;
  }

  void learn(std::size_t k, const Moment& then, const TimedPose& pose, double since) {
    Learner& learner = learners_[k];
    const double h = to_seconds(pose.t - then.trend.t);
    const MotionTrend& trend = then.trend;
    const auto turns = trend.turn_over(h);
    const auto moves = trend.move_over(h);
    const Vector3 turned = so3::log<double>(trend.X_WS.q().conjugate() * pose.X_WB.q());
    const Vector3 moved = pose.X_WB.p() + pose.X_WB.q() * trend.lever_B - trend.X_WS.p();
    met_[k] += 0.02 * (h + trend.gap - met_[k]);
    const HorizonWeights& said = then.weights[k];
    const Rigid X = trend.carried(turns * said.turn, moves * said.move);
    const double fade = std::exp(-since / settings_.spread_memory_s);
    const Vector3 turn_error = so3::log<double>(X.q().conjugate() * pose.X_WB.q());
    learner.spread.add(turn_error, pose.X_WB.p() - X.p(), said.turn_covariance, said.move_covariance, noise_, fade);

    const double weights_fade = std::exp(-since / settings_.memory_s);
    learner.turn.add(turns, turned, weights_fade);
    learner.move.add(moves, moved, weights_fade);
    publish(k, h);
  }

  void publish(std::size_t k, double h) {
    const HorizonLearnerSettings& s = settings_;
    MotionTrend::TurnWeights turn = MotionTrend::TurnWeights::Constant(0.5 * h * h * s.angular_acceleration);
    turn[0] = h * s.rate;
    MotionTrend::MoveWeights move = MotionTrend::MoveWeights::Constant(0.5 * h * h * s.acceleration);
    move[0] = h * s.speed;
    move[3] = h * h * h / 6.0 * s.jerk;
    const Learner& learner = learners_[k];
    const MotionTrend::TurnWeights of_turn = learner.turn.solve(usual_turn_weights(), s.ridge, turn);
    const MotionTrend::MoveWeights of_move = learner.move.solve(usual_move_weights(), s.ridge, move);
    weights_[k] = {
        of_turn.cwiseMax(-largest_weight).cwiseMin(largest_weight),
        of_move.cwiseMax(-largest_weight).cwiseMin(largest_weight),
        learner.spread.turn_covariance(noise_.orientation_rad * noise_.orientation_rad,
                                       usual_.turn_rad2(usual_age_s_ + h)),
        learner.spread.move_covariance(noise_.position_m * noise_.position_m, usual_.place_m2(usual_age_s_ + h))};
  }

  HorizonLearnerSettings settings_;
  std::vector<Learner> learners_;
  std::array<double, horizons.size()> met_;  ///< what the horizons of the examples were of late; these increase
  AllWeights weights_;
  std::array<Moment, 64> moments_;
  std::size_t first_ = 0, count_ = 0;
  bool learnt_ = false;
  HostTime learnt_until_;
  PoseNoise noise_{0.0, 0.0};  ///< of the newest pose
  PoseSpread usual_;
  double usual_age_s_ = 0.0;
};

}  // namespace holdfast
