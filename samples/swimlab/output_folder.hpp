/// The folder a run writes: made beside its place and moved there when it is complete, so that half a report never
/// looks whole. A folder that holds other things than a report of ours is not touched.
#pragma once

#include <filesystem>

namespace swimlab {

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
