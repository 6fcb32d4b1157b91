# shaders/kernel → terms.glsl and descriptors.glsl for C++: all of what engine/paper/compose.cpp writes for the descriptors asked for.
file(GLOB terms_files RELATIVE ${PROJECT_SOURCE_DIR}/shaders CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/shaders/kernel/terms/*.glsl)
file(GLOB finish_files RELATIVE ${PROJECT_SOURCE_DIR}/shaders CONFIGURE_DEPENDS
     ${PROJECT_SOURCE_DIR}/shaders/kernel/descriptors/*.glsl ${PROJECT_SOURCE_DIR}/shaders/kernel/operators/*.glsl)
set(includes "")
set(members "")
set(init "")
set(add "")
set(undefine "")
foreach(file ${terms_files})
  get_filename_component(name ${file} NAME_WE)
  string(SUBSTRING ${name} 0 1 first)
  string(SUBSTRING ${name} 1 -1 rest)
  string(TOUPPER ${first} first)
  string(TOUPPER TERMS_${name} choice)
  string(APPEND includes "#include \"${file}\"\n#ifndef ${choice}\n#define ${choice} 1\n#endif\n")
  string(APPEND members "#if ${choice}\n  ${first}${rest}Terms ${name};\n#endif\n")
  string(APPEND init "#if ${choice}\n  ${name}_init(terms.${name});\n#endif\n")
  string(APPEND add "#if ${choice}\n  ${name}_add(terms.${name}, center, neighbor);\n#endif\n")
  string(APPEND undefine "#undef ${choice}\n")
endforeach()
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/kernels/terms.glsl @ONLY CONTENT "@includes@struct Terms {
@members@};
void terms_init(OUT(Terms) terms) {
@init@}
void terms_add(INOUT(Terms) terms, Center center, Neighbor neighbor) {
@add@}
@undefine@")
list(TRANSFORM finish_files REPLACE "(.+)" "#include \"\\1\"\n")
list(JOIN finish_files "" finish)
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/kernels/descriptors.glsl @ONLY CONTENT "@finish@")
