// The rows of descriptors.def, by name.
#pragma once

#include <span>

#include "descriptor/reference.h"

namespace paradesc {

struct DescriptorRow {
  const char *name;
  const char *label;
  const char *description;
  int length_power;
  bool is_signed;
  double neutral;
  double display_minimum;
  double display_maximum;
  int components;
};

std::span<const DescriptorRow> descriptors();

// Index of a row. Throws Error(INVALID_ARGUMENT) that lists the names there are.
int find_descriptor(const char *name);

} // namespace paradesc
