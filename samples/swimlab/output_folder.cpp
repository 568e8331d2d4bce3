#include "output_folder.hpp"

#include <algorithm>
#include <string>
#include <system_error>

#include <unistd.h>

#include <holdfast/io/whole_file.hpp>

namespace swimlab {

namespace fs = std::filesystem;
using holdfast::io::InputError;

namespace {

[[noreturn]] void refuse(const fs::path& target, const std::string& problem, const std::string& expected,
                         const std::string& option = "--out") {
  throw InputError({.key = option, .problem = problem, .value = target.string(), .expected = expected});
}

/// The place that a link names; anything else as it is.
fs::path followed(const fs::path& path) {
  return fs::is_symlink(path) ? fs::weakly_canonical(path) : path;
}

/// Name of the first thing in the folder that the command does not write; empty when all is ours.
std::string stranger_in(const fs::path& folder, const OutputKind& kind) {
  bool empty = true, summary = false;
  for (const auto& entry : fs::directory_iterator(folder)) {
    empty = false;
    const std::string name = entry.path().filename().string();
    if (kind.has_pictures && name == "pictures" && entry.is_directory()) {
      for (const auto& picture : fs::directory_iterator(entry.path())) {
        if (picture.path().extension() != ".png") return "pictures/" + picture.path().filename().string();
      }
      continue;
    }
    if (!entry.is_regular_file()) return name;
    if (name == kind.summary) {
      summary = holdfast::io::read_whole_file(entry.path()).find(kind.schema) != std::string::npos;
    } else if (std::find(kind.files.begin(), kind.files.end(), name) == kind.files.end()) {
      return name;
    }
  }
  return empty || summary ? "" : "no " + kind.summary + " of " + kind.command;
}

}  // namespace

fs::path checked_json_file(const fs::path& file) {
  if (file.empty()) return file;
  const std::string expected = "a new or ordinary file in a writable folder";
  try {
    const fs::path place = followed(fs::absolute(file));
    const fs::file_status status = fs::status(place);
    if (fs::is_directory(status)) refuse(file, "is a folder", expected, "--json");
    if (fs::exists(status) && !fs::is_regular_file(status)) refuse(file, "is a device or a pipe", expected, "--json");
    if (fs::is_symlink(place)) refuse(file, "is a link that leads nowhere", expected, "--json");
    if (!fs::is_directory(place.parent_path())) refuse(file, "lies in no folder that exists", expected, "--json");
    if (access(place.parent_path().c_str(), W_OK) != 0) refuse(file, "cannot be written", expected, "--json");
    return place;
  } catch (const fs::filesystem_error& error) {
    refuse(file, "cannot be written: " + error.code().message(), expected, "--json");
  }
}

OutputKind run_output() {
  return {.command = "swimlab run",
          .summary = "summary.json",
          .schema = "\"holdfast/run/1\"",
          .files = {"report.html", "rows.csv"},
          .has_pictures = true};
}

OutputFolder::OutputFolder(const fs::path& target, const OutputKind& kind) {
  const std::string expected = "a new folder, or one that " + kind.command + " wrote";
  if (target.empty()) refuse(target, "empty", expected);
  target_ = fs::absolute(target).lexically_normal();
  if (!target_.has_filename()) target_ = target_.parent_path();  // "report/" is "report"
  try {
    target_ = followed(target_);  // the folder that a link names is replaced, not the link
    if (fs::is_symlink(target_)) refuse(target, "is a link that leads nowhere", expected);
    if (target_ == target_.root_path() || target_ == fs::current_path()) {
      refuse(target, "cannot be replaced", expected);
    }
    if (fs::exists(target_)) {
      if (!fs::is_directory(target_)) refuse(target, "is a file", expected);
      const std::string stranger = stranger_in(target_, kind);
      if (!stranger.empty()) refuse(target, "holds other things (" + stranger + ") and is left as it is", expected);
    }
    fs::create_directories(target_.parent_path());
    unfinished_ = target_.parent_path() / (target_.filename().string() + ".unfinished-" + std::to_string(getpid()));
    fs::create_directories(kind.has_pictures ? unfinished_ / "pictures" : unfinished_);
  } catch (const fs::filesystem_error& error) {
    refuse(target, "cannot be written: " + error.code().message(), "a writable place");
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(unfinished_, ignored);
}

void OutputFolder::commit() {
  const fs::path old = fs::path(unfinished_).concat("-old");
  const bool replace = fs::exists(target_);
  std::error_code error;
  if (replace) fs::rename(target_, old, error);
  if (!error) fs::rename(unfinished_, target_, error);
  if (error) {
    std::error_code ignored;
    if (replace && !fs::exists(target_)) fs::rename(old, target_, ignored);
    refuse(target_, "cannot be written: " + error.message(), "a writable place");
  }
  committed_ = true;
  fs::remove_all(old, error);
}

}  // namespace swimlab
