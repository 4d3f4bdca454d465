# The packages: ssl-visiond, ssl-visiond-dev, ssl-visiond-stages-dev and, if EGL is available, ssl-visiond-gpu.
# Included by systemd/CMakeLists.txt.
set(debian ${CMAKE_CURRENT_SOURCE_DIR}/debian)

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL service dev stages)
if(SSLV_HAVE_GPU)
  list(APPEND CPACK_COMPONENTS_ALL gpu)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGING_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_SOURCE_DIR}/build/package)
set(CPACK_STRIP_FILES ON)
# /etc is outside the prefix.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_PACKAGE_CONTACT "ssl-visiond maintainers <maintainers@ssl-visiond.invalid>")
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_SERVICE_PACKAGE_NAME ssl-visiond)
set(CPACK_DEBIAN_SERVICE_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_SERVICE_PACKAGE_SHLIBDEPS ON)
# Creates its user, even if systemd is not the init system.
set(CPACK_DEBIAN_SERVICE_PACKAGE_DEPENDS "systemd | systemd-standalone-sysusers")
# Teams compare packet times with the clocks of their computers; udev gives the service access to cameras.
set(CPACK_DEBIAN_SERVICE_PACKAGE_RECOMMENDS "systemd-timesyncd | time-daemon, udev, dbus")
set(CPACK_COMPONENT_SERVICE_DESCRIPTION
"vision service for RoboCup Small Size League fields
Finds robots and balls in the images of the cameras over a field, and sends
their positions by multicast in the league's format.
.
It runs without a desktop, a GPU or a vendor's SDK. A web panel on the
same computer shows cameras, calibrates them, learns colours and reports
whether a match may begin. Cameras: GigE Vision, USB3 Vision, IEEE 1394 and
Video4Linux; also recordings and a simulator.")
set(CPACK_DEBIAN_SERVICE_PACKAGE_CONTROL_EXTRA
  "${debian}/postinst;${debian}/prerm;${debian}/postrm;${debian}/conffiles")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME ssl-visiond-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION devel)
set(CPACK_DEBIAN_DEV_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "protobuf-compiler, libprotobuf-dev")
set(CPACK_COMPONENT_DEV_DESCRIPTION
"messages of the RoboCup Small Size League's vision, for teams
The .proto files of the messages that ssl-visiond sends, for CMake's
find_package and pkg-config, and a sample client that receives and prints
these messages.")

set(CPACK_DEBIAN_STAGES_PACKAGE_NAME ssl-visiond-stages-dev)
set(CPACK_DEBIAN_STAGES_PACKAGE_SECTION devel)
set(CPACK_DEBIAN_STAGES_PACKAGE_DEPENDS "libeigen3-dev, nlohmann-json3-dev")
set(CPACK_DEBIAN_STAGES_PACKAGE_RECOMMENDS "ssl-visiond (= ${PROJECT_VERSION}-1), cmake, g++")
set(CPACK_COMPONENT_STAGES_DESCRIPTION
"custom stages for ssl-visiond
Headers, a static library, CMake's find_package and examples for shared
objects that add stages to the pipeline of ssl-visiond: a detector, a
recorder, another marker. They run only with the version of ssl-visiond that
they were compiled for.")

set(CPACK_DEBIAN_GPU_PACKAGE_NAME ssl-visiond-gpu)
set(CPACK_DEBIAN_GPU_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_GPU_PACKAGE_SHLIBDEPS ON)
# Its stage is compiled for exactly this version of the service.
set(CPACK_DEBIAN_GPU_PACKAGE_DEPENDS "ssl-visiond (= ${PROJECT_VERSION}-1)")
set(CPACK_DEBIAN_GPU_PACKAGE_RECOMMENDS "libgl1-mesa-dri | nvidia-driver")
set(CPACK_COMPONENT_GPU_DESCRIPTION
"colour thresholding on a GPU for ssl-visiond
A stage that labels pixels by colour on a GPU, with the same labels as the
CPU's, for stacks that need a labelled image. It measures both and uses the
faster one. If the GPU is late or fails, the CPU labels the same image.")

include(CPack)
