# What the library is built with: GLM, stb, OpenMesh and Khronos' headers → paradesc_headers and paradesc_openmesh.
set(OPENMESH_SOURCE_DIR "" CACHE PATH "OpenMesh's source (the folder with src/OpenMesh): its Core becomes a part of the library")

# Links to these folders alone: a compiler for another system must not see the rest of this one's /usr/include.
set(PARADESC_HEADERS ${PROJECT_BINARY_DIR}/headers)
file(MAKE_DIRECTORY ${PARADESC_HEADERS})
function(paradesc_headers folder header)
  string(TOUPPER ${folder}_INCLUDE_DIR variable)
  find_path(${variable} ${folder}/${header} PATHS /usr/include REQUIRED) # no default where another system is built for
  file(REAL_PATH ${${variable}}/${folder} target)
  file(CREATE_LINK ${target} ${PARADESC_HEADERS}/${folder} SYMBOLIC)
endfunction()
paradesc_headers(glm glm.hpp)
paradesc_headers(GL glcorearb.h)
paradesc_headers(KHR khrplatform.h)
paradesc_headers(stb stb_rect_pack.h)
if(PARADESC_EGL)
  paradesc_headers(EGL eglext.h)
endif()

add_library(paradesc_headers INTERFACE)
target_include_directories(paradesc_headers SYSTEM INTERFACE ${PARADESC_HEADERS})
if(WIN32)
  target_compile_definitions(paradesc_headers INTERFACE APIENTRY=__stdcall) # else glcorearb.h includes windows.h for it
endif()
add_library(paradesc_openmesh INTERFACE)
target_link_libraries(paradesc_openmesh INTERFACE paradesc_headers)
if(OPENMESH_SOURCE_DIR)
  file(CREATE_LINK ${OPENMESH_SOURCE_DIR}/src/OpenMesh ${PARADESC_HEADERS}/OpenMesh SYMBOLIC)
  file(GLOB OPENMESH_SOURCES ${PARADESC_HEADERS}/OpenMesh/Core/Mesh/*.cc ${PARADESC_HEADERS}/OpenMesh/Core/System/*.cc
       ${PARADESC_HEADERS}/OpenMesh/Core/Utils/*.cc ${PARADESC_HEADERS}/OpenMesh/Core/IO/*.cc)
  add_library(paradesc_openmesh_core STATIC ${OPENMESH_SOURCES})
  target_include_directories(paradesc_openmesh_core SYSTEM PUBLIC ${PARADESC_HEADERS})
  target_compile_definitions(paradesc_openmesh_core PUBLIC OM_STATIC_BUILD)
  target_link_libraries(paradesc_openmesh INTERFACE paradesc_openmesh_core)
else()
  # Where there is an archive it becomes a part of the library; Debian has the shared one only, which is then laid beside it.
  paradesc_headers(OpenMesh Core/Mesh/TriMesh_ArrayKernelT.hh)
  find_library(OPENMESH_CORE NAMES libOpenMeshCore.a OpenMeshCore REQUIRED)
  if(NOT OPENMESH_CORE MATCHES "\\.a$")
    file(REAL_PATH ${OPENMESH_CORE} OPENMESH_CORE_FILE)
  endif()
  target_link_libraries(paradesc_openmesh INTERFACE ${OPENMESH_CORE})
endif()
