#include "track_command.hpp"

namespace swimlab {

void add_track_command(CLI::App& app, int& exit_code) {
  CLI::App& track_app = *app.add_subcommand("track", "Judge trackers: SCAAT and its rivals");
  track_app.require_subcommand(1);
  track_app.footer("Example:\n  swimlab track hiball --trajectory head.tum --json track.json");
  add_track_hiball_command(track_app, exit_code);
}

}  // namespace swimlab
