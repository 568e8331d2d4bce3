/// Finds the parameters that make two estimates of one thing agree best, with covariance, and says which could not be found.
///
/// A FitModel gives for each comparison i three numbers r_i(x) that should be zero, and J_i = dr_i/dx. Parameters have a nominal
/// value and a deviation from it that is thought possible; the estimate minimises
///   sum_i w_i |r_i|^2 / s^2 + sum_j ((x_j - nominal_j) / deviation_j)^2
/// by Gauss and Newton's method with Levenberg's damping. s comes from the residuals' median, w_i are below one where a residual
/// is beyond 5 s. A direction of x that the recording does not tell twice as well as it was known before stays at its nominal
/// value, and keeps its deviation: noise alone could move it.
/// Why not Powell's method, as 001: derivatives are known here, and without them ten to twenty parameters take thousands of costs.
///
/// Covariance: neighbouring comparisons share poses, and the sensor's noise of the same moments, so that J^T J alone would say
/// too much or too little. Both noises are taken for white, and measured (window_noise.hpp). So with H = J^T J / s^2 + prior, and S the covariance of the
/// gradient under those noises, the estimate's is H^-1 S H^-1 ("sandwich"; White 1980). What is not white noise (a bias that
/// wanders, a model that is not quite right) shows in the tenths of the recording, whose gradients then disagree by more: `excess`
/// is how many times more, and where it is above 1 all deviations are larger by it.
/// Bad input: fewer than `least_comparisons`, or what is not finite: ok is false. Allocates.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <holdfast/calibration/window_noise.hpp>

namespace holdfast {

namespace detail {

class ParameterFitter {
 public:
  ParameterFitter(FitModel& model, const std::vector<double>& times)
      : model_(&model), times_(&times), size_(static_cast<int>(model.parameters().size())) {}

  ParameterFit run(const Eigen::VectorXd& start) {
    fit_.parameters = model_->parameters();
    fit_.comparisons = model_->windows().size();
    fit_.x = start;
    if (fit_.comparisons < ParameterFit::least_comparisons || !start.allFinite()) return fit_;
    deviations_.resize(size_);
    for (int j = 0; j < size_; ++j) deviations_[j] = fit_.parameters[static_cast<std::size_t>(j)].deviation;
    prior_ = deviations_.cwiseAbs2().cwiseInverse();
    weights_.assign(fit_.comparisons, 1.0);
    measure_residuals(false);
    for (int round = 0; round < 8; ++round) {
      const double before = scale_;
      find_free_directions(round == 0);
      if (!descend()) return fit_;
      measure_residuals(true);
      if (std::abs(scale_ - before) < 1e-3 * before) break;
    }
    if (!descend()) return fit_;
    estimate_covariance();
    fit_.ok = fit_.x.allFinite() && fit_.covariance.allFinite();
    return fit_;
  }

 private:
  /// Scale by the median, and weights of what lies beyond.
  void measure_residuals(bool down_weigh) {
    constexpr std::array medians{0.455, 1.386, 2.366};  // of chi^2 with so many degrees of freedom
    residuals_.resize(fit_.comparisons);
    std::vector<double> squares(fit_.comparisons);
    FitModel::Jacobian J(3, size_);
    model_->prepare(fit_.x);
    for (std::size_t i = 0; i < squares.size(); ++i) {
      model_->compare(i, residuals_[i], J);
      squares[i] = residuals_[i].squaredNorm();
    }
    std::vector<double> sorted = squares;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::ranges::nth_element(sorted, middle);
    scale_ = std::sqrt(*middle / medians[static_cast<std::size_t>(std::clamp(model_->used_axes(), 1, 3) - 1)]) + 1e-13;
    if (!down_weigh) return;
    const double limit = 25.0 * scale_ * scale_;
    for (std::size_t i = 0; i < squares.size(); ++i) weights_[i] = squares[i] > limit ? limit / squares[i] : 1.0;
  }

  /// H, gradient and cost at x.
  double normal_equations(const Eigen::VectorXd& x, Eigen::MatrixXd& H, Eigen::VectorXd& gradient) {
    H = prior_.asDiagonal();
    Eigen::VectorXd off(size_);
    for (int j = 0; j < size_; ++j) off[j] = x[j] - fit_.parameters[static_cast<std::size_t>(j)].nominal;
    gradient = prior_.cwiseProduct(off);
    double cost = off.dot(gradient);
    Vector3 r;
    FitModel::Jacobian J(3, size_);
    model_->prepare(x);
    for (std::size_t i = 0; i < fit_.comparisons; ++i) {
      model_->compare(i, r, J);
      const double w = weights_[i] / (scale_ * scale_);
      H.noalias() += w * J.transpose().lazyProduct(J);
      gradient.noalias() += w * J.transpose() * r;
      cost += w * r.squaredNorm();
    }
    return cost;
  }

