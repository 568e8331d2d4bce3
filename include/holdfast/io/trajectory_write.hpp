/// Writes a motion as a TUM file: `t tx ty tz qx qy qz qw`, seconds with nine decimals, shortest numbers that read back
/// the same.
///
/// The file appears complete or not at all: it is written beside its place and then renamed. Locale-independent.
/// Bad input: a path that cannot be written is an InputError.
#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>

#include <holdfast/io/whole_file.hpp>
#include <holdfast/motion/timed_pose.hpp>

namespace holdfast::io {

namespace detail {

inline void append_number(std::string& text, double value) {
  std::array<char, 32> digits{};
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc()) text.append(digits.data(), end);
}

inline void append_seconds(std::string& text, Duration d) {
  constexpr std::int64_t second = 1'000'000'000;
  const std::int64_t whole = d.count() / second, rest = std::abs(d.count() % second);
  if (d.count() < 0 && whole == 0) text += '-';
  std::string fraction = std::to_string(rest);
  fraction.insert(0, 9 - fraction.size(), '0');
  text += std::to_string(whole) + '.' + fraction;
}

}  // namespace detail

[[nodiscard]] inline std::string tum_text(std::span<const TimedPose> samples) {
  std::string text = "# timestamp(s) tx ty tz qx qy qz qw\n";
  text.reserve(samples.size() * 150);
  for (const TimedPose& sample : samples) {
    detail::append_seconds(text, sample.t.time_since_epoch());
    const Vector3& p = sample.X_WB.p();
    const Quaternion& q = sample.X_WB.q();
    for (const double value : {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}) {
      text += ' ';
      detail::append_number(text, value);
    }
    text += '\n';
  }
  return text;
}

inline void write_tum(const std::filesystem::path& path, std::span<const TimedPose> samples) {
  write_whole_file(path, tum_text(samples));
}

}  // namespace holdfast::io
