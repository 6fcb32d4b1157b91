# PARADESC_SANITIZE and PARADESC_FUZZ → options of every target. The first finding ends the process.
if(PARADESC_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "The fuzz targets need Clang's libFuzzer; configure with -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_COMPILER=clang.")
  endif()
  if(NOT PARADESC_SANITIZE)
    set(PARADESC_SANITIZE address)
  endif()
  # libFuzzer does not trace comparisons: they stand in the innermost loops, and tracing them took nearly half of the time.
  add_compile_options(-fsanitize=fuzzer-no-link -fno-sanitize-coverage=trace-cmp)
endif()

if(PARADESC_SANITIZE STREQUAL "address")
  # GCC's undefined leaves the conversion of too large floats out.
  set(PARADESC_SANITIZERS address,undefined,float-cast-overflow)
elseif(PARADESC_SANITIZE STREQUAL "thread")
  set(PARADESC_SANITIZERS thread)
elseif(PARADESC_SANITIZE)
  message(FATAL_ERROR "PARADESC_SANITIZE is ${PARADESC_SANITIZE}; choose address or thread.")
endif()
if(PARADESC_SANITIZERS)
  add_compile_options(-fsanitize=${PARADESC_SANITIZERS} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${PARADESC_SANITIZERS})
endif()