  /// H in units of the deviations, in the free directions; one in the others.
  [[nodiscard]] Eigen::MatrixXd within_free(const Eigen::MatrixXd& H) const {
    const Eigen::MatrixXd scaled = deviations_.asDiagonal() * H * deviations_.asDiagonal();
    Eigen::MatrixXd within = free_ * scaled * free_ - free_;
    within.diagonal().array() += 1.0;
    return within;
  }

  /// Those in which what is sure to be motion tells more than the prior. The others start from nominal, and stay.
  void find_free_directions(bool from_nominal) {
    Eigen::VectorXd gradient(size_);
    Eigen::MatrixXd H(size_, size_);
    model_->count_sure_motion_alone(true);
    (void)normal_equations(fit_.x, H, gradient);
    model_->count_sure_motion_alone(false);
    const Eigen::MatrixXd scaled = deviations_.asDiagonal() * H * deviations_.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
    free_ = Eigen::MatrixXd::Identity(size_, size_);
    for (int k = 0; k < size_ && eigen.eigenvalues()[k] < 4.0; ++k) {
      free_ -= eigen.eigenvectors().col(k) * eigen.eigenvectors().col(k).transpose();
    }
    if (!from_nominal) return;
    Eigen::VectorXd off(size_);
    for (int j = 0; j < size_; ++j) off[j] = fit_.x[j] - fit_.parameters[static_cast<std::size_t>(j)].nominal;
    const Eigen::VectorXd stays = deviations_.cwiseProduct(free_ * off.cwiseQuotient(deviations_));
    fit_.x += stays - off;
  }

  bool descend() {
    Eigen::VectorXd gradient(size_), next_gradient(size_);
    Eigen::MatrixXd H(size_, size_), next_H(size_, size_);
    double cost = normal_equations(fit_.x, H, gradient), damping = 1e-6;
    for (int step = 0; step < 40; ++step) {
      ++fit_.iterations;
      if (!std::isfinite(cost)) return false;
      Eigen::MatrixXd damped = within_free(H);
      damped.diagonal() *= 1.0 + damping;
      const Eigen::VectorXd move =
          -deviations_.cwiseProduct(free_ * damped.llt().solve(free_ * deviations_.cwiseProduct(gradient)));
      const double next = normal_equations(fit_.x + move, next_H, next_gradient);
      const bool is_small = move.dot(H * move) < 1e-8 * size_;  // of the estimate's own deviation
      if (next <= cost) {
        fit_.x += move;
        cost = next;
        H = next_H;
        gradient = next_gradient;
        damping = std::max(1e-9, 0.1 * damping);
      } else {
        damping *= 10.0;
      }
      if (is_small || damping > 1e9) break;
    }
    H_ = H;
    return true;
  }

  /// Of the gradient's part that windows [from, to) make: its covariance under the two noises, and itself.
  struct Gradient {
    Eigen::MatrixXd covariance;
    Eigen::VectorXd value;
  };

  [[nodiscard]] Gradient gradient_of(std::size_t from, std::size_t to) const {
    const std::vector<PoseWindow>& windows = model_->windows();
    using Block = Eigen::Matrix<double, Eigen::Dynamic, 3>;
    Gradient gradient{Eigen::MatrixXd::Zero(size_, size_), Eigen::VectorXd::Zero(size_)};
    const std::size_t first = windows[from].first;
    std::vector<Block> by_pose;
    Vector3 r;
    FitModel::Jacobian J(3, size_);
    for (std::size_t i = from; i < to; ++i) {
      model_->compare(i, r, J);
      const double w = weights_[i] / (scale_ * scale_);
      gradient.value += w * J.transpose() * r;
      if (by_pose.size() <= windows[i].last() - first)
        by_pose.resize(windows[i].last() - first + 1, Block::Zero(size_, 3));
      for (std::size_t k = 0; k < windows[i].weights.size(); ++k) {
        if (windows[i].weights[k] == 0.0) continue;
        by_pose[windows[i].first - first + k] += w * windows[i].weights[k] * J.transpose();
      }
    }
    Block once = Block::Zero(size_, 3), twice = once;
    for (std::size_t j = 0; j < by_pose.size(); ++j) {
      gradient.covariance.noalias() += noise_.pose_variance * by_pose[j].lazyProduct(by_pose[j].transpose());
      if (first + j + 1 == times_->size()) break;
      const double dt = (*times_)[first + j + 1] - (*times_)[first + j];
      once += by_pose[j];
      twice += dt * once;
      const Block& acts = model_->sensor_sums() == 1 ? once : twice;
      gradient.covariance.noalias() += noise_.sensor_density * dt * acts.lazyProduct(acts.transpose());
    }
    return gradient;
  }

