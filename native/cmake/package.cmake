# Libraries → the add-on's folder, its zips and the static repository of extensions: target package_addon.
#
# With PARADESC_ZIG, the libraries come from Zig's compiler, with one build for each platform (target release_libraries, from
# which wheels.py makes wheels, too). Without it, the library for this system is packed. A wheel built from source is installed.
set(PARADESC_ZIG "" CACHE FILEPATH "Zig's compiler, for release builds: .../site-packages/ziglang/zig")
set(PARADESC_PLATFORMS linux-x64 windows-x64 windows-arm64 macos-arm64 macos-x64 CACHE STRING "Platforms of release builds")
set(PARADESC_WITHOUT_BLENDER linux-arm64 CACHE STRING "Platforms of release builds that have wheels and no Blender")
set(PARADESC_WEBSITE "" CACHE STRING "Address that packages link, as doc_url and website; none if empty")
find_program(PARADESC_PYTHON python3 HINTS ${PROJECT_SOURCE_DIR}/.venv/bin)

if(APPLE)
  # Both Macs' libraries lie in one zip for Blender before 4.2.
  set_target_properties(paradesc PROPERTIES OUTPUT_NAME paradesc-${CMAKE_SYSTEM_PROCESSOR}
                        INSTALL_NAME_DIR "@rpath" BUILD_WITH_INSTALL_NAME_DIR ON)
elseif(WIN32)
  set_target_properties(paradesc PROPERTIES PREFIX "")
endif()

if(PARADESC_PLATFORM)
  if(NOT APPLE)
    # Callers of the library, to run on this system, under Wine and under QEMU.
    foreach(caller sphere_curvature bits frame_times)
      add_executable(${caller} ${PROJECT_SOURCE_DIR}/tests/packages/${caller}.c)
      target_include_directories(${caller} PRIVATE native/include)
      target_compile_options(${caller} PRIVATE -ffp-contract=off) # the same meshes everywhere
      set_target_properties(${caller} PROPERTIES C_EXTENSIONS ON)
      target_link_libraries(${caller} PRIVATE $<$<NOT:$<PLATFORM_ID:Windows>>:m>)
    endforeach()
  endif()
  return()
endif()

# The add-on finds the library in its own lib folder and nowhere else; so does the same Python in a wheel.
set(library_files $<TARGET_FILE:paradesc> ${OPENMESH_CORE_FILE})
install(FILES ${library_files} DESTINATION paradesc/lib)
if(NOT PARADESC_SANITIZE AND NOT SKBUILD)
  add_custom_command(TARGET paradesc POST_BUILD
    COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_SOURCE_DIR}/addon/paradesc/lib
    COMMAND ${CMAKE_COMMAND} -E copy_if_different ${library_files} ${PROJECT_SOURCE_DIR}/addon/paradesc/lib/)
endif()

set(arguments "")
if(PARADESC_ZIG)
  include(ExternalProject)
  foreach(platform ${PARADESC_PLATFORMS} ${PARADESC_WITHOUT_BLENDER})
    ExternalProject_Add(library_${platform} EXCLUDE_FROM_ALL ON
      SOURCE_DIR ${PROJECT_SOURCE_DIR} BINARY_DIR ${PROJECT_BINARY_DIR}/${platform}
      CMAKE_ARGS -DCMAKE_TOOLCHAIN_FILE=${PROJECT_SOURCE_DIR}/native/cmake/zig.cmake -DPARADESC_ZIG=${PARADESC_ZIG}
                 -DPARADESC_PLATFORM=${platform} -DOPENMESH_SOURCE_DIR=${OPENMESH_SOURCE_DIR} -DPARADESC_TESTS=OFF
                 -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER}
      BUILD_ALWAYS ON USES_TERMINAL_BUILD ON INSTALL_COMMAND "")
    list(APPEND libraries library_${platform})
    if(platform IN_LIST PARADESC_PLATFORMS)
      list(APPEND arguments --folder ${platform}=${PROJECT_BINARY_DIR}/${platform})
    endif()
  endforeach()
  add_custom_target(release_libraries DEPENDS ${libraries})
else()
  set(libraries paradesc)
  set(arguments --files ${library_files})
endif()
add_custom_target(package_addon
  COMMAND ${PARADESC_PYTHON} ${PROJECT_SOURCE_DIR}/native/cmake/package.py --output ${PROJECT_BINARY_DIR}/packages ${arguments}
          --website=${PARADESC_WEBSITE}
  DEPENDS ${libraries} USES_TERMINAL COMMENT "Packing the add-on" VERBATIM COMMAND_EXPAND_LISTS)
