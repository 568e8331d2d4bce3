#include "track_command.hpp"

namespace swimlab {

void add_track_command(CLI::App& app, int& exit_code) {
  CLI::App& track_app = *app.add_subcommand("track", "Judge trackers: SCAAT and its rivals");
  track_app.require_subcommand(1);
  track_app.footer(
      "Examples:\n  swimlab track hiball --trajectory head.tum --json track.json\n"
      "  swimlab track ranges --ranges range.csv --anchors anchors.csv --imu imu.csv --truth pose.csv\n"
      "  swimlab track constellation --motion swing\n"
      "  swimlab track tune --trajectory walk.tum --methods scaat_autocal");
  add_track_hiball_command(track_app, exit_code);
  add_track_ranges_command(track_app, exit_code);
  add_track_constellation_command(track_app, exit_code);
#ifdef SWIMLAB_TUNES
  add_track_tune_command(track_app, exit_code);
#endif
}

}  // namespace swimlab
