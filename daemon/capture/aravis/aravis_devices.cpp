// SPDX-License-Identifier: Apache-2.0
#include "capture/aravis/aravis_devices.h"

#include <array>
#include <chrono>
#include <mutex>
#include <optional>

#include <arpa/inet.h>
#include <fmt/format.h>

namespace sslv {
namespace {

using Clock = std::chrono::steady_clock;

struct Device {
  std::string id, physical_id, address, vendor, model, serial, protocol;
};

/// The cameras that answer a search. Takes about a second, because the library waits for late answers; camera
/// threads that start together share one search.
std::vector<Device> find_devices() {
  constexpr std::chrono::milliseconds kFresh(300);
  static std::mutex mutex;  // also guards the library's list, which is read by index
  static std::vector<Device> devices;
  static std::optional<Clock::time_point> searched;
  const std::lock_guard lock(mutex);
  if (searched && Clock::now() - *searched < kFresh) return devices;
  arv_update_device_list();
  devices.clear();
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    devices.push_back({text_or_empty(arv_get_device_id(i)), text_or_empty(arv_get_device_physical_id(i)),
                       text_or_empty(arv_get_device_address(i)), text_or_empty(arv_get_device_vendor(i)),
                       text_or_empty(arv_get_device_model(i)), text_or_empty(arv_get_device_serial_nbr(i)),
                       text_or_empty(arv_get_device_protocol(i))});
  }
  searched = Clock::now();
  return devices;
}

/// The name with which Aravis opens a device. With several network cards the address is safer than the id,
/// for which the library may choose the wrong card.
std::string handle_of(const Device& device) {
  return device.protocol == "GigEVision" ? device.address : device.id;
}
}  // namespace

AravisHandle resolve_aravis_camera(const std::string& camera) {
  in_addr address{};
  if (inet_pton(AF_INET, camera.c_str(), &address) == 1) return {camera};
  std::string found;
  for (const Device& device : find_devices()) {
    if (camera.empty() || camera == device.serial || camera == device.id || camera == device.physical_id) {
      return {handle_of(device), device.protocol == "GigEVision" ? device.serial : ""};
    }
    found += fmt::format("{}\"{}\" ({})", found.empty() ? "" : ", ", device.serial, device.id);
  }
  if (found.empty()) throw CaptureError(fmt::format("camera \"{}\": no camera answers", camera));
  throw CaptureError(fmt::format("camera \"{}\": not found; available: {}", camera, found));
}

void check_aravis_serial(ArvCamera* camera, const AravisHandle& handle) {
  constexpr guint64 kSerialRegister = 0xd8;  // GigE Vision bootstrap register of the serial number
  if (handle.serial.empty()) return;
  std::array<char, 17> serial{};
  Failure failure;
  arv_device_read_memory(arv_camera_get_device(camera), kSerialRegister, serial.size() - 1, serial.data(),
                         failure);
  failure.require_answer(handle.serial);
  if (!failure.failed() && handle.serial != serial.data()) {
    throw CaptureError(fmt::format("camera \"{}\": another camera has its address now", handle.serial));
  }
}

std::vector<FoundCamera> list_aravis_cameras() {
  std::vector<FoundCamera> out;
  for (const Device& device : find_devices()) {
    const std::string& known_by = device.serial.empty() ? device.id : device.serial;
    FoundCamera& found = out.emplace_back();
    found.name = fmt::format("{} {} {} ({}, {})", device.vendor, device.model, device.serial, device.protocol,
                             device.address.empty() ? device.physical_id : device.address);
    found.source = {{"backend", "aravis"}, {"camera", known_by}};
    found.model = device.vendor + ' ' + device.model;
    found.serial = device.serial;
    found.other_names = {device.id, device.physical_id, device.address};
  }
  return out;
}

}  // namespace sslv
