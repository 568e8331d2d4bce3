// Searches for the parameters that cost least: known minima, bounds, bad input, and a filter whose best gain is known.
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>

#include <doctest/doctest.h>

#include <holdfast/calibration/filter_tuning.hpp>

using namespace holdfast;

namespace {

constexpr TuningMethod methods[]{TuningMethod::bobyqa, TuningMethod::praxis};

std::vector<TunedParameter> decades(std::size_t count) {
  return std::vector<TunedParameter>(count, {"intensity", "m^2/s^3", 1.0, 1e-3, 1e3, SearchScale::logarithmic});
}

/// Rosenbrock's valley in the logarithms to base ten; least, 0, at `minimum`.
TuningCost valley(double minimum) {
  return [minimum](std::span<const double> values) {
    const double x = std::log10(values[0] / minimum) + 1.0, y = std::log10(values[1] / minimum) + 1.0;
    return std::pow(1.0 - x, 2) + 100.0 * std::pow(y - x * x, 2);
  };
}

/// Steady state of a scalar Kalman filter that follows a random walk: the gain k of a process noise q per step and a
/// measurement noise r. From p = (1 - k) (p + q) and k = (p + q) / (p + q + r): k^2 = (1 - k) q / r.
double steady_gain(double q_over_r) {
  return 0.5 * (std::sqrt(q_over_r * (q_over_r + 4.0)) - q_over_r);
}

/// Mean squared error of a random walk (steps of variance q, measured with variance r) followed with a constant gain.
/// e' = (1 - k) (e - step) + k noise: in the steady state p = ((1 - k)^2 q + k^2 r) / (1 - (1 - k)^2).
double squared_error(double k, double q, double r) {
  const double rest = (1.0 - k) * (1.0 - k);
  return (rest * q + k * k * r) / (1.0 - rest);
}

/// The same by running the filter, tuned to `q_over_r`, over a walk of q and r.
double squared_error_of_run(double q_over_r, double q, double r) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  double x = 0.0, estimate = 0.0, p = 0.0, sum = 0.0;
  constexpr int steps = 20000;
  for (int i = 0; i < steps; ++i) {
    x += std::sqrt(q) * normal(random);
    const double z = x + std::sqrt(r) * normal(random);
    p += q_over_r;
    const double k = p / (p + 1.0);
    estimate += k * (z - estimate);
    p *= 1.0 - k;
    sum += (estimate - x) * (estimate - x);
  }
  return sum / steps;
}

}  // namespace

TEST_CASE("search coordinates: 0 and 1 at the bounds, and back again") {
  const TunedParameter decade{"mu", "", 1.0, 1e-3, 1e3, SearchScale::logarithmic};
  CHECK(decade.to_search(1.0) == doctest::Approx(0.5));
  CHECK(decade.to_search(1e-3) == doctest::Approx(0.0));
  const TunedParameter bias{"bias", "m", 0.0, -2.0, 6.0, SearchScale::linear};
  CHECK(bias.to_search(0.0) == doctest::Approx(0.25));
  for (const TunedParameter& parameter : {decade, bias}) {
    for (const double s : {0.0, 0.1, 0.5, 1.0}) {
      CHECK(parameter.to_search(parameter.from_search(s)) == doctest::Approx(s).epsilon(1e-12));
    }
    CHECK(parameter.from_search(-1e-9) == parameter.lower);
    CHECK(parameter.from_search(1.0 + 1e-9) == parameter.upper);
  }
}

TEST_CASE("a curved valley is followed to its end, over decades") {
  for (const TuningMethod method : methods) {
    const TuningResult tuned =
        tune(decades(2), valley(30.0), {.method = method, .max_evaluations = 2000, .tolerance = 1e-7});
    CAPTURE(std::string(describe(tuned.stop)));
    CHECK(tuned.ok());
    CHECK(tuned.problem.empty());
    // Within a tolerance of 1e-7 of six decades; along the valley's floor the cost changes by the square of that.
    CHECK(tuned.found[0] == doctest::Approx(30.0).epsilon(1e-3));
    CHECK(tuned.found[1] == doctest::Approx(30.0).epsilon(1e-3));
    CHECK(tuned.cost < 1e-6);
    CHECK(tuned.start_cost == doctest::Approx(valley(30.0)(std::vector<double>{1.0, 1.0})));
  }
}

