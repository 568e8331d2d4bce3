/// OSVR display descriptors (JSON, comments allowed) to and from HmdModel. See osvr_reader.hpp for what each key does.
///
/// A descriptor may be a whole one ({"hmd": {...}}) or OSVR's server or mesh file ({"display": {"hmd": {...}}}). Meshes
/// that it names are read from files in its own folder. Bad input: io::InputError with file, line, key and value.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/io/osvr_reader.hpp>
#include <holdfast/io/osvr_writer.hpp>
#include <holdfast/io/whole_file.hpp>

namespace holdfast::io {

/// Reads files of one folder; a missing one is refused by the place where it was looked for.
[[nodiscard]] inline BesideReader files_in(std::filesystem::path folder) {
  return [folder = std::move(folder)](std::string_view name) {
    const std::filesystem::path path = folder / name;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
      throw InputError({.file = path.string(),
                        .problem = "the descriptor's distortion is in this file, which is not there",
                        .expected = "the file beside the descriptor"});
    }
    return NamedText{read_whole_file(path), path.string()};
  };
}

/// Reads a descriptor's text; `file` is only for messages.
[[nodiscard]] inline OsvrHmd parse_osvr(std::string_view text, std::string file, const BesideReader& beside,
                                        const OsvrAssumptions& assumed = {}) {
  const JsonDocument document = JsonDocument::parse(text, std::move(file));
  return osvr_of(document.root(), document.file(), beside, assumed);
}

[[nodiscard]] inline OsvrHmd read_osvr(const std::filesystem::path& path, const OsvrAssumptions& assumed = {}) {
  return parse_osvr(read_whole_file(path), path.string(), files_in(path.parent_path()), assumed);
}

/// Writes what OSVR can say of the headset and answers what was left out.
inline std::vector<std::string> write_osvr(const std::filesystem::path& path, const HmdModel& hmd,
                                           OsvrDisplayMode mode = OsvrDisplayMode::side_by_side) {
  OsvrText written = osvr_json(hmd, mode);
  write_whole_file(path, written.text);
  return std::move(written.left_out);
}

}  // namespace holdfast::io
