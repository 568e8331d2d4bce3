/// Several process models at once: interacting multiple models (IMM), so that nobody has to say whether the body is at rest.
///
/// 002 section 7.3 asks for it, and the HiBall paper (7.1): tuned for stillness a filter is smooth but lags in motion, tuned
/// for motion it jitters at rest. Here each model has a filter of its own, and the body is taken to change between models as
/// a Markov chain does that stays with model i for `mean_stay_s[i]` seconds on average:
///   p_ii(dt) = exp(-dt / mean_stay),   else the rest in equal parts.
/// One step (Blom and Bar-Shalom 1988; Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
/// Navigation, 11.6.6), from the probabilities mu_i:
///   mix       c_j = sum_i p_ij mu_i;  model j starts from the mixture of all states with weights p_ij mu_i / c_j
///   filter    each model advances and corrects its own state by the same measurement, and the same device
///   weigh     mu_j = c_j N(y_j; 0, S_j), scaled to sum 1
///   combine   state and device leave as the mixture's mean and covariance, spread of the means included
/// Means and spreads are of errors against the heaviest state (error_of, add); that its small turns and those of the
/// others are about axes turned by the states' difference is neglected.
/// The gate looks at the model that finds a measurement the likeliest: what fits one of them is no outlier. Everything
/// else is as in scaat_filter.hpp: same statuses, whole or not at all, nothing is allocated. One model alone is a ScaatFilter.
/// A mean stay is a price more than a fact: the shorter the still model's, the less a body at rest gains, and a change is
/// noticed in a few measurements anyway (docs/tracking.md has figures). Cost: Count updates and Count^2 mixtures.
/// Bad input: as there; `problem` names bad sets.
#pragma once

#include <cmath>

#include <holdfast/tracking/scaat_filter.hpp>

namespace holdfast {

template <int Order, int Count>
struct ModelSet {
  static_assert(Count >= 1);
  std::array<ProcessModel<Order>, Count> models;
  std::array<double, Count> mean_stay_s;  ///< infinity: never left

  [[nodiscard]] std::optional<std::string_view> problem() const {
    for (const ProcessModel<Order>& model : models) {
      if (const auto problem = model.problem()) return problem;
    }
    for (const double stay : mean_stay_s) {
      if (!(stay > 0.0)) return "a model's mean stay is not positive";
    }
    return std::nullopt;
  }
};

/// Which of the models is at work, as a Markov chain: its probabilities, and how they change.
template <int Count>
class ModelChain {
 public:
  using Weights = std::array<double, Count>;

  /// All are equally likely at first.
  ModelChain() { probabilities_.fill(1.0 / Count); }

  [[nodiscard]] const Weights& probabilities() const { return probabilities_; }

  /// The step "mix": each model's mixture, which carry(from, model, to) takes to its place in `next`; and c_j. False when a
  /// state cannot be carried.
  template <int Order, typename State>
  [[nodiscard]] bool mix(const ModelSet<Order, Count>& set, double dt, const std::array<State, Count>& now,
                         std::array<State, Count>& next, Weights& arriving, const auto& carry) const {
    for (std::size_t j = 0; j < Count; ++j) {
      const Weights weights = mixing(set, j, dt, arriving[j]);
      const bool carried = Count == 1 ? carry(now[j], set.models[j], next[j])
                                      : carry(moment_matched(now, weights), set.models[j], next[j]);
      if (!carried) return false;
    }
    return true;
  }

  /// mu_j = c_j N_j, scaled. Logarithms first: a density may be too small for a number.
  void weigh(const Weights& arriving, const Weights& log_likelihoods) {
    if (Count == 1) return;
    Weights logs;
    for (std::size_t j = 0; j < Count; ++j) logs[j] = std::log(arriving[j]) + log_likelihoods[j];
    const double most = *std::max_element(logs.begin(), logs.end());
    double sum = 0.0;
    for (double& weight : logs) sum += weight = std::exp(weight - most);
    for (std::size_t j = 0; j < Count; ++j) probabilities_[j] = logs[j] / sum;
  }

 private:
  /// p_ij mu_i / c_j of all i, for model j after dt seconds, and c_j.
  template <int Order>
  [[nodiscard]] Weights mixing(const ModelSet<Order, Count>& set, std::size_t j, double dt, double& arriving) const {
    Weights weights;
    arriving = 0.0;
    for (std::size_t i = 0; i < Count; ++i) {
      const double leave = Count == 1 ? 0.0 : -std::expm1(-dt / set.mean_stay_s[i]);
      weights[i] = probabilities_[i] * (i == j ? 1.0 - leave : leave / std::max(1, Count - 1));
      arriving += weights[i];
    }
    if (arriving > 0.0) {
      for (double& weight : weights) weight /= arriving;
    } else {
      weights.fill(0.0);
      weights[j] = 1.0;
    }
    return weights;
  }

