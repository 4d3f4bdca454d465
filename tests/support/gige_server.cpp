// SPDX-License-Identifier: Apache-2.0
#include "support/gige_server.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

// The library's headers convert as C does.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#include <arv.h>
#pragma GCC diagnostic pop

namespace sslv {
namespace {

constexpr int kGvcpPort = 3956;

constexpr std::array<std::pair<PixelFormat, ArvPixelFormat>, 6> kFormats{{
    {PixelFormat::kMono8, ARV_PIXEL_FORMAT_MONO_8},
    {PixelFormat::kRgb24, ARV_PIXEL_FORMAT_RGB_8_PACKED},
    {PixelFormat::kBayerRg8, ARV_PIXEL_FORMAT_BAYER_RG_8},
    {PixelFormat::kBayerGr8, ARV_PIXEL_FORMAT_BAYER_GR_8},
    {PixelFormat::kBayerGb8, ARV_PIXEL_FORMAT_BAYER_GB_8},
    {PixelFormat::kBayerBg8, ARV_PIXEL_FORMAT_BAYER_BG_8},
}};

/// 0 when the port of this address can be had, else why not. The library itself would share it with another
/// camera and then answer at random.
int port_error(const std::string& address) {
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(kGvcpPort);
  inet_pton(AF_INET, address.c_str(), &name.sin_addr);
  const int error =
      ::bind(descriptor, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0 ? 0 : errno;
  ::close(descriptor);
  return error;
}

void wait_for_port(const std::string& address) {
  constexpr std::chrono::seconds kPatience(30);
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  for (;;) {
    const int error = port_error(address);
    if (error == 0) return;
    if (error != EADDRINUSE || std::chrono::steady_clock::now() > deadline) {
      throw std::runtime_error(fmt::format("UDP port {} of {} cannot be had for a GigE Vision camera: {}",
                                           kGvcpPort, address, std::generic_category().message(error)));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

}  // namespace

struct GigeServer::Library {
  Fill fill;
  ArvGvFakeCamera* server = nullptr;

  ArvFakeCamera* camera() const { return arv_gv_fake_camera_get_fake_camera(server); }
  ~Library() {
    if (server != nullptr) g_object_unref(server);
  }
};

GigeServer::GigeServer(const std::string& interface_address, const std::string& serial, Fill fill)
    : library_(std::make_unique<Library>()) {
  wait_for_port(interface_address);
  library_->fill = std::move(fill);
  library_->server = arv_gv_fake_camera_new(interface_address.c_str(), serial.c_str());
  if (!arv_gv_fake_camera_is_running(library_->server)) {
    throw std::runtime_error("no GigE Vision camera can be played on " + interface_address +
                             ": it must be an IPv4 address of this machine");
  }
  const auto on_fill = [](ArvBuffer* buffer, void* library, guint32, guint32, ArvPixelFormat pixels) {
    // The size that the library states here is 0; the memory suffices for the picture that the client has
    // set.
    std::size_t size = 0;
    auto* out = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &size)));
    for (const auto& [format, arv] : kFormats) {
      if (arv != pixels) continue;
      static_cast<Library*>(library)->fill(out, arv_buffer_get_image_width(buffer),
                                           arv_buffer_get_image_height(buffer), format);
    }
  };
  arv_fake_camera_set_fill_pattern(library_->camera(), on_fill, library_.get());
}

GigeServer::~GigeServer() = default;

void GigeServer::set_defaults(int width, int height, PixelFormat format, double frame_rate_hz) {
  const auto write = [&](guint32 address, std::uint32_t value) {
    arv_fake_camera_write_register(library_->camera(), address, value);
  };
  const auto* known =
      std::find_if(kFormats.begin(), kFormats.end(), [=](const auto& one) { return one.first == format; });
  if (known == kFormats.end()) {
    throw std::runtime_error(
        fmt::format("pixel_format {}: only mono8, rgb24 and bayer_* can be served", name_of(format)));
  }
  write(ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT, known->second);
  write(ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, static_cast<std::uint32_t>(width));
  write(ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, static_cast<std::uint32_t>(height));
  write(ARV_FAKE_CAMERA_REGISTER_WIDTH, static_cast<std::uint32_t>(width));
  write(ARV_FAKE_CAMERA_REGISTER_HEIGHT, static_cast<std::uint32_t>(height));
  write(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
        static_cast<std::uint32_t>(1e6 / frame_rate_hz));
}

void GigeServer::lose_packets(double ratio) {
  g_object_set(library_->server, "gvsp-lost-ratio", ratio, nullptr);
}

}  // namespace sslv
