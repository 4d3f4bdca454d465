# SPDX-License-Identifier: Apache-2.0
# One library for each folder:
#
#   sslv_library(NAME SOURCES file... [ALONE file...] [LINKS library...] [PRIVATE_LINKS library...])
#
# LINKS are also linked to every target that links NAME. A library's files are compiled in batches, because half of a
# file's compile time is headers and templates (JSON, formats, Eigen, sockets), which a batch compiles once. So names in
# unnamed namespaces must be unique within a library. ALONE: files that are not batched, because they
# #include themselves, as Highway's do, or have their own compile options (CMake excludes those automatically).
#
# A change recompiles its whole batch. To work on one library, configure with -DSSLV_BATCH_SIZE=1. ./run lint does so,
# too, to find files that do not include what they need.
set(SSLV_BATCH_SIZE 24 CACHE STRING "Files that are compiled together; 1: each alone")

function(sslv_batches target)
  if(SSLV_BATCH_SIZE GREATER 1)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${SSLV_BATCH_SIZE})
    # <httplib.h> includes <resolv.h>, whose macro _res is the name of a parameter in Eigen.
    set_target_properties(${target} PROPERTIES UNITY_BUILD_CODE_BEFORE_INCLUDE "#undef _res")
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      # GCC treats the files of a batch as headers.
      target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
    endif()
  endif()
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# For tests, and rooms without work per pixel or per robot: they compile in two thirds of the time.
function(sslv_compile_quickly target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:RelWithDebInfo>:-O1>)
endfunction()

# For a room full of Eigen: GCC compiles its expressions faster in small batches.
function(sslv_small_batches target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD_BATCH_SIZE 8)
endfunction()

function(sslv_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;ALONE;LINKS;PRIVATE_LINKS")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "${name}: unknown arguments ${arg_UNPARSED_ARGUMENTS}")
  endif()
  add_library(${name} STATIC ${arg_SOURCES} ${arg_ALONE})
  target_link_libraries(${name} PUBLIC ${arg_LINKS} PRIVATE ${arg_PRIVATE_LINKS})
  sslv_batches(${name} ${arg_ALONE})
endfunction()
