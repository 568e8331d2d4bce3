/// Text from a format and numbers.
#pragma once

#include <cstdio>
#include <string>

namespace swimlab {

/// As printf writes it; cut off after 511 characters.
std::string text_of(const char* format, auto... values) {
  char text[512];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace swimlab
