// The rows of descriptors.def and of descriptor/operators.def, by name.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace paradesc {

// An operator reads of a map f: its values within the radius, its values within a Gaussian window, or its gradients there.
enum class MapNeeds { nothing, value, window, gradient };

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
  const char *terms;  // what its kernel adds up: names of files in shaders/kernel/terms
  int map_degree = 0; // the unit has that of the map to this power; 0: not an operator
  MapNeeds needs = MapNeeds::nothing;
};

// Descriptors of the surface, then operators on a map of one of them.
std::span<const DescriptorRow> descriptors();

// Any row, that of the map's gradient included, which is not for callers.
const DescriptorRow &descriptor_row(int index);
int gradient_row();

// The files in shaders/kernel/terms, and whether a row needs one of them.
std::vector<std::string> all_terms();
bool uses_terms(int row, std::string_view terms);

// Index of a row. Throws Error(INVALID_ARGUMENT) that lists the names there are.
int find_descriptor(const char *name);

} // namespace paradesc
