#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <holdfast/tracking/innovation_gate.hpp>

using namespace holdfast;

TEST_CASE("chi-square: quantiles of the tables, closed forms of 2 and 4 degrees of freedom, both tails") {
  // Abramowitz and Stegun, table 26.8, to its digits.
  CHECK(chi_square_quantile(0.99, 1) == doctest::Approx(6.63490).epsilon(1e-6));
  CHECK(chi_square_quantile(0.99, 3) == doctest::Approx(11.3449).epsilon(1e-5));
  CHECK(chi_square_quantile(0.95, 6) == doctest::Approx(12.5916).epsilon(1e-5));
  CHECK(chi_square_quantile(0.005, 10) == doctest::Approx(2.15586).epsilon(1e-5));
  CHECK(chi_square_quantile(0.5, 100) == doctest::Approx(99.3341).epsilon(1e-6));
  for (const double p : {1e-12, 1e-3, 0.3, 0.5, 0.9, 0.99, 1.0 - 1e-9}) {
    CAPTURE(p);
    // 1 - p has lost digits already: the quantile can be no better than p's own rounding allows.
    CHECK(chi_square_quantile(p, 2) == doctest::Approx(-2.0 * std::log1p(-p)).epsilon(1e-9));
  }
  for (const double x : {1e-9, 0.1, 3.0, 6.0, 20.0, 200.0}) {
    const double half = 0.5 * x;
    const double above = std::exp(-half) * (1.0 + half);
    CHECK(chi_square_tails(x, 4).above == doctest::Approx(above).epsilon(1e-12));
    CHECK(chi_square_tails(x, 4).below + chi_square_tails(x, 4).above == doctest::Approx(1.0).epsilon(1e-14));
    CHECK(chi_square_tails(x, 1).below == doctest::Approx(std::erf(std::sqrt(half))).epsilon(1e-12));
  }
  for (const int k : {1, 2, 3, 7, 12, 100, 12000}) {
    for (const double p : {1e-6, 0.025, 0.5, 0.975, 0.999999}) {
      CAPTURE(k);
      CHECK(chi_square_tails(chi_square_quantile(p, k), k).below == doctest::Approx(p).epsilon(1e-9));
    }
  }
}

TEST_CASE("chi-square: the ends of the range, and what is none") {
  CHECK(chi_square_quantile(0.0, 3) == 0.0);
  CHECK(chi_square_quantile(1.0, 3) == std::numeric_limits<double>::infinity());
  CHECK(std::isnan(chi_square_quantile(-0.1, 3)));
  CHECK(std::isnan(chi_square_quantile(1.1, 3)));
  CHECK(std::isnan(chi_square_quantile(std::nan(""), 3)));
  CHECK(std::isnan(chi_square_quantile(0.5, 0)));
  CHECK(std::isnan(chi_square_tails(-1.0, 3).below));
  CHECK(chi_square_tails(std::numeric_limits<double>::infinity(), 3).above == 0.0);
}

namespace {

// A gate that has seen enough good measurements to be trusted.
InnovationGate proven_gate(const GateSettings& settings = {}) {
  InnovationGate gate(settings);
  for (int i = 0; i < settings.filter_probation; ++i) gate.judge(1.0, 2, nullptr);
  return gate;
}

}  // namespace

TEST_CASE("gate: the quantile decides") {
  InnovationGate gate;
  CHECK(gate.judge(9.21, 2, nullptr) == GateVerdict::accepted);  // 9.2103
  CHECK(gate.judge(9.2104, 2, nullptr) == GateVerdict::rejected);
  CHECK(gate.judge(6.63, 1, nullptr) == GateVerdict::accepted);
  CHECK(gate.judge(6.64, 1, nullptr) == GateVerdict::rejected);
  CHECK(gate.judge(37.5, 20, nullptr) == GateVerdict::accepted);  // 37.57: beyond the sizes kept ready
  CHECK(gate.judge(std::nan(""), 2, nullptr) == GateVerdict::rejected);
  GateSettings open;
  open.probability = 1.0;
  CHECK(InnovationGate(open).judge(1e300, 2, nullptr) == GateVerdict::accepted);
}

TEST_CASE("gate: near is what the window at its widest would take, whatever it is now") {
  InnovationGate gate({.probability = 0.99, .widest = 16.0});
  const double edge = 16.0 * chi_square_quantile(0.99, 2);
  for (int i = 0; i < 2; ++i) {
    CHECK(gate.is_near(0.999 * edge, 2));
    CHECK_FALSE(gate.is_near(1.001 * edge, 2));
    CHECK_FALSE(gate.is_near(std::nan(""), 2));
    for (int k = 0; k < 100; ++k) gate.judge(1e6, 2, nullptr);  // opens it
  }
  CHECK(InnovationGate({.probability = 1.0}).is_near(1e300, 2));
}

