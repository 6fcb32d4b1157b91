// The one exception type: a status code and a sentence for people. Thrown anywhere inside, caught in api_edge.h only.
#pragma once

#include <stdexcept>
#include <string>

#include "paradesc/paradesc.h"

namespace paradesc {

class Error : public std::runtime_error {
public:
  Error(pdesc_status status, const std::string &sentence) : std::runtime_error(sentence), status_(status) {}
  pdesc_status status() const { return status_; }
  // The sentence without its period, to stand within another one.
  std::string clause() const {
    std::string words = what();
    while (words.ends_with('.')) words.pop_back();
    return words;
  }

private:
  pdesc_status status_;
};

} // namespace paradesc
