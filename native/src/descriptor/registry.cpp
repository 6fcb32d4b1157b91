// descriptors.def, descriptor/operators.def → one table.
#include "descriptor/registry.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>
#include <string>

#include "support/error.h"

namespace paradesc {

static std::span<const DescriptorRow> all_rows() {
  static const DescriptorRow rows[] = {
#define DESCRIPTOR(name, label, description, power, is_signed, neutral, low, high, components, terms)                            \
  {#name, label, description, power, is_signed != 0, neutral, low, high, components, terms},
#include "descriptor/descriptors.def"
#undef DESCRIPTOR
#define VALUE MapNeeds::value
#define WINDOW MapNeeds::window
#define GRADIENT MapNeeds::gradient
#define OPERATOR(name, label, description, power, degree, needs, is_signed, neutral, low, high, components, terms)               \
  {#name, label, description, power, is_signed != 0, neutral, low, high, components, terms, degree, needs},
#include "descriptor/operators.def"
#undef OPERATOR
#undef GRADIENT
#undef WINDOW
#undef VALUE
  };
  return rows;
}

std::span<const DescriptorRow> descriptors() { return all_rows().first(all_rows().size() - 1); }

const DescriptorRow &descriptor_row(int index) { return all_rows()[index]; }

std::vector<std::string> all_terms() {
  std::vector<std::string> found;
  for (const DescriptorRow &row : all_rows()) {
    std::istringstream list(row.terms);
    for (std::string name; list >> name;)
      if (std::ranges::find(found, name) == found.end()) found.push_back(name);
  }
  return found;
}

bool reads_map(std::span<const int> rows) {
  return std::ranges::any_of(rows, [](int row) { return descriptor_row(row).needs != MapNeeds::nothing; });
}

bool uses_terms(int row, std::string_view terms) {
  const std::string list = std::string(" ") + descriptor_row(row).terms + " ";
  return list.find(" " + std::string(terms) + " ") != list.npos;
}

int gradient_row() { return static_cast<int>(all_rows().size()) - 1; }

int find_descriptor(const char *name) {
  const auto rows = descriptors();
  std::string known;
  for (size_t i = 0; i < rows.size(); ++i) {
    if (name && std::strcmp(rows[i].name, name) == 0) return static_cast<int>(i);
    known += (i ? ", " : "") + std::string(rows[i].name);
  }
  throw Error(PDESC_ERROR_INVALID_ARGUMENT,
              "There is no descriptor '" + std::string(name ? name : "(null)") + "'; choose from " + known + ".");
}

} // namespace paradesc
