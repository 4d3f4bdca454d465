# SPDX-License-Identifier: Apache-2.0
# One library for each folder:
#
#   sslv_library(NAME SOURCES file... [ALONE file...] [LINKS library...] [PRIVATE_LINKS library...])
#
# LINKS are also linked to whatever links NAME. The files of a library are compiled in batches: half of a file's time
# goes into headers and templates (JSON, formats, Eigen, sockets) that a batch pays for once. So a library's files
# agree about the names in their unnamed namespaces. ALONE: files that are not batched, because they
# #include themselves, as Highway's do, or have their own compile options (CMake excludes those automatically).
#
# A change compiles its whole batch. To work in one room, configure with -DSSLV_BATCH_SIZE=1. ./run lint does so too,
# and finds files that do not include what they need.
set(SSLV_BATCH_SIZE 24 CACHE STRING "Files that are compiled together; 1: each alone")

function(sslv_batches target)
  if(SSLV_BATCH_SIZE GREATER 1)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${SSLV_BATCH_SIZE})
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      # It takes the files of a batch for headers.
      target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
    endif()
  endif()
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
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