  /// How many times larger than white noise's the gradients of the recording's tenths are, squared.
  [[nodiscard]] double excess() const {
    const std::size_t n = fit_.comparisons, tenth = n / 10;
    double ratio = 0.0, count = 0.0;
    for (std::size_t from = 0; tenth > 0 && from + tenth <= n; from += tenth) {
      const Gradient gradient = gradient_of(from, from + tenth);
      for (int j = 0; j < size_; ++j) {
        const double expected = gradient.covariance(j, j);
        if (!(expected > 1e-6 * prior_[j])) continue;
        ratio += gradient.value[j] * gradient.value[j] / expected;
        count += 1.0;
      }
    }
    return count > 0.0 ? ratio / count : 1.0;
  }

  void estimate_covariance() {
    model_->prepare(fit_.x);
    measure_residuals(true);
    double squares = 0.0;
    for (std::size_t i = 0; i < residuals_.size(); ++i) {
      squares += weights_[i] * residuals_[i].squaredNorm();
      if (weights_[i] < 1.0) ++fit_.outliers;
    }
    fit_.rms = std::sqrt(squares / (model_->used_axes() * static_cast<double>(fit_.comparisons)));
    noise_ = estimate_window_noise(*model_, *times_, residuals_, weights_);
    fit_.pose_noise = std::sqrt(noise_.pose_variance);
    fit_.sensor_noise = std::sqrt(noise_.sensor_density);
    fit_.excess = std::sqrt(excess());
    Eigen::MatrixXd S = std::max(1.0, fit_.excess * fit_.excess) * gradient_of(0, fit_.comparisons).covariance;
    S.diagonal() += prior_;
    const Eigen::MatrixXd inverse = within_free(H_).llt().solve(free_);
    Eigen::MatrixXd scaled =
        inverse * deviations_.asDiagonal() * S * deviations_.asDiagonal() * inverse.transpose() - free_;
    scaled.diagonal().array() += 1.0;
    fit_.covariance = deviations_.asDiagonal() * scaled * deviations_.asDiagonal();
  }

  FitModel* model_;
  const std::vector<double>* times_;
  int size_;
  ParameterFit fit_;
  Eigen::VectorXd deviations_, prior_;
  Eigen::MatrixXd H_, free_;
  std::vector<double> weights_;
  std::vector<Vector3> residuals_;
  double scale_ = 1.0;
  WindowNoise noise_;
};

}  // namespace detail

/// The directions in which the covariance is not below a quarter of the prior's, as "0.71 orientation x + 0.71 orientation y".
[[nodiscard]] inline std::vector<std::string> unobserved_directions(const ParameterFit& fit) {
  Eigen::VectorXd known(fit.x.size());
  for (Eigen::Index j = 0; j < known.size(); ++j)
    known[j] = 1.0 / fit.parameters[static_cast<std::size_t>(j)].deviation;
  const Eigen::MatrixXd relative = known.asDiagonal() * fit.covariance * known.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(relative);
  std::vector<std::string> found;
  for (Eigen::Index k = known.size(); k-- > 0 && eigen.eigenvalues()[k] > 0.25;) {
    std::string words;
    for (Eigen::Index j = 0; j < known.size(); ++j) {
      const double part = eigen.eigenvectors()(j, k);
      if (std::abs(part) < 0.2) continue;
      char number[16] = "";
      if (std::abs(part) < 0.98) std::snprintf(number, sizeof number, "%.2f ", std::abs(part));
      words += (words.empty() ? (part < 0.0 && number[0] != 0 ? "-" : "") : (part < 0.0 ? " - " : " + "));
      words += number + fit.parameters[static_cast<std::size_t>(j)].name;
    }
    found.push_back(words);
  }
  return found;
}

/// `times` are the poses', s. Each parameter's scale is its deviation.
[[nodiscard]] inline ParameterFit fit_parameters(FitModel& model, const Eigen::VectorXd& start,
                                                 const std::vector<double>& times) {
  ParameterFit fit = detail::ParameterFitter(model, times).run(start);
  if (fit.ok) fit.unobserved = unobserved_directions(fit);
  return fit;
}

}  // namespace holdfast
