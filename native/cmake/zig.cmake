# A toolchain file: Zig's C++ compiler builds for other systems than this one, without any library of this one.
#   cmake -DCMAKE_TOOLCHAIN_FILE=native/cmake/zig.cmake -DPARADESC_ZIG=…/ziglang/zig -DPARADESC_PLATFORM=windows-x64
# PARADESC_PLATFORM is a platform's name in Blender's extension manifests.
set(platforms
  "linux-x64|x86_64-linux-gnu.2.28|Linux|x86_64" # 2.28: the glibc of the systems that Blender itself is built on
  "linux-arm64|aarch64-linux-gnu.2.28|Linux|aarch64" # for wheels alone: no Blender runs there
  "windows-x64|x86_64-windows-gnu|Windows|AMD64"
  "windows-arm64|aarch64-windows-gnu|Windows|ARM64"
  "macos-x64|x86_64-macos.10.13|Darwin|x86_64"
  "macos-arm64|aarch64-macos.11.0|Darwin|arm64")
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES PARADESC_ZIG PARADESC_PLATFORM)

set(found "")
set(names "")
foreach(row ${platforms})
  string(REPLACE "|" ";" row ${row})
  list(GET row 0 name)
  list(APPEND names ${name})
  if(name STREQUAL PARADESC_PLATFORM)
    set(found ${row})
  endif()
endforeach()
if(NOT found)
  message(FATAL_ERROR "PARADESC_PLATFORM is '${PARADESC_PLATFORM}'; choose one of ${names}.")
endif()
list(GET found 1 target)
list(GET found 2 CMAKE_SYSTEM_NAME)
list(GET found 3 CMAKE_SYSTEM_PROCESSOR)

set(CMAKE_C_COMPILER ${PARADESC_ZIG} cc -target ${target})
set(CMAKE_CXX_COMPILER ${PARADESC_ZIG} c++ -target ${target})
# Stripped from the start, and CMake's checks compile and do not link: for anything linked otherwise Zig would first build
# a second C++ library, with debug information.
set(CMAKE_C_FLAGS_INIT -s)
set(CMAKE_CXX_FLAGS_INIT -s)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

# CMake wants its other tools as one file each.
set(tools ${CMAKE_CURRENT_BINARY_DIR}/zig)
foreach(tool ar ranlib rc)
  if(NOT EXISTS ${tools}/${tool})
    file(WRITE ${tools}/${tool} "#!/bin/sh\nexec '${PARADESC_ZIG}' ${tool} \"$@\"\n")
    file(CHMOD ${tools}/${tool} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  endif()
endforeach()
set(CMAKE_AR ${tools}/ar)
set(CMAKE_RANLIB ${tools}/ranlib)
set(CMAKE_RC_COMPILER ${tools}/rc)
