/// swimlab: how far virtual things slide against real ones because of latency. See docs/swimlab.md.
#include <cstdio>
#include <exception>
#include <string>

#include <holdfast/io/input_error.hpp>
#include <holdfast/rendering/gl_error.hpp>

#include "calibrate_command.hpp"
#include "exit_code.hpp"
#include "interruption.hpp"
#include "lens_command.hpp"
#include "options.hpp"
#include "track_command.hpp"

namespace {

/// The command as it was typed, words with blanks quoted.
std::string command_line(int argc, char** argv) {
  std::string text = "swimlab";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain = !word.empty() && word.find_first_of(" \t\"'$&;|<>()*?\\") == std::string::npos;
    text += ' ' + (plain ? word : '\'' + word + '\'');
  }
  return text;
}

int complain(const std::string& what) {
  std::fprintf(stderr, "swimlab: %s\n", what.c_str());
  return swimlab::wrong_use;
}

}  // namespace

int main(int argc, char** argv) {
  int exit_code = swimlab::done;
  CLI::App app{"Measures swim: how far and how fast virtual things slide against real ones in a headset."};
  app.name("swimlab");
  app.require_subcommand(1);
  app.set_version_flag("--version", "swimlab " HOLDFAST_VERSION);
  app.footer("Example:\n  swimlab run --motion M1 --out out/report     then open out/report/report.html");
  swimlab::add_run_command(app, command_line(argc, argv), exit_code);
  swimlab::add_predict_command(app, command_line(argc, argv), exit_code);
  swimlab::add_latency_command(app, exit_code);
  swimlab::add_lens_command(app, exit_code);
  swimlab::add_track_command(app, exit_code);
  swimlab::add_calibrate_command(app, exit_code);
  try {
    app.parse(argc, argv);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) return complain("standard output cannot be written");
    return exit_code;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    if (argc > 1 && argv[1][0] != '-' && app.get_subcommands().empty()) {
      return complain("unknown command '" + std::string(argv[1]) +
                      "'; expected run, predict, latency, lens, track or calibrate");
    }
    complain(error.what());
    std::fprintf(stderr, "Try: swimlab %s--help\n",
                 app.get_subcommands().empty() ? "" : (app.get_subcommands().front()->get_name() + " ").c_str());
    return swimlab::wrong_use;
  } catch (const swimlab::Interrupted& error) {
    complain(error.what());
    return error.exit_code();
  } catch (const holdfast::io::InputError& error) {
    return complain(error.what());
  } catch (const holdfast::rendering::RenderingError& error) {
    return complain(std::string("OpenGL: ") + error.what());
  } catch (const std::exception& error) {
    return complain(error.what());
  }
}
