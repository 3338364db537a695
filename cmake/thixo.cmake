# Flags and helpers every target shares.

add_library(thixo_options INTERFACE)
target_include_directories(thixo_options INTERFACE ${PROJECT_SOURCE_DIR})
# No fast-math and no -march=native: equal bytes on every CPU with AVX2.
# -Wno-restrict: g++ 12 warns of std::string concatenation (its bug 105651).
target_compile_options(thixo_options INTERFACE
  -march=x86-64-v3 -Wall -Wextra -Wno-restrict -fno-math-errno -fno-trapping-math
  $<$<CONFIG:Release>:-O3>)
target_compile_definitions(thixo_options INTERFACE EIGEN_MAX_ALIGN_BYTES=32 EIGEN_DONT_PARALLELIZE)
if(THIXO_SANITIZE)
  target_compile_options(thixo_options INTERFACE -fsanitize=${THIXO_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(thixo_options INTERFACE -fsanitize=${THIXO_SANITIZE})
endif()

# Headers that nearly every file parses are precompiled. This saves a third to a half of a file's compile time.
# With it ccache needs the setting that the launcher makes: CCACHE_SLOPPINESS=pch_defines,time_macros.
option(THIXO_PCH "Precompile Eigen, fmt, GoogleTest and the standard library" OFF)
function(thixo_precompiled name header_target)
  if(THIXO_PCH)
    target_precompile_headers(${name} REUSE_FROM ${header_target})
  endif()
endfunction()

# Sources of one target are compiled eight at a time. Templates that they share are then instantiated once, which takes half of the time for
# pipeline/. A name at file scope must therefore be the only one of its target.
option(THIXO_UNITY "Compile sources of a target together" OFF)
function(thixo_together name sources)
  list(LENGTH sources count)
  if(THIXO_UNITY AND count GREATER 1)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    target_compile_options(${name} PRIVATE -Wno-subobject-linkage)  # it takes a source for a header
  endif()
endfunction()
if(THIXO_PCH)
  file(WRITE ${CMAKE_BINARY_DIR}/precompiled.cpp "")
  add_library(thixo_headers OBJECT ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(thixo_headers PRIVATE thixo_options Eigen3::Eigen TBB::tbb fmt::fmt)
  target_precompile_headers(thixo_headers PRIVATE <Eigen/Dense> <fmt/format.h> <algorithm> <filesystem> <functional> <map> <memory> <optional>
    <string> <variant> <vector>)
endif()

# thixo_library(NAME SOURCES ... LINK ... [PRIVATE_LINK ...] [DOUBLE])
#
# DOUBLE adds NAME_double: the same sources with double state (Real = double), for tests of laws. It links the _double
# variants of libraries in LINK, where they have one.
function(thixo_library name)
  cmake_parse_arguments(A "DOUBLE" "" "SOURCES;LINK;PRIVATE_LINK" ${ARGN})
  add_library(${name} STATIC ${A_SOURCES})
  target_link_libraries(${name} PUBLIC thixo_options ${A_LINK} PRIVATE ${A_PRIVATE_LINK})
  thixo_precompiled(${name} thixo_headers)
  thixo_together(${name} "${A_SOURCES}")
  if(A_DOUBLE AND THIXO_TESTS)
    set(double_link "")
    foreach(l IN LISTS A_LINK)
      if(TARGET ${l}_double)
        list(APPEND double_link ${l}_double)
      else()
        list(APPEND double_link ${l})
      endif()
    endforeach()
    add_library(${name}_double STATIC EXCLUDE_FROM_ALL ${A_SOURCES})
    target_compile_definitions(${name}_double PUBLIC THIXO_DOUBLE)
    target_link_libraries(${name}_double PUBLIC thixo_options ${double_link} PRIVATE ${A_PRIVATE_LINK})
    thixo_precompiled(${name}_double thixo_headers)
    thixo_together(${name}_double "${A_SOURCES}")
  endif()
endfunction()
