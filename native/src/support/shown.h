// Numbers as sentences show them: "0.02" and "1e+300", where std::to_string gives 300 digits, or none that say anything.
#pragma once

#include <cstdio>
#include <string>

namespace paradesc {

inline std::string shown(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", number);
  return text;
}

} // namespace paradesc
