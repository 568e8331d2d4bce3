/// Whole files, text or bytes: read in one go, written so that a file is never left behind half written.
///
/// Read are files, and the pipes that a shell hands over: /dev/stdin, or /dev/fd/63 for <(command). A named pipe would
/// wait for a writer for ever, a device may never end: both are refused. Bad input: a path that cannot be read or
/// written is an InputError that says so.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include <holdfast/io/input_error.hpp>

namespace holdfast::io {

namespace detail {

/// A name by which a program reaches what it was started with.
[[nodiscard]] inline bool is_own_descriptor(const std::filesystem::path& path) {
  const std::string name = path.lexically_normal().string();
  return name == "/dev/stdin" || name.starts_with("/dev/fd/") || name.starts_with("/proc/self/fd/");
}

/// Refuses what has no end of its own.
inline void check_is_readable_file(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  const bool is_pipe = std::filesystem::is_fifo(status);
  if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status)) return;
  if (is_pipe && is_own_descriptor(path)) return;
  throw InputError({.file = path.string(),
                    .problem = std::filesystem::is_directory(status) ? "is a folder"
                               : is_pipe                             ? "is a named pipe, which may never be filled"
                                                                     : "is a device, no file",
                    .expected = "a file, or a shell's pipe: /dev/stdin, <(command)"});
}

}  // namespace detail

[[nodiscard]] inline std::string read_whole_file(const std::filesystem::path& path) {
  detail::check_is_readable_file(path);
  std::error_code error;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError({.file = path.string(), .problem = "cannot be opened", .expected = "a readable file"});
  std::string text;
  const auto size = std::filesystem::file_size(path, error);
  if (!error && size < (std::uintmax_t(1) << 40)) text.reserve(static_cast<std::size_t>(size));
  std::string block(std::size_t(1) << 16, '\0');
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad())
    throw InputError({.file = path.string(), .problem = "cannot be read to its end", .expected = "a readable file"});
  return text;
}

/// Writes beside the place and renames: readers see the old file or the whole new one. A link is followed. What is no
/// file (a folder, a device, a pipe) is refused: renaming onto it would replace it.
inline void write_whole_file(const std::filesystem::path& path, std::string_view bytes) {
  std::error_code error;
  const std::filesystem::path target =
      std::filesystem::is_symlink(path, error) ? std::filesystem::weakly_canonical(path, error) : path;
  const std::filesystem::file_status status = std::filesystem::status(target, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    throw InputError({.file = path.string(), .problem = "is no file", .expected = "a file, or a place for a new one"});
  }
  std::filesystem::path unfinished = target;
  unfinished += ".unfinished";
  {
    std::ofstream file(unfinished, std::ios::binary | std::ios::trunc);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) {
      std::filesystem::remove(unfinished, error);
      throw InputError(
          {.file = path.string(), .problem = "cannot be written", .expected = "a writable place with room"});
    }
  }
  std::filesystem::rename(unfinished, target, error);
  if (!error) return;
  const std::string reason = error.message();
  std::filesystem::remove(unfinished, error);
  throw InputError({.file = path.string(), .problem = "cannot be written: " + reason, .expected = "a writable place"});
}

}  // namespace holdfast::io
