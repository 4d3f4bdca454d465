// SPDX-License-Identifier: Apache-2.0
#include "support/gige_server.h"

#include "support/patience.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

// The library's headers use C conversions.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#include <arv.h>
#pragma GCC diagnostic pop

namespace sslv {
namespace {

constexpr int kGvcpPort = 3956;

constexpr std::array<std::pair<PixelFormat, ArvPixelFormat>, 6> kArvFormats{{
    {PixelFormat::kMono8, ARV_PIXEL_FORMAT_MONO_8},
    {PixelFormat::kRgb24, ARV_PIXEL_FORMAT_RGB_8_PACKED},
    {PixelFormat::kBayerRg8, ARV_PIXEL_FORMAT_BAYER_RG_8},
    {PixelFormat::kBayerGr8, ARV_PIXEL_FORMAT_BAYER_GR_8},
    {PixelFormat::kBayerGb8, ARV_PIXEL_FORMAT_BAYER_GB_8},
    {PixelFormat::kBayerBg8, ARV_PIXEL_FORMAT_BAYER_BG_8},
}};

/// 0 if the port of this address is free, otherwise the errno. The library would share the port with another
/// camera and then answer unpredictably.
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
  const auto deadline = std::chrono::steady_clock::now() + test::kPatience;
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

std::string enumeration(const std::string& name, const std::string& entries) {
  return "<Enumeration Name=\"" + name + "\">" + entries + "<pValue>" + name +
         "Register</pValue></Enumeration>";
}

std::string entry(const std::string& name, int value) {
  return fmt::format("<EnumEntry Name=\"{}\"><Value>{}</Value></EnumEntry>", name, value);
}

std::string on_or_off(const std::string& name) {
  return fmt::format(
      "<Boolean "
      "Name=\"{0}\"><pValue>{0}Register</pValue><OnValue>1</OnValue><OffValue>0</OffValue></Boolean>",
      name);
}

std::string with_register(const std::string& name, int address, const std::string& feature) {
  return fmt::format(
      "{}<IntReg Name=\"{}Register\"><Address>{}</Address><Length>4</Length><AccessMode>RW"
      "</AccessMode><pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>"
      "</IntReg>",
      feature, name, address);
}

/// A feature with one register per value of a selector.
std::string of_selected(const std::string& name, int address, const std::string& selector,
                        const std::string& feature) {
  return fmt::format(
      "{}<IntReg Name=\"{}Register\"><Address>{}</Address><pIndex Offset=\"4\">{}Register</pIndex>"
      "<Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort><Sign>Unsigned</Sign>"
      "<Endianess>BigEndian</Endianess></IntReg>",
      feature, name, address, selector);
}

/// The library's own description of its camera, extended by our features, as a file, which the library
/// requires.
class Description {
 public:
  Description() {
    GBytes* own =
        g_resources_lookup_data("/org/aravis/arv-fake-camera.xml", G_RESOURCE_LOOKUP_FLAGS_NONE, nullptr);
    if (own == nullptr) throw std::runtime_error("Aravis has no description of its fake camera");
    gsize size = 0;
    const auto* data = static_cast<const char*>(g_bytes_get_data(own, &size));
    std::string text(data, size);
    g_bytes_unref(own);
    const auto insert = [&](const std::string& before, const std::string& what) {
      const std::size_t place = text.find(before);
      if (place == std::string::npos) throw std::runtime_error("no " + before + " in Aravis' description");
      text.insert(place, what);
    };
    insert("<pFeature>PayloadSize</pFeature>",
           "<pFeature>ExposureAuto</pFeature><pFeature>PtpEnable</pFeature><pFeature>ChunkModeActive</"
           "pFeature><pFeature>BalanceRatioSelector</pFeature><pFeature>BalanceRatio</pFeature>"
           "<pFeature>LineSelector</pFeature><pFeature>LineInverter</pFeature>");
    insert("</RegisterDescription>",
           with_register("ExposureAuto", 0x400,
                         enumeration("ExposureAuto", entry("Off", 0) + entry("Continuous", 2))) +
               with_register("PtpEnable", 0x404, on_or_off("PtpEnable")) +
               with_register("ChunkModeActive", 0x408, on_or_off("ChunkModeActive")) +
               with_register("ChunkEnable", 0x40c, on_or_off("ChunkEnable")) +
               with_register("GevTimestampTickFrequency", 0x440,
                             "<Integer Name=\"GevTimestampTickFrequency\">"
                             "<pValue>GevTimestampTickFrequencyRegister</pValue></Integer>") +
               with_register("ChunkSelector", 0x410, enumeration("ChunkSelector", entry("ExposureTime", 0))) +
               with_register("BalanceRatioSelector", 0x414,
                             enumeration("BalanceRatioSelector", entry("Red", 0) + entry("Blue", 1) +
                                                                     "<pSelected>BalanceRatio</pSelected>")) +
               of_selected("BalanceRatio", 0x420, "BalanceRatioSelector",
                           "<Integer Name=\"BalanceRatio\"><pValue>BalanceRatioRegister</pValue>"
                           "<Min>0</Min><Max>4000</Max></Integer>") +
               with_register("LineSelector", 0x418,
                             enumeration("LineSelector", entry("Line0", 0) + entry("Line1", 1) +
                                                             "<pSelected>LineInverter</pSelected>")) +
               of_selected("LineInverter", 0x430, "LineSelector", on_or_off("LineInverter")));
    path_ = (std::filesystem::temp_directory_path() / "ssl-visiond-camera.XXXXXX").string();
    const int file = ::mkstemp(path_.data());
    const bool is_written = file >= 0 && ::write(file, text.data(), text.size()) == ssize_t(text.size());
    if (file >= 0) ::close(file);
    if (!is_written) throw std::runtime_error(path_ + " cannot be written");
    arv_set_fake_camera_genicam_filename(path_.c_str());
  }
  ~Description() { ::unlink(path_.c_str()); }
  Description(const Description&) = delete;
  Description& operator=(const Description&) = delete;

