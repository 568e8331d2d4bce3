/// Finds the parameters of a filter, or of anything else, that cost least (002 section E.4). Target holdfast::calibration;
/// needs NLopt and the core.
///
///     const std::vector<TunedParameter> parameters{{"process noise", "m^2/s^3", 1.0, 1e-3, 1e3}, ...};
///     const TuningResult tuned = tune(parameters, [](std::span<const double> values) { return error_with(values); });
///     if (tuned.ok()) use(tuned.found);
///
/// 002 took Powell's method of conjugate directions (E.4, [Press90]). Two of its descendants are at hand, in NLopt:
///   bobyqa  Powell 2009: keeps a quadratic model of the cost within a trust region. The default: fewest evaluations.
///   praxis  Brent 1973: Powell's method, with directions made orthogonal anew. Knows no bounds: beyond one the search
///           is reflected, so that the cost is never asked there. For a single parameter it is the only one.
/// Neither needs derivatives, both find a local minimum near the start. Same input, same result.
/// The cost of a filter is rough (a gate lets one more through), and either may take roughness for a minimum. So a search
/// that ended begins anew from the best, with its first step, until that gains less than `least_gain` of the cost.
/// `first_step` and `tolerance` are fractions of the way between a parameter's bounds, on its scale (tuned_parameter.hpp).
/// The result holds the best of all that were tried, however the search ended.
/// Bad input: no parameters, a parameter or setting that cannot be, a cost that is not finite: `problem` names it, and
/// nothing of NLopt is thrown. Give a filter that diverged a large finite cost. What the cost function throws passes on.
/// Not for hot paths: it allocates. praxis seeds NLopt's random numbers, which the whole program shares.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlopt.h>

#include <holdfast/calibration/tuned_parameter.hpp>

namespace holdfast {

enum class TuningMethod { bobyqa, praxis };

struct TuningSettings {
  TuningMethod method = TuningMethod::bobyqa;
  int max_evaluations = 300;
  double first_step = 0.1;
  double tolerance = 1e-3;
  double least_gain = 1e-3;
};

enum class TuningStop {
  converged,        ///< no parameter moved by more than the tolerance
  evaluations,      ///< the limit of evaluations was reached
  stuck,            ///< rounding stopped the optimiser: seldom far from a minimum
  cost_not_finite,  ///< of the start, or on the way
  failed,           ///< the optimiser gave up, for the reason in `problem`
  bad_input,
};

struct TuningResult {
  std::vector<double> found;  ///< in the order of the parameters; empty when nothing could be evaluated
  double start_cost = 0.0, cost = 0.0;
  int evaluations = 0;
  TuningStop stop = TuningStop::bad_input;
  std::string problem;  ///< of what is not ok()

  /// Whether the search ended as it should, or by its limit.
  [[nodiscard]] bool ok() const { return stop <= TuningStop::stuck; }
};

[[nodiscard]] constexpr const char* describe(TuningStop stop) {
  switch (stop) {
    case TuningStop::converged:
      return "converged";
    case TuningStop::evaluations:
      return "limit of evaluations";
    case TuningStop::stuck:
      return "no further by rounding";
    case TuningStop::cost_not_finite:
      return "cost not finite";
    case TuningStop::failed:
      return "the optimiser failed";
    case TuningStop::bad_input:
      return "bad input";
  }
  return "";
}

/// Of the parameters' values, in their order.
using TuningCost = std::function<double(std::span<const double>)>;

namespace detail {

/// What NLopt calls: maps its coordinates to values, and remembers the best.
class TuningSearch {
 public:
  TuningSearch(std::span<const TunedParameter> parameters, const TuningCost& cost, int limit, nlopt_opt optimiser)
      : parameters_(parameters), cost_(&cost), limit_(limit), optimiser_(optimiser), values_(parameters.size()) {}

  TuningResult run(double least_gain) {
    std::vector<double> at;
    for (const TunedParameter& parameter : parameters_) at.push_back(parameter.to_search(parameter.start));
    (void)evaluate(at);  // by itself: bobyqa moves a start that lies close to a bound
    result_.start_cost = result_.cost;
    for (bool gains = !stopped_; gains && !stopped_;) {
      const double before = result_.cost;
      for (std::size_t i = 0; i < at.size(); ++i) {
        at[i] = std::clamp(parameters_[i].to_search(result_.found[i]), 0.0, 1.0);  // a logarithm rounds
      }
      double least = 0.0;
      ended_ = nlopt_optimize(optimiser_, at.data(), &least);
      gains = before - result_.cost > least_gain * std::abs(before);
    }
    if (thrown_) std::rethrow_exception(thrown_);
    if (!stopped_) end();
    return std::move(result_);
  }

