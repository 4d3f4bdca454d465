# SPDX-License-Identifier: Apache-2.0
# find_package(SslVision) provides the target SslVision::proto: the league's messages, generated from the .proto files
# with the protobuf version of the program that is built. Those files are in ${SslVision_PROTO_DIR}.
get_filename_component(SslVision_PROTO_DIR "${CMAKE_CURRENT_LIST_DIR}/../../ssl-vision/proto" ABSOLUTE)
include(CMakeFindDependencyMacro)
find_dependency(Protobuf)

if(NOT TARGET SslVision::proto)
  set(_ssl_vision_sources "")
  set(_ssl_vision_folder "${CMAKE_BINARY_DIR}/ssl-vision")
  file(MAKE_DIRECTORY "${_ssl_vision_folder}")
  foreach(_ssl_vision_name ssl_gc_common ssl_gc_geometry ssl_gc_referee_message ssl_vision_detection
      ssl_vision_detection_tracked ssl_vision_geometry ssl_vision_wrapper ssl_vision_wrapper_tracked)
    set(_ssl_vision_made "${_ssl_vision_folder}/${_ssl_vision_name}.pb.cc"
                         "${_ssl_vision_folder}/${_ssl_vision_name}.pb.h")
    add_custom_command(OUTPUT ${_ssl_vision_made}
      COMMAND protobuf::protoc --cpp_out "${_ssl_vision_folder}" -I "${SslVision_PROTO_DIR}"
              "${SslVision_PROTO_DIR}/${_ssl_vision_name}.proto"
      DEPENDS "${SslVision_PROTO_DIR}/${_ssl_vision_name}.proto" VERBATIM)
    list(APPEND _ssl_vision_sources ${_ssl_vision_made})
  endforeach()
  add_library(ssl_vision_proto STATIC EXCLUDE_FROM_ALL ${_ssl_vision_sources})
  target_include_directories(ssl_vision_proto SYSTEM PUBLIC "${_ssl_vision_folder}")
  target_link_libraries(ssl_vision_proto PUBLIC protobuf::libprotobuf)
  add_library(SslVision::proto ALIAS ssl_vision_proto)
endif()
