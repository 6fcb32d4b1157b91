// The rows of descriptors.def and of descriptor/operators.def, by name.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace paradesc {

// The part of a map f that an operator reads: values within the radius, values within a Gaussian window, or gradients there.
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
  const char *terms;  // the sums of its kernel: names of files in shaders/kernel/terms
  int map_degree = 0; // the unit contains the map's unit to this power; 0: not an operator
  MapNeeds needs = MapNeeds::nothing;
};

// Descriptors of the surface, then operators on a map of one of them.
std::span<const DescriptorRow> descriptors();

// The row of any index, including the map's gradient, which callers cannot request.
const DescriptorRow &descriptor_row(int index);
int gradient_row();

// The files in shaders/kernel/terms, and whether a row needs one of them.
std::vector<std::string> all_terms();
bool uses_terms(int row, std::string_view terms);
// Returns whether one of the rows is an operator on a map.
bool reads_map(std::span<const int> rows);

// Index of a row. Throws Error(INVALID_ARGUMENT) that lists the available names.
int find_descriptor(const char *name);

} // namespace paradesc
