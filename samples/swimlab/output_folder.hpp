/// The folder a run writes: made beside its place and moved there when it is complete, so that half a report never
/// looks whole. A folder that holds other things than a report of ours is not touched.
#pragma once

#include <filesystem>

namespace swimlab {

/// Where --json is to be written, checked before the work: a new or an ordinary file, in a writable folder. Links are
/// followed, and a device or a pipe is refused, for a file is put in place by renaming, which would replace it. Empty
/// stays empty. Throws io::InputError.
[[nodiscard]] std::filesystem::path checked_json_file(const std::filesystem::path& file);

class OutputFolder {
 public:
  /// Throws io::InputError (option --out) when `target` cannot be written or is not ours to replace.
  explicit OutputFolder(const std::filesystem::path& target);
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
