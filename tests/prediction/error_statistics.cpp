#include <cmath>

#include <doctest/doctest.h>

#include <holdfast/prediction/error_statistics.hpp>

using namespace holdfast;

TEST_CASE("statistics of known numbers") {
  const ErrorStatistics s = statistics_of({4.0, 1.0, 3.0, 2.0, 5.0});
  CHECK(s.count == 5);
  CHECK(s.mean == 3.0);
  CHECK(s.rms == doctest::Approx(std::sqrt(11.0)));
  CHECK(s.p50 == 3.0);
  CHECK(s.p95 == doctest::Approx(4.8));
  CHECK(s.p99 == doctest::Approx(4.96));
  CHECK(s.peak == 5.0);
  CHECK(statistics_of({}).count == 0);
  CHECK(statistics_of({}).peak == 0.0);
  CHECK(statistics_of({7.0}).p95 == 7.0);
}

TEST_CASE("percentiles are linear between neighbours, as NumPy's") {
  std::vector<double> errors;
  for (int i = 100; i >= 1; --i) errors.push_back(i);
  const ErrorStatistics s = statistics_of(errors);
  CHECK(s.mean == doctest::Approx(50.5));
  CHECK(s.p95 == doctest::Approx(95.05));  // numpy.percentile(range(1, 101), 95)
  CHECK(s.p50 == doctest::Approx(50.5));
  CHECK(s.peak == 100.0);
}