  static double evaluate(unsigned n, const double* search, double* /*gradient*/, void* self) noexcept {
    return static_cast<TuningSearch*>(self)->evaluate(std::span(search, n));
  }

 private:
  /// The place within [0, 1] that a coordinate of an unbounded search means: 1.2 is 0.8, -0.3 is 0.3.
  static double reflect(double s) { return std::abs(s - 2.0 * std::round(0.5 * s)); }

  double evaluate(std::span<const double> search) noexcept {
    if (stopped_) return 0.0;
    try {
      for (std::size_t i = 0; i < search.size(); ++i) values_[i] = parameters_[i].from_search(reflect(search[i]));
      return remember((*cost_)(values_));
    } catch (...) {
      thrown_ = std::current_exception();
    }
    return stop();
  }

  double remember(double cost) {
    ++result_.evaluations;
    if (!std::isfinite(cost)) {
      result_.stop = TuningStop::cost_not_finite;
      result_.problem = "the cost is not finite at";
      for (std::size_t i = 0; i < values_.size(); ++i) {
        char value[32];
        std::snprintf(value, sizeof value, " %.6g", values_[i]);
        result_.problem += (i == 0 ? " " : ", ") + parameters_[i].name + value;
      }
      return stop();
    }
    if (result_.found.empty() || cost < result_.cost) {
      result_.found = values_;
      result_.cost = cost;
    }
    if (result_.evaluations < limit_) return cost;
    result_.stop = TuningStop::evaluations;
    return stop();
  }

  void end() {
    if (ended_ > 0) {
      result_.stop = TuningStop::converged;
    } else if (ended_ == NLOPT_ROUNDOFF_LIMITED) {
      result_.stop = TuningStop::stuck;
    } else {
      const char* said = nlopt_get_errmsg(optimiser_);
      result_.stop = TuningStop::failed;
      result_.problem = said != nullptr ? said : nlopt_result_to_string(ended_);
    }
  }

  double stop() {
    stopped_ = true;
    nlopt_force_stop(optimiser_);
    return 0.0;
  }

  std::span<const TunedParameter> parameters_;
  const TuningCost* cost_;
  int limit_;
  nlopt_opt optimiser_;
  std::vector<double> values_;
  TuningResult result_;
  std::exception_ptr thrown_;
  bool stopped_ = false;
  nlopt_result ended_ = NLOPT_FAILURE;
};

[[nodiscard]] inline std::string tuning_problem(std::span<const TunedParameter> parameters, const TuningCost& cost,
                                                const TuningSettings& settings) {
  if (parameters.empty()) return "there is no parameter to tune";
  for (const TunedParameter& parameter : parameters) {
    if (const auto problem = parameter.problem()) return parameter.name + ": " + std::string(*problem);
  }
  if (!cost) return "there is no cost function";
  if (settings.max_evaluations < 1) return "max_evaluations is below 1";
  if (!(settings.first_step > 0.0 && settings.first_step <= 0.5)) return "first_step is not within (0, 0.5]";
  if (!(settings.tolerance > 0.0 && settings.tolerance < 1.0)) return "tolerance is not within (0, 1)";
  if (!(settings.least_gain > 0.0 && settings.least_gain < 1.0)) return "least_gain is not within (0, 1)";
  if (settings.method == TuningMethod::bobyqa && parameters.size() == 1) return "bobyqa needs two parameters or more";
  return "";
}

}  // namespace detail

[[nodiscard]] inline TuningResult tune(std::span<const TunedParameter> parameters, const TuningCost& cost,
                                       const TuningSettings& settings = {}) {
  TuningResult refused;
  refused.problem = detail::tuning_problem(parameters, cost, settings);
  if (!refused.problem.empty()) return refused;

  const bool bounded = settings.method == TuningMethod::bobyqa;
  const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> optimiser(
      nlopt_create(bounded ? NLOPT_LN_BOBYQA : NLOPT_LN_PRAXIS, static_cast<unsigned>(parameters.size())),
      nlopt_destroy);
  if (!optimiser) throw std::bad_alloc();
  detail::TuningSearch search(parameters, cost, settings.max_evaluations, optimiser.get());
  nlopt_set_min_objective(optimiser.get(), detail::TuningSearch::evaluate, &search);
  nlopt_set_initial_step1(optimiser.get(), settings.first_step);
  nlopt_set_xtol_abs1(optimiser.get(), settings.tolerance);
  if (bounded) {
    nlopt_set_lower_bounds1(optimiser.get(), 0.0);
    nlopt_set_upper_bounds1(optimiser.get(), 1.0);
  } else {
    nlopt_srand(1);  // praxis draws random directions
  }
  return search.run(settings.least_gain);
}

}  // namespace holdfast
