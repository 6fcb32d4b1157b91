// descriptors.def → a table.
#include "descriptor/registry.h"

#include <cmath>
#include <cstring>
#include <string>

#include "support/error.h"

namespace paradesc {

std::span<const DescriptorRow> descriptors() {
  static const DescriptorRow rows[] = {
#define DESCRIPTOR(name, label, description, power, is_signed, neutral, low, high, components)                                   \
  {#name, label, description, power, is_signed != 0, neutral, low, high, components},
#include "descriptor/descriptors.def"
#undef DESCRIPTOR
  };
  return rows;
}

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
