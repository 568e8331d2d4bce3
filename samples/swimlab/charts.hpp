/// The report's charts as JSON: what report.js draws with dygraphs.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <holdfast/io/results.hpp>
#include <holdfast/motion/motion.hpp>

#include "row_runner.hpp"

namespace swimlab {

/// A number with four significant digits, or null: charts need no more, and a page of 10,000 frames stays small.
[[nodiscard]] holdfast::io::ResultJson rounded(std::optional<double> value);

/// "P4", or "P4 shift" when it deflects in another way than its own.
[[nodiscard]] std::string variant_name(holdfast::Pipeline pipeline, holdfast::DeflectionKind deflection);
[[nodiscard]] std::string variant_name(const holdfast::ExperimentRow& row);
/// "P4, late rotation", or "P4 shift".
[[nodiscard]] std::string variant_title(const holdfast::ExperimentRow& row);

/// One series of a time chart: a row's samples.
struct TimeSeries {
  holdfast::Pipeline pipeline;
  std::string name;  ///< variant_name
  std::span<const FrameSample> samples;
};

/// Registration error, and swim velocity, against time; all series share their frames.
[[nodiscard]] holdfast::io::ResultJson error_chart(const std::vector<TimeSeries>& series);
[[nodiscard]] holdfast::io::ResultJson swim_chart(const std::vector<TimeSeries>& series);

/// RMS registration error against latency (001's figure 7) of each variant, experiments without pictures.
[[nodiscard]] holdfast::io::ResultJson latency_chart(const holdfast::Motion& motion,
                                                     std::span<const holdfast::ExperimentSettings> variants,
                                                     const holdfast::RegistrationScene& scene);

/// Gain and lag of the displayed against the true motion, per frequency, beside theory's curves. Variants that predict
/// alike, over the same time, share their curves.
[[nodiscard]] std::vector<holdfast::io::ResultJson> frequency_charts(
    std::span<const holdfast::ExperimentSettings> variants);

/// Error of each source alone, stacked, against latency.
[[nodiscard]] holdfast::io::ResultJson budget_chart(const holdfast::Motion& motion,
                                                    const holdfast::ExperimentSettings& settings,
                                                    const holdfast::RegistrationScene& scene);

/// Name and style of a variant's line. P6 is dashed: it may lie on P5's.
[[nodiscard]] holdfast::io::ResultJson variant_series(holdfast::Pipeline pipeline, const std::string& name);

}  // namespace swimlab
