/// swimlab latency: effective latency and errors of one recording against another.
#include <cmath>
#include <cstdio>

#include <holdfast/io/input_error.hpp>
#include <holdfast/io/results.hpp>
#include <holdfast/io/trajectory.hpp>
#include <holdfast/registration/effective_latency.hpp>

#include "exit_code.hpp"
#include "options.hpp"
#include "output_folder.hpp"

namespace swimlab {

using namespace holdfast;

namespace {

std::vector<TimedPose> samples_of(const std::filesystem::path& file, bool lenient) {
  io::TrajectoryFile recording = io::read_trajectory(file, lenient ? io::ReadMode::lenient : io::ReadMode::strict);
  std::printf("%s: %s", file.string().c_str(), io::describe(recording.report).c_str());
  return std::move(recording.samples);
}

[[noreturn]] void refuse(const std::filesystem::path& observed, const std::string& problem) {
  throw io::InputError({.file = observed.string(),
                        .problem = "no latency can be told: " + problem,
                        .expected = "two recordings of one motion on one clock"});
}

void print_in_words(const LatencyResult& r, FrameRelation frames) {
  if (frames == FrameRelation::rigid && r.status == LatencyStatus::ok) {
    std::printf(
        "\nThe two recordings need not share a world or a body: the rigid transforms between them were estimated\n"
        "together with the latency, and the errors below are what remains after that alignment.\n");
    const Vector3& p = r.X_RO.p();
    std::printf("  world of OBSERVED in REFERENCE's: position %.4f %.4f %.4f m, turned by %.2f deg\n", p.x(), p.y(),
                p.z(), so3::log<double>(r.X_RO.q()).norm() * degrees_per_rad);
    std::printf("  bodies: %.1f mm apart, turned by %.2f deg\n", 1e3 * r.X_BoBr.p().norm(),
                so3::log<double>(r.X_BoBr.q()).norm() * degrees_per_rad);
  } else if (r.status == LatencyStatus::frames_undetermined) {
    std::printf("\nNote: %s.\n", std::string(describe(r.status)).c_str());
  } else {
    std::printf("\nThe poses were compared as they are, without alignment.\n");
  }
  std::printf("\neffective latency  %.2f ms +- %.2f (one standard deviation)%s\n", r.effective_latency_ms,
              r.uncertainty_ms, r.effective_latency_ms < 0.0 ? "; negative: OBSERVED leads" : "");
  std::printf("%-18s %9s %9s %9s %9s\n", "error", "mean", "RMS", "p95", "peak");
  std::printf("%-18s %9.3f %9.3f %9.3f %9.3f\n", "angle deg", r.angle_deg.mean, r.angle_deg.rms, r.angle_deg.p95,
              r.angle_deg.peak);
  std::printf("%-18s %9.2f %9.2f %9.2f %9.2f\n", "position mm", r.position_mm.mean, r.position_mm.rms,
              r.position_mm.p95, r.position_mm.peak);
  std::printf("without the shift in time: %.3f deg and %.2f mm RMS\n", r.unshifted_angle_deg_rms,
              r.unshifted_position_mm_rms);
  std::printf("%zu pairs over %.1f s\n", r.pairs, r.overlap_s);
}

}  // namespace

int latency(const LatencyCommandOptions& options) {
  const std::filesystem::path json_file = checked_json_file(options.json);
  const std::vector<TimedPose> reference = samples_of(options.reference, options.lenient);
  const std::vector<TimedPose> observed = samples_of(options.observed, options.lenient);
  if (reference.back().t < observed.front().t || observed.back().t < reference.front().t) {
    refuse(options.observed, "the recordings have no time in common");
  }
  LatencyOptions search;
  search.frames = options.same_frames ? FrameRelation::same : FrameRelation::rigid;
  const LatencyResult result = estimate_latency(reference, observed, search);
  if (!result.has_latency()) refuse(options.observed, std::string(describe(result.status)));
  // The best shift of recordings that do not belong together lies anywhere, often at an end of the search.
  const double longest_ms = 1e3 * to_seconds(search.longest);
  if (std::abs(result.effective_latency_ms) > 0.999 * longest_ms) {
    refuse(options.observed,
           "the best match lies at the end of the search, " + std::to_string(std::lround(longest_ms)) + " ms away");
  }
  print_in_words(result, search.frames);
  if (!json_file.empty()) {
    io::write_whole_file(json_file, io::json_text(io::latency_json(result, search.frames)));
  }
  return done;
}

}  // namespace swimlab
