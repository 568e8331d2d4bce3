/// Statistics of many error lengths: the one definition of mean, RMS, percentiles and peak that every table uses.
///
/// A percentile p is the value below which the part p of the sorted values lies, linear between neighbours: the default
/// of R and of NumPy (Hyndman & Fan 1996, type 7). Any unit. Bad input: no values give zeros, `count` says so.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace holdfast {

struct ErrorStatistics {
  std::size_t count = 0;
  double mean = 0.0, rms = 0.0, p50 = 0.0, p95 = 0.0, p99 = 0.0, peak = 0.0;
};

/// Value below which the part `p` (0 to 1) of sorted values lies. Precondition: sorted, not empty.
[[nodiscard]] inline double percentile_of_sorted(std::span<const double> sorted, double p) {
  const double place = std::clamp(p, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto i = static_cast<std::size_t>(place);
  if (i + 1 >= sorted.size()) return sorted.back();
  return sorted[i] + (place - static_cast<double>(i)) * (sorted[i + 1] - sorted[i]);
}

/// Statistics of error lengths (not negative); all zero when there are none.
[[nodiscard]] inline ErrorStatistics statistics_of(std::vector<double> lengths) {
  ErrorStatistics s;
  s.count = lengths.size();
  if (lengths.empty()) return s;
  std::sort(lengths.begin(), lengths.end());
  double sum = 0.0, squares = 0.0;
  for (const double x : lengths) {
    sum += x;
    squares += x * x;
  }
  const auto n = static_cast<double>(lengths.size());
  s.mean = sum / n;
  s.rms = std::sqrt(squares / n);
  s.p50 = percentile_of_sorted(lengths, 0.50);
  s.p95 = percentile_of_sorted(lengths, 0.95);
  s.p99 = percentile_of_sorted(lengths, 0.99);
  s.peak = lengths.back();
  return s;
}

}  // namespace holdfast
