/// The folder a command writes: made beside its place and moved there when it is complete, so that half a report never
/// looks whole. A folder that holds other things than the same command's is not touched.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace swimlab {

/// Where --json is to be written, checked before the work: a new or an ordinary file, in a writable folder. Links are
/// followed, and a device or a pipe is refused, for a file is put in place by renaming, which would replace it. Empty
/// stays empty. Throws io::InputError.
[[nodiscard]] std::filesystem::path checked_json_file(const std::filesystem::path& file);

/// What a command writes into its folder, by which that folder is known.
struct OutputKind {
  std::string command;             ///< for messages
  std::string summary, schema;     ///< the file that is always there, and a word that it holds
  std::vector<std::string> files;  ///< the others
  bool has_pictures = false;       ///< a folder pictures/ with PNG files
};

/// The report of swimlab run.
[[nodiscard]] OutputKind run_output();

class OutputFolder {
 public:
  /// Throws io::InputError (option --out) when `target` cannot be written or is not ours to replace.
  explicit OutputFolder(const std::filesystem::path& target, const OutputKind& kind = run_output());
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();  ///< removes what was not committed

  [[nodiscard]] const std::filesystem::path& path() const { return unfinished_; }
  [[nodiscard]] const std::filesystem::path& target() const { return target_; }
  void commit();

 private:
  std::filesystem::path target_, unfinished_;
  bool committed_ = false;
};

}  // namespace swimlab