TEST_CASE("the best of what was tried, no more evaluations than allowed, the same each time") {
  for (const TuningMethod method : methods) {
    for (const int limit : {1, 2, 5, 40}) {
      const auto run = [&] {
        int asked = 0;
        double least = std::numeric_limits<double>::infinity();
        const TuningResult tuned = tune(decades(3),
                                        [&](std::span<const double> values) {
                                          ++asked;
                                          double cost = 0.0;
                                          for (const double value : values) cost += std::abs(std::log(value / 17.0));
                                          least = std::min(least, cost);
                                          return cost;
                                        },
                                        {.method = method, .max_evaluations = limit, .tolerance = 1e-9});
        CHECK(tuned.stop == TuningStop::evaluations);
        CHECK(tuned.evaluations == asked);
        CHECK(asked <= limit);
        CHECK(tuned.cost == least);
        return tuned;
      };
      const TuningResult first = run(), again = run();
      CHECK(first.found == again.found);
      CHECK(first.cost == again.cost);
    }
  }
}

TEST_CASE("bounds hold, also when the minimum lies beyond them or the start on them") {
  for (const TuningMethod method : methods) {
    for (const double start : {1e-3, 1.0, 1e3}) {
      std::vector<TunedParameter> parameters = decades(2);
      for (TunedParameter& parameter : parameters) parameter.start = start;
      parameters.push_back({"bias", "m", 0.25, -1.0, 1.0, SearchScale::linear});
      bool within = true;
      const TuningResult tuned =
          tune(parameters,
               [&](std::span<const double> values) {
                 for (std::size_t i = 0; i < 3; ++i) {
                   within = within && values[i] >= parameters[i].lower && values[i] <= parameters[i].upper;
                 }
                 const double beyond = std::log10(values[0]) - 5.0;  // least at 1e5
                 const double x = std::log10(values[1]) - 1.0, y = values[2] + 0.5;
                 return beyond * beyond + x * x + y * y;
               },
               {.method = method, .max_evaluations = 1000, .tolerance = 1e-6});
      CAPTURE(start);
      CAPTURE(std::string(describe(tuned.stop)));
      CHECK(tuned.ok());
      CHECK(within);
      // A thousand times the search's tolerance, for how differently the two methods end.
      CHECK(std::log10(tuned.found[0]) == doctest::Approx(3.0).epsilon(2e-3));
      CHECK(tuned.found[1] == doctest::Approx(10.0).epsilon(1e-2));
      CHECK(tuned.found[2] == doctest::Approx(-0.5).epsilon(1e-2));
    }
  }
}

TEST_CASE("a scalar Kalman filter is tuned to its walk") {
  const double q = 0.04, r = 2.0;
  // The closed form is least where Kalman's steady gain is.
  for (const double ratio : {q / r, 0.5}) {
    const double k = steady_gain(ratio);
    CHECK(squared_error(k, ratio, 1.0) < squared_error(1.01 * k, ratio, 1.0));
    CHECK(squared_error(k, ratio, 1.0) < squared_error(0.99 * k, ratio, 1.0));
  }
  const std::vector<TunedParameter> one{{"q / r", "", 1.0, 1e-5, 1e3, SearchScale::logarithmic}};
  const TuningResult exact =
      tune(one, [&](std::span<const double> values) { return squared_error(steady_gain(values[0]), q, r); },
           {.method = TuningMethod::praxis, .tolerance = 1e-6});
  CHECK(exact.ok());
  CHECK(exact.found[0] == doctest::Approx(q / r).epsilon(1e-2));  // the cost is flat there: its square is below 1e-4
  // And by running it: what is found differs by the sampling of 20,000 steps, some hundred of them independent.
  const TuningResult sampled =
      tune(one, [&](std::span<const double> values) { return squared_error_of_run(values[0], q, r); },
           {.method = TuningMethod::praxis, .max_evaluations = 100});
  CHECK(sampled.ok());
  CHECK(sampled.found[0] > 0.6 * q / r);
  CHECK(sampled.found[0] < 1.6 * q / r);
  CHECK(sampled.cost == doctest::Approx(squared_error(steady_gain(q / r), q, r)).epsilon(0.1));
  CHECK(sampled.cost < 0.5 * sampled.start_cost);
}

