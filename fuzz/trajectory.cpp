// Any bytes must give either an InputError or samples that keep the reader's promises, in both modes; nothing else may
// escape.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <holdfast/io/trajectory.hpp>

using namespace holdfast;

namespace {

void require(bool kept) {
  if (!kept) std::abort();
}

void check_promises(const io::TrajectoryFile& file, io::ReadMode mode) {
  const io::TrajectoryReport& report = file.report;
  require(file.samples.size() >= 2);
  require(report.poses == file.samples.size());
  require(report.rows == report.poses + report.occlusions + report.dropped_rows());
  if (mode == io::ReadMode::strict) require(report.dropped_rows() == 0);
  for (std::size_t i = 0; i < file.samples.size(); ++i) {
    const TimedPose& sample = file.samples[i];
    require(sample.X_WB.is_finite());
    require(std::abs(sample.X_WB.q().norm() - 1.0) < 1e-9);
    if (i > 0) require(sample.t > file.samples[i - 1].t);
  }
  require(!io::describe(report).empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  for (const io::ReadMode mode : {io::ReadMode::strict, io::ReadMode::lenient}) {
    try {
      const io::TrajectoryFile file = io::parse_trajectory(text, "fuzz", mode);
      check_promises(file, mode);
      if (mode == io::ReadMode::strict) {  // what was read is read back the same after writing
        const io::TrajectoryFile again = io::parse_trajectory(io::tum_text(file.samples), "again", mode);
        require(again.samples.size() == file.samples.size());
        for (std::size_t i = 0; i < again.samples.size(); ++i) require(again.samples[i].t == file.samples[i].t);
      }
    } catch (const io::InputError& error) {
      require(std::string_view(error.what()).starts_with("fuzz"));
    }
  }
  return 0;
}