 private:
  std::string path_;
};

}  // namespace

struct GigeServer::Library {
  Fill fill;
  PixelFormat format = PixelFormat::kMono8;
  std::uint32_t packed_format = 0;
  Pack pack;
  ArvGvFakeCamera* server = nullptr;

  ArvFakeCamera* camera() const { return arv_gv_fake_camera_get_fake_camera(server); }
  void fill_buffer(std::uint8_t* out, int width, int height, ArvPixelFormat pixels) {
    if (pack && pixels == packed_format) {
      std::vector<std::uint8_t> bytes(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
      fill(bytes.data(), width, height, format);
      return pack(bytes.data(), bytes.size(), out);
    }
    for (const auto& [format_of_ours, arv] : kArvFormats)
      if (arv == pixels) fill(out, width, height, format_of_ours);
  }
  ~Library() {
    if (server != nullptr) g_object_unref(server);
  }
};

GigeServer::GigeServer(const std::string& interface_address, const std::string& serial, Fill fill)
    : library_(std::make_unique<Library>()) {
  wait_for_port(interface_address);
  static const Description description;  // the library reads it once
  library_->fill = std::move(fill);
  library_->server = arv_gv_fake_camera_new(interface_address.c_str(), serial.c_str());
  if (!arv_gv_fake_camera_is_running(library_->server)) {
    throw std::runtime_error("no GigE Vision camera can be played on " + interface_address +
                             ": it must be an IPv4 address of this machine");
  }
  const auto on_fill = [](ArvBuffer* buffer, void* library, guint32, guint32, ArvPixelFormat pixels) {
    // The size that the library reports here is 0; the memory suffices for the image that the client has set.
    std::size_t size = 0;
    auto* out = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &size)));
    static_cast<Library*>(library)->fill_buffer(out, arv_buffer_get_image_width(buffer),
                                                arv_buffer_get_image_height(buffer), pixels);
  };
  arv_fake_camera_set_fill_pattern(library_->camera(), on_fill, library_.get());
}

GigeServer::~GigeServer() = default;

void GigeServer::set_defaults(int width, int height, PixelFormat format, double frame_rate_hz) {
  const auto write = [&](guint32 address, std::uint32_t value) {
    arv_fake_camera_write_register(library_->camera(), address, value);
  };
  const auto* known = std::find_if(kArvFormats.begin(), kArvFormats.end(),
                                   [=](const auto& one) { return one.first == format; });
  if (known == kArvFormats.end()) {
    throw std::runtime_error(
        fmt::format("pixel_format {}: only mono8, rgb24 and bayer_* can be served", name_of(format)));
  }
  library_->format = format;
  write(ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT, known->second);
  write(ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, static_cast<std::uint32_t>(width));
  write(ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, static_cast<std::uint32_t>(height));
  write(ARV_FAKE_CAMERA_REGISTER_WIDTH, static_cast<std::uint32_t>(width));
  write(ARV_FAKE_CAMERA_REGISTER_HEIGHT, static_cast<std::uint32_t>(height));
  write(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
        static_cast<std::uint32_t>(1e6 / frame_rate_hz));
}

void GigeServer::send_packed(std::uint32_t format, Pack pack) {
  library_->pack = std::move(pack);
  library_->packed_format = format;
  arv_fake_camera_write_register(library_->camera(), ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT, format);
}

void GigeServer::set_heartbeat(double heartbeat_s) {
  constexpr guint64 kHeartbeatTimeout_ms = 0x0938;  // of GigE Vision's bootstrap registers
  arv_fake_camera_write_register(library_->camera(), kHeartbeatTimeout_ms,
                                 static_cast<std::uint32_t>(heartbeat_s * 1e3));
}

void GigeServer::set_exposure(int exposure_us) {
  arv_fake_camera_write_register(library_->camera(), ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US,
                                 static_cast<std::uint32_t>(exposure_us));
}

void GigeServer::lose_packets(double ratio) {
  g_object_set(library_->server, "gvsp-lost-ratio", ratio, nullptr);
}

}  // namespace sslv
