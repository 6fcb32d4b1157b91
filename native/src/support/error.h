// The one exception type: a status code and a sentence for people. Thrown anywhere inside; caught only in api_edge.h.
#pragma once

#include <stdexcept>
#include <string>

#include "paradesc/paradesc.h"

namespace paradesc {

class Error : public std::runtime_error {
public:
  Error(pdesc_status status, const std::string &sentence) : std::runtime_error(sentence), status_(status) {}
  pdesc_status status() const { return status_; }
  // The sentence without its period, for use within another sentence.
  std::string clause() const {
    std::string words = what();
    while (words.ends_with('.')) words.pop_back();
    return words;
  }

private:
  pdesc_status status_;
};

} // namespace paradesc
