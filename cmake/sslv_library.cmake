# SPDX-License-Identifier: Apache-2.0
# One library a folder:
#
#   sslv_library(NAME SOURCES file... [LINKS library...] [PRIVATE_LINKS library...] [ALONE file...] [PCH header...])
#
# LINKS are also linked to whatever links NAME. A library is compiled in batches of its files: most of the time for
# a file goes into the same templates (JSON, formats, sockets), and a batch pays for them once. So names in unnamed
# namespaces are unique in a library. ALONE names files that are compiled each by itself: those whose code runs for
# every frame or has compile options of its own (CMake does that by itself), and those that #include themselves, as
# Highway's do. PCH: headers that are precompiled for a library whose files are compiled alone. With SSLV_BATCHES=OFF
# every file is compiled alone, so that each is known to include what it needs: ./run lint does that.
option(SSLV_BATCHES "Compile the files of a library in batches" ON)
set(SSLV_BATCH_SIZE 6)

function(sslv_batches target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${SSLV_BATCHES} UNITY_BUILD_BATCH_SIZE ${SSLV_BATCH_SIZE})
  if(SSLV_BATCHES AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # It takes the files of a batch for headers.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

function(sslv_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINKS;PRIVATE_LINKS;ALONE;PCH")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "${name}: unknown arguments ${arg_UNPARSED_ARGUMENTS}")
  endif()
  add_library(${name} STATIC ${arg_SOURCES} ${arg_ALONE})
  target_link_libraries(${name} PUBLIC ${arg_LINKS} PRIVATE ${arg_PRIVATE_LINKS})
  if(arg_PCH)
    target_precompile_headers(${name} PRIVATE ${arg_PCH})
  endif()
  sslv_batches(${name} ${arg_ALONE})
endfunction()
