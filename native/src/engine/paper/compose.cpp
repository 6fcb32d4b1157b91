// Rows of the registry → the files of shaders/kernel that they need, and calls of the functions that these define.
#include "engine/paper/compose.h"

#include <cctype>

#include "descriptor/registry.h"

namespace paradesc {

// The struct that a file of terms defines: BallTerms in ball.glsl.
static std::string struct_of(std::string terms) {
  terms[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(terms[0])));
  return terms + "Terms";
}

std::string compose_terms(std::span<const int> descriptors, bool integral) {
  std::string text, members, init, add;
  for (const std::string &terms : all_terms()) {
    bool used = integral && (terms == "ball" || terms == "area");
    for (const int descriptor : descriptors) used = used || uses_terms(descriptor, terms);
    if (!used) continue;
    text += "#include \"kernel/terms/" + terms + ".glsl\"\n";
    members += "  " + struct_of(terms) + " " + terms + ";\n";
    init += "  " + terms + "_init(terms." + terms + ");\n";
    add += "  " + terms + "_add(terms." + terms + ", center, neighbor);\n";
  }
  if (members.empty()) { // GLSL has no empty structs
    members = "  float none;\n";
    init = "  terms.none = 0.0;\n";
  }
  return text + "struct Terms {\n" + members + "};\n" + "void terms_init(out Terms terms) {\n" + init + "}\n" +
         "void terms_add(inout Terms terms, Center center, Neighbor neighbor) {\n" + add + "}\n";
}

std::string compose_descriptors(std::span<const int> descriptors) {
  std::string text, store;
  int row = 0;
  auto add_store = [&](const std::string &value) {
    store += " \\\n  results[(ROW_DESCRIPTORS + " + std::to_string(row++) + ") * params.total + index] = floatBitsToUint(" +
             value + ");";
  };
  for (const int descriptor : descriptors) {
    const DescriptorRow &registered = descriptor_row(descriptor);
    const std::string name = registered.name, call = name + "(sums.terms, sums.center, neighborhood)";
    text += std::string("#include \"kernel/") + (registered.map_degree ? "operators/" : "descriptors/") + name + ".glsl\"\n";
    if (registered.components == 1) {
      add_store(call);
      continue;
    }
    store += " \\\n  vec3 value_" + name + " = " + call + ";";
    for (const char *axis : {".x", ".y", ".z"}) add_store("value_" + name + axis);
  }
  return text + "#define STORE_DESCRIPTORS" + store + "\n";
}

} // namespace paradesc
