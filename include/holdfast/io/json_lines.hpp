/// Where in a JSON text each key stands: from key path (eyes.left.tangents.right, coefficients[2]) to line.
///
/// A JSON library forgets the lines once it has parsed; messages about a value's meaning need them. The text must be
/// valid JSON (comments allowed): parse it first. Beyond `deepest` levels nothing is recorded and `too_deep` is set; a
/// key that stands twice in one object is reported in `duplicate`, as most parsers keep only the last, silently.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace holdfast::io {

struct JsonLines {
  std::map<std::string, std::size_t, std::less<>> line_of_path;  ///< the root's path is empty
  std::string duplicate;  ///< path of the first key that stands twice; empty: none
  std::size_t duplicate_line = 0;
  bool too_deep = false;
};

class JsonLineScanner {
 public:
  static constexpr std::size_t deepest = 32;

  explicit JsonLineScanner(std::string_view text) : text_(text) {}

  [[nodiscard]] JsonLines scan() {
    while (at_ < text_.size() && !lines_.too_deep) step();
    return std::move(lines_);
  }

 private:
  struct Level {
    std::string path;
    bool is_object = false;
    bool wants_key = false;
    std::size_t index = 0;
  };

  void step() {
    const char c = text_[at_];
    if (c == '/') return skip_comment();
    ++at_;
    switch (c) {
      case '\n':
        ++line_;
        break;
      case '{':
      case '[':
        open(c == '{');
        break;
      case '}':
      case ']':
        if (!levels_.empty()) levels_.pop_back();
        break;
      case ',':
        next_member();
        break;
      case '"':
        string();
        break;
      default:
        if (is_scalar(c)) scalar();
        break;
    }
  }

  void skip_comment() {
    const bool block = text_.substr(at_, 2) == "/*";
    const std::size_t end = text_.find(block ? "*/" : "\n", at_ + (block ? 2 : 0));
    const std::size_t stop = end == std::string_view::npos ? text_.size() : end + (block ? 2 : 0);
    for (; at_ < stop; ++at_) line_ += text_[at_] == '\n' ? 1 : 0;
  }

  /// Notes the line of the value that begins here and answers its path.
  std::string begin_value() {
    std::string path;
    if (!levels_.empty()) {
      const Level& level = levels_.back();
      path = level.is_object ? key_path_ : level.path + "[" + std::to_string(level.index) + "]";
    }
    if (levels_.empty() || !levels_.back().is_object) lines_.line_of_path.emplace(path, line_);
    return path;
  }

  void open(bool is_object) {
    if (levels_.size() >= deepest) {
      lines_.too_deep = true;
      return;
    }
    std::string path = begin_value();
    levels_.push_back({std::move(path), is_object, is_object, 0});
  }

  void next_member() {
    if (levels_.empty()) return;
    levels_.back().wants_key = levels_.back().is_object;
    ++levels_.back().index;
  }

  void string() {
    const std::size_t begin = at_ - 1;
    while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
    if (at_ < text_.size()) ++at_;
    if (levels_.empty() || !levels_.back().wants_key) {
      begin_value();
      return;
    }
    levels_.back().wants_key = false;
    const std::string key = nlohmann::json::parse(text_.substr(begin, at_ - begin)).get<std::string>();
    key_path_ = levels_.back().path.empty() ? key : levels_.back().path + "." + key;
    if (!lines_.line_of_path.emplace(key_path_, line_).second && lines_.duplicate.empty()) {
      lines_.duplicate = key_path_;
      lines_.duplicate_line = line_;
    }
  }

  [[nodiscard]] static bool is_scalar(char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '+' ||
           c == '.';
  }

  void scalar() {
    begin_value();
    while (at_ < text_.size() && is_scalar(text_[at_])) ++at_;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  std::vector<Level> levels_;
  std::string key_path_;
  JsonLines lines_;
};

}  // namespace holdfast::io
