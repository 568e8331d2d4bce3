/// What readers of files and options throw when input is bad: it names the place and says what was expected.
///
/// what() is complete and made for people:
///     FILE:LINE: KEY: PROBLEM (found 'VALUE'); expected EXPECTED
/// Parts that are empty (or line 0) are left out. The command prints it and exits with code 2.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace holdfast::io {

/// The parts of the message; name those that are known.
struct InputProblem {
  std::string file = {};      ///< path as the caller gave it; empty for an option of the command line
  std::size_t line = 0;       ///< 1 is the first line; 0 when a line makes no sense
  std::string key = {};       ///< column, JSON path or option name
  std::string problem = {};   ///< what is wrong, e.g. "not a number"
  std::string value = {};     ///< the offending text
  std::string expected = {};  ///< what would have been right
};

class InputError : public std::runtime_error {
 public:
  explicit InputError(InputProblem problem) : std::runtime_error(message(problem)), problem_(std::move(problem)) {}

  [[nodiscard]] const std::string& file() const { return problem_.file; }
  [[nodiscard]] std::size_t line() const { return problem_.line; }
  [[nodiscard]] const std::string& key() const { return problem_.key; }
  [[nodiscard]] const std::string& problem() const { return problem_.problem; }
  [[nodiscard]] const std::string& value() const { return problem_.value; }
  [[nodiscard]] const std::string& expected() const { return problem_.expected; }

 private:
  [[nodiscard]] static std::string message(const InputProblem& p) {
    std::string text = p.file;
    if (p.line != 0) text += (text.empty() ? "line " : ":") + std::to_string(p.line);
    if (!text.empty()) text += ": ";
    if (!p.key.empty()) text += p.key + ": ";
    text += p.problem;
    if (!p.value.empty()) text += " (found '" + shortened(p.value) + "')";
    if (!p.expected.empty()) text += "; expected " + p.expected;
    return text;
  }

  /// Keeps a message readable, and a terminal unharmed, whatever bytes the input holds.
  [[nodiscard]] static std::string shortened(std::string_view value) {
    constexpr std::size_t longest = 60;
    std::string text(value.substr(0, longest));
    for (char& c : text) {
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    }
    if (value.size() > longest) text += "...";
    return text;
  }

  InputProblem problem_;
};

}  // namespace holdfast::io
