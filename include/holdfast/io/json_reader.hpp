/// Reads JSON with messages that name file, line, key path, value and what was expected.
///
///     const JsonDocument document = JsonDocument::parse(text, "my.json");
///     const JsonNode root = document.root();
///     root.allow_only({"name", "size_px"});                       // any other key is refused by name
///     const std::string name = root.at("name").string();
///     const double size = root.at("size_px").number(1, 100);
///
/// Comments (// and /* */) are allowed. Refused: anything that is not valid JSON, a key twice in one object, numbers
/// too large for a double, more than 32 levels or 4 MB. Every refusal is an InputError.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <holdfast/io/input_error.hpp>
#include <holdfast/io/json_lines.hpp>

namespace holdfast::io {

class JsonDocument;

/// One value of a document, and where it stands. Lives no longer than its document.
class JsonNode {
 public:
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] bool is_boolean() const { return value_->is_boolean(); }
  [[nodiscard]] bool is_string() const { return value_->is_string(); }
  [[nodiscard]] bool is_object() const { return value_->is_object(); }

  /// Throws the InputError that names this value.
  [[noreturn]] inline void fail(std::string problem, std::string expected) const;

  /// Refuses a value that is no object, and every key that is not in the list.
  inline void allow_only(std::initializer_list<std::string_view> keys) const;
  inline void allow_only(std::span<const std::string_view> keys) const;

  /// A member that must be there.
  [[nodiscard]] inline JsonNode at(std::string_view key) const;
  /// A member that may be missing.
  [[nodiscard]] inline std::optional<JsonNode> find(std::string_view key) const;

  /// The elements of an array of `fewest` to `most` elements.
  [[nodiscard]] inline std::vector<JsonNode> elements(std::size_t fewest, std::size_t most) const;

  [[nodiscard]] inline double number(double lowest, double highest) const;
  [[nodiscard]] inline int integer(int lowest, int highest) const;
  [[nodiscard]] inline bool boolean() const;
  [[nodiscard]] inline std::string string() const;
  /// A string that is one of `choices`; answers its index.
  [[nodiscard]] inline std::size_t choice(std::initializer_list<std::string_view> choices) const;

 private:
  friend class JsonDocument;
  JsonNode(const JsonDocument& document, const nlohmann::json& value, std::string path)
      : document_(&document), value_(&value), path_(std::move(path)) {}

  [[nodiscard]] std::string path_of(std::string_view key) const {
    return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
  }

  const JsonDocument* document_;
  const nlohmann::json* value_;
  std::string path_;
};

class JsonDocument {
 public:
  static constexpr std::size_t longest = 4'000'000;

  /// `file` is only for messages.
  [[nodiscard]] static JsonDocument parse(std::string_view text, std::string file) {
    JsonDocument document;
    document.file_ = std::move(file);
    if (text.size() > longest) document.refuse(0, "", "the file is too long", "at most 4 MB");
    // The JSON library takes a zero byte for the end of the text.
    if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
      document.refuse(line_at(text, zero), "", "the text holds a zero byte", "JSON in UTF-8");
    }
    document.json_ = document.parsed(text);
    document.lines_ = JsonLineScanner(text).scan();
    if (document.lines_.too_deep)
      document.refuse(0, "", "objects or arrays are nested too deeply", "at most 32 levels");
    if (!document.lines_.duplicate.empty()) {
      document.refuse(document.lines_.duplicate_line, document.lines_.duplicate, "the key stands twice in its object",
                      "each key once");
    }
    return document;
  }

  [[nodiscard]] JsonNode root() const { return JsonNode(*this, json_, ""); }
  [[nodiscard]] const std::string& file() const { return file_; }

  /// Line of a path, or of the nearest value round it.
  [[nodiscard]] std::size_t line_of(std::string path) const {
    while (true) {
      const auto found = lines_.line_of_path.find(path);
      if (found != lines_.line_of_path.end()) return found->second;
      const std::size_t cut = path.find_last_of(".[");
      if (cut == std::string::npos) break;
      path.resize(cut);
    }
    const auto root = lines_.line_of_path.find("");
    return root != lines_.line_of_path.end() ? root->second : 1;
  }

 private:
  JsonDocument() = default;

  [[noreturn]] void refuse(std::size_t line, std::string key, std::string problem, std::string expected) const {
    throw InputError({.file = file_,
                      .line = line,
                      .key = std::move(key),
                      .problem = std::move(problem),
                      .value = {},
                      .expected = std::move(expected)});
  }

  [[nodiscard]] static std::size_t line_at(std::string_view text, std::size_t offset) {
    const std::string_view before = text.substr(0, std::min(offset, text.size()));
    return 1 + static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'));
  }

  [[nodiscard]] nlohmann::json parsed(std::string_view text) const {
    try {
      return nlohmann::json::parse(text, nullptr, true, true);
    } catch (const nlohmann::json::parse_error& error) {
      // "[json.exception.parse_error.101] parse error at line 3, column 5: syntax error ...": we say the line
      // ourselves.
      std::string what = error.what();
      const std::size_t column = what.find(", column ");
      const std::size_t colon = column == std::string::npos ? column : what.find(": ", column);
      if (colon != std::string::npos) what = what.substr(colon + 2);
      refuse(line_at(text, error.byte > 0 ? error.byte - 1 : 0), "", "not valid JSON: " + what,
             "JSON (comments are allowed)");
    } catch (const nlohmann::json::out_of_range& error) {
      // The one case while parsing: "... number overflow parsing '1e999'".
      const std::string what = error.what();
      const std::size_t open = what.find('\'');
      const std::string number = open == std::string::npos ? "" : what.substr(open + 1, what.rfind('\'') - open - 1);
      const std::size_t offset = number.empty() ? std::string_view::npos : text.find(number);
      throw InputError({.file = file_,
                        .line = offset == std::string_view::npos ? 0 : line_at(text, offset),
                        .key = {},
                        .problem = "a number is too large",
                        .value = number,
                        .expected = "a finite number"});
    }
  }

  std::string file_;
  nlohmann::json json_;
  JsonLines lines_;
};