  Weights probabilities_;
};

namespace detail {

template <std::size_t Count>
[[nodiscard]] std::size_t heaviest(const std::array<double, Count>& weights) {
  return static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
}

}  // namespace detail

/// Mean and covariance of a mixture of states of one time. Precondition: weights are not negative and sum to 1.
template <int Order, std::size_t Count>
[[nodiscard]] TargetState<Order> moment_matched(const std::array<TargetState<Order>, Count>& states,
                                                const std::array<double, Count>& weights) {
  using Error = typename TargetState<Order>::Error;
  const std::size_t reference = detail::heaviest(weights);
  TargetState<Order> matched = states[reference];
  if (weights[reference] == 1.0) return matched;
  std::array<Error, Count> offsets;
  Error mean = Error::Zero();
  for (std::size_t i = 0; i < Count; ++i) {
    offsets[i] = i == reference ? Error(Error::Zero()) : matched.error_of(states[i]);
    mean += weights[i] * offsets[i];
  }
  matched.P.setZero();
  for (std::size_t i = 0; i < Count; ++i) {
    const Error d = offsets[i] - mean;
    matched.P += weights[i] * (states[i].P + d.lazyProduct(d.transpose()));
  }
  matched.add(mean);
  return matched;
}

/// The same of one device as several filters see it. A locked one stays as it is.
template <int Size, std::size_t Count>
[[nodiscard]] DeviceEstimate<Size> moment_matched(const std::array<DeviceEstimate<Size>, Count>& devices,
                                                  const std::array<double, Count>& weights) {
  const std::size_t reference = detail::heaviest(weights);
  DeviceEstimate<Size> matched = devices[reference];
  if constexpr (Size > 0) {
    if (matched.locked || weights[reference] == 1.0) return matched;
    for (std::size_t i = 0; i < Count; ++i) matched.x += weights[i] * (devices[i].x - devices[reference].x);
    matched.P.setZero();
    for (std::size_t i = 0; i < Count; ++i) {
      const VectorOf<double, Size> d = devices[i].x - matched.x;
      matched.P += weights[i] * (devices[i].P + d.lazyProduct(d.transpose()));
    }
  }
  return matched;
}

template <int Order, int Count, typename Innovate = ExtendedInnovation>
class MultipleModelFilter : public MeasurementIntake<MultipleModelFilter<Order, Count, Innovate>> {
  using Intake = MeasurementIntake<MultipleModelFilter>;
  friend Intake;

 public:
  using State = TargetState<Order>;
  using Weights = std::array<double, Count>;

  /// Preconditions: the state is finite, models and gate settings have no problem.
  MultipleModelFilter(const State& start, const ModelSet<Order, Count>& set, const ScaatSettings& settings = {},
                      const Innovate& innovate = {})
      : Intake(settings), set_(set), innovate_(innovate) {
    HOLDFAST_ASSERT(!set.problem(), "bad models");
    restart(start);
  }

  /// Begins anew at a state, all models equally likely. Counters go on.
  void restart(const State& start) {
    HOLDFAST_ASSERT(start.is_finite(), "a filter starts from finite numbers");
    states_[current_].fill(start);
    chain_ = {};
    combined_ = start;
    this->forget();
  }

  /// All models together. nis() and whitened() are those of the model that found a measurement the likeliest.
  [[nodiscard]] const State& state() const { return combined_; }
  [[nodiscard]] PoseEstimate pose_estimate() const { return holdfast::pose_estimate(combined_); }
  /// What each model takes itself to be worth; they sum to 1.
  [[nodiscard]] const Weights& probabilities() const { return chain_.probabilities(); }
  [[nodiscard]] const State& state_of(std::size_t model) const { return states_[current_][model]; }
  [[nodiscard]] const ModelSet<Order, Count>& models() const { return set_; }

 private:
  using States = std::array<State, Count>;

  template <Measurement M>
  UpdateStatus try_update(HostTime t, const M& measurement, const DeviceSlot<M::source_size>& source,
                          const DeviceSlot<M::sensor_size>& sensor) {
    if (const auto refusal = this->refusal(combined_.t, t, source, sensor)) return *refusal;

    States& next = states_[1 - current_];
    Weights arriving;
    const auto carry = [&](const State& from, const ProcessModel<Order>& model, State& to) {
      return detail::advance_lower(from, this->roused(model), t, to);
    };
    if (!chain_.mix(set_, to_seconds(t - combined_.t), states_[current_], next, arriving, carry)) {
      return UpdateStatus::not_finite;
    }
    if constexpr (M::state_size > 6) {  // C takes more than the pose's columns
      for (State& state : next) detail::mirror_lower<6 * Order>(state.P);
    }
    std::array<DeviceEstimate<M::source_size>, Count> sources;
    std::array<DeviceEstimate<M::sensor_size>, Count> sensors;
    sources.fill(source.load());
    sensors.fill(sensor.load());

    std::array<Innovation<Order, M>, Count> innovations;
    Weights log_likelihoods;
    std::size_t likeliest = 0;
    for (std::size_t j = 0; j < Count; ++j) {
      const auto innovation = innovate_(next[j], measurement, sources[j], sensors[j]);
      if (!innovation) return detail::cause_of_no_innovation(next[j], measurement, sources[j], sensors[j]);
      innovations[j] = *innovation;
      log_likelihoods[j] = innovation->log_likelihood();
      if (innovation->nis() < innovations[likeliest].nis()) likeliest = j;
    }
    const auto gated = this->template gated<M::size>(innovations[likeliest].whitened(), source, sensor);
    if (gated) return *gated;

    for (std::size_t j = 0; j < Count; ++j) {
      if (!correct(next[j], innovations[j], sources[j], sensors[j])) return UpdateStatus::not_finite;
    }
    chain_.weigh(arriving, log_likelihoods);
    source.store(moment_matched(sources, probabilities()), t);
    sensor.store(moment_matched(sensors, probabilities()), t);
    current_ = 1 - current_;
    combined_ = moment_matched(next, probabilities());
    return UpdateStatus::updated;
  }

  std::array<States, 2> states_;  ///< those that count, and where the next are tried
  std::size_t current_ = 0;
  State combined_;
  ModelChain<Count> chain_;
  ModelSet<Order, Count> set_;
  Innovate innovate_;
};

}  // namespace holdfast