TEST_CASE("gate: a rejected device has to be consistent again before it counts") {
  InnovationGate gate = proven_gate();
  std::uint8_t device = 0;
  std::uint8_t other = 0;
  CHECK(gate.judge(100.0, 2, &device) == GateVerdict::rejected);
  CHECK(device == 1);
  CHECK(gate.judge(1.0, 2, &other) == GateVerdict::accepted);
  CHECK(gate.judge(100.0, 2, &device) == GateVerdict::rejected);
  CHECK(gate.judge(1.0, 2, &device) == GateVerdict::on_probation);
  CHECK(gate.judge(1.0, 2, &device) == GateVerdict::accepted);
  GateSettings strict;
  strict.device_probation = 3;
  gate = proven_gate(strict);
  gate.judge(100.0, 2, &device);
  for (int i = 0; i < 3; ++i) CHECK(gate.judge(1.0, 2, &device) == GateVerdict::on_probation);
  CHECK(gate.judge(1.0, 2, &device) == GateVerdict::accepted);
}

TEST_CASE("gate: devices on probation are not all silenced at once") {
  InnovationGate gate = proven_gate();
  std::uint8_t devices[20];
  for (std::uint8_t& device : devices) device = 1;
  int unused = 0;
  for (std::uint8_t& device : devices) unused += gate.judge(1.0, 2, &device) == GateVerdict::on_probation;
  CHECK(unused < 20);
  CHECK(gate.judge(1.0, 2, nullptr) == GateVerdict::accepted);
}

TEST_CASE("gate: opens when everything is rejected, blames no device for it, and closes again") {
  GateSettings settings;
  InnovationGate gate = proven_gate(settings);
  CHECK(gate.trusted());
  std::uint8_t devices[40] = {};
  int needed = 0;
  while (gate.judge(50.0, 2, &devices[needed]) == GateVerdict::rejected)
    REQUIRE(++needed < 40);  // 5.4 times the quantile
  CHECK(needed > settings.patience);
  CHECK_FALSE(gate.trusted());
  for (int i = settings.patience + 1; i < needed; ++i) CHECK(devices[i] == 0);
  int until_trusted = 0;
  while (!gate.trusted()) {
    CHECK(gate.judge(1.0, 2, nullptr) == GateVerdict::accepted);
    REQUIRE(++until_trusted < 40);
  }
  CHECK(gate.window() == 1.0);
  CHECK(until_trusted >= settings.filter_probation);
  CHECK(gate.judge(50.0, 2, nullptr) == GateVerdict::rejected);

  gate = proven_gate(settings);
  for (int i = 0; i < settings.lost_after; ++i) {
    CHECK_FALSE(gate.lost());
    gate.judge(1e6, 2, nullptr);  // what no window reaches
  }
  CHECK(gate.lost());
  CHECK(gate.window() == settings.widest);
}

TEST_CASE(
    "gate: lost is a filter that most speaks against, not only one that all does; not one with wrong names among "
    "good") {
  const GateSettings settings;
  const auto judged_until_lost = [&](int good_of_ten) {
    InnovationGate gate = proven_gate(settings);
    int judged = 0;
    for (; !gate.lost() && judged < 10000; ++judged) {
      gate.judge(judged % 10 < 10 - good_of_ten ? 1e6 : 1.0, 2, nullptr);
    }
    return judged;
  };
  CHECK(judged_until_lost(0) == settings.lost_after);
  CHECK(judged_until_lost(1) == settings.lost_after + settings.lost_after / 9);
  CHECK(judged_until_lost(8) == 10000);
  CHECK(judged_until_lost(5) == 10000);

  // Trusted again it is not lost, whatever was before.
  InnovationGate gate = proven_gate(settings);
  while (!gate.lost()) gate.judge(1e6, 2, nullptr);
  gate.judge(1.0, 2, nullptr);
  CHECK(gate.lost());
  while (!gate.trusted()) gate.judge(1.0, 2, nullptr);
  CHECK_FALSE(gate.lost());
}

TEST_CASE("gate: bad settings are named") {
  CHECK_FALSE(GateSettings().problem());
  GateSettings s;
  s.probability = 0.0;
  CHECK(s.problem());
  s = {};
  s.probability = std::nan("");
  CHECK(s.problem());
  s = {};
  s.widening = 0.5;
  CHECK(s.problem());
  s = {};
  s.patience = -1;
  CHECK(s.problem());
  s = {};
  s.device_probation = 300;
  CHECK(s.problem());
}