TEST_CASE("bad input is named") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const TuningCost cost = [](std::span<const double> values) { return values[0]; };
  const auto refused = [](const TuningResult& result, const std::string& expected) {
    CAPTURE(result.problem);
    CHECK(result.stop == TuningStop::bad_input);
    CHECK_FALSE(result.ok());
    CHECK(result.problem.find(expected) != std::string::npos);
    CHECK(result.evaluations == 0);
    CHECK(result.found.empty());
  };
  refused(tune({}, cost), "no parameter");
  refused(tune(decades(2), {}), "no cost");
  refused(tune(decades(1), cost), "two parameters");
  refused(tune(decades(2), cost, {.max_evaluations = 0}), "max_evaluations");
  for (const double step : {0.0, 0.6, nan}) refused(tune(decades(2), cost, {.first_step = step}), "first_step");
  for (const double tolerance : {0.0, 1.0, nan}) refused(tune(decades(2), cost, {.tolerance = tolerance}), "tolerance");
  for (const double gain : {0.0, 1.0, nan}) refused(tune(decades(2), cost, {.least_gain = gain}), "least_gain");
  const auto with = [&](double start, double lower, double upper) {
    std::vector<TunedParameter> parameters = decades(1);
    parameters.push_back({"second", "m", start, lower, upper, SearchScale::logarithmic});
    return tune(parameters, cost);
  };
  refused(with(0.5, 1.0, 2.0), "second: the start lies outside");
  refused(with(3.0, 1.0, 2.0), "outside");
  refused(with(1.0, 0.0, 2.0), "above zero");
  refused(with(1.0, 2.0, 1.0), "not below");
  refused(with(1.0, 1.0, 1.0), "not below");
  refused(with(nan, 1.0, 2.0), "not finite");
  refused(with(1.0, 1.0, inf), "not finite");
}

TEST_CASE("a cost that is not finite ends the search; the best until then is kept") {
  for (const TuningMethod method : methods) {
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity()}) {
      for (const int from : {1, 2, 9}) {
        int asked = 0;
        const TuningResult tuned = tune(
            decades(2), [&](std::span<const double> values) { return ++asked >= from ? bad : valley(5.0)(values); },
            {.method = method});
        CHECK(tuned.stop == TuningStop::cost_not_finite);
        CHECK(tuned.problem.find("intensity") != std::string::npos);
        CHECK(tuned.evaluations == from);
        CHECK(asked == from);
        CHECK(tuned.found.size() == (from == 1 ? 0U : 2U));
        CHECK(std::isfinite(tuned.cost));
      }
    }
  }
}

TEST_CASE("what the cost function throws passes on, and the next search is as the first") {
  for (const TuningMethod method : methods) {
    int asked = 0;
    const TuningCost cost = [&](std::span<const double> values) {
      if (++asked == 7) throw std::runtime_error("interrupted");
      return valley(2.0)(values);
    };
    CHECK_THROWS_WITH(static_cast<void>(tune(decades(2), cost, {.method = method})), "interrupted");
    CHECK(asked == 7);
    CHECK(tune(decades(2), cost, {.method = method}).ok());
  }
}