namespace detail {

inline std::string listed(std::span<const std::string_view> words) {
  std::string text;
  for (const std::string_view word : words) text += (text.empty() ? "" : ", ") + std::string(word);
  return text;
}

/// A number for a message: the shortest digits that mean it.
inline std::string brief(double value) {
  std::string text = nlohmann::json(value).dump();
  if (text.size() > 2 && text.substr(text.size() - 2) == ".0") text.resize(text.size() - 2);
  return text;
}

}  // namespace detail

inline void JsonNode::fail(std::string problem, std::string expected) const {
  const auto is_primitive = [](const nlohmann::json& v) { return v.is_primitive(); };
  const bool is_short = value_->is_primitive() || (value_->is_array() && value_->size() <= 4 &&
                                                   std::all_of(value_->begin(), value_->end(), is_primitive));
  throw InputError({.file = document_->file(),
                    .line = document_->line_of(path_),
                    .key = path_,
                    .problem = std::move(problem),
                    .value = is_short ? value_->dump() : std::string(),
                    .expected = std::move(expected)});
}

inline void JsonNode::allow_only(std::initializer_list<std::string_view> keys) const {
  allow_only(std::span(keys.begin(), keys.size()));
}

inline void JsonNode::allow_only(std::span<const std::string_view> keys) const {
  if (!value_->is_object()) fail("not an object", "an object with " + detail::listed(keys));
  for (const auto& [key, member] : value_->items()) {
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
      JsonNode(*document_, member, path_of(key)).fail("unknown key", "one of " + detail::listed(keys));
    }
  }
}

inline std::optional<JsonNode> JsonNode::find(std::string_view key) const {
  if (!value_->is_object()) fail("not an object", "an object with the key " + std::string(key));
  const auto found = value_->find(std::string(key));
  if (found == value_->end()) return std::nullopt;
  return JsonNode(*document_, *found, path_of(key));
}

inline JsonNode JsonNode::at(std::string_view key) const {
  std::optional<JsonNode> member = find(key);
  if (member) return std::move(*member);
  throw InputError({.file = document_->file(),
                    .line = document_->line_of(path_),
                    .key = path_of(key),
                    .problem = "the key is missing",
                    .value = {},
                    .expected = "it in the object that begins on this line"});
}

inline std::vector<JsonNode> JsonNode::elements(std::size_t fewest, std::size_t most) const {
  const std::string expected =
      fewest == most ? "an array of " + std::to_string(fewest) + " elements"
                     : "an array of " + std::to_string(fewest) + " to " + std::to_string(most) + " elements";
  if (!value_->is_array()) fail("not an array", expected);
  if (value_->size() < fewest || value_->size() > most) fail("wrong number of elements", expected);
  std::vector<JsonNode> nodes;
  for (std::size_t i = 0; i < value_->size(); ++i) {
    nodes.push_back(JsonNode(*document_, (*value_)[i], path_ + "[" + std::to_string(i) + "]"));
  }
  return nodes;
}

inline double JsonNode::number(double lowest, double highest) const {
  const std::string expected = "a number of " + detail::brief(lowest) + " to " + detail::brief(highest);
  if (!value_->is_number()) fail("not a number", expected);
  const double value = value_->get<double>();
  if (!(value >= lowest && value <= highest)) fail("out of range", expected);
  return value;
}

inline int JsonNode::integer(int lowest, int highest) const {
  const std::string expected = "a whole number of " + std::to_string(lowest) + " to " + std::to_string(highest);
  if (!value_->is_number_integer()) fail("not a whole number", expected);
  const double value = value_->get<double>();  // exact in the range allowed, and never wraps outside it
  if (!(value >= lowest && value <= highest)) fail("out of range", expected);
  return static_cast<int>(value);
}

inline bool JsonNode::boolean() const {
  if (!value_->is_boolean()) fail("not true or false", "true or false");
  return value_->get<bool>();
}

inline std::string JsonNode::string() const {
  if (!value_->is_string()) fail("not a string", "a string in double quotes");
  return value_->get<std::string>();
}

inline std::size_t JsonNode::choice(std::initializer_list<std::string_view> choices) const {
  const std::string expected = "one of " + detail::listed(std::span(choices.begin(), choices.size()));
  if (!value_->is_string()) fail("not a string", expected);
  const auto found = std::find(choices.begin(), choices.end(), value_->get_ref<const std::string&>());
  if (found == choices.end()) fail("unknown word", expected);
  return static_cast<std::size_t>(found - choices.begin());
}

}  // namespace holdfast::io
