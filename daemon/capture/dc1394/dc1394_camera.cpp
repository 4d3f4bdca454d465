// SPDX-License-Identifier: Apache-2.0
#include "capture/dc1394/dc1394_camera.h"

#include "base/log.h"
#include "capture/source.h"

#include <algorithm>
#include <charconv>
#include <mutex>

#include <fmt/format.h>

namespace sslv::iidc {
namespace {

/// Logs the library's messages at debug level only: failed calls report what matters.
void log_detail(dc1394log_t, const char* message, void*) {
  std::string_view text(message);
  while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  log::debug("libdc1394: {}", text);
}

}  // namespace

std::string text_of(std::uint64_t guid) {
  return fmt::format("{:016x}", guid);
}

std::optional<std::uint64_t> guid_of(std::string_view text) {
  if (text.starts_with("0x") || text.starts_with("0X")) text.remove_prefix(2);
  std::uint64_t guid = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), guid, 16);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return guid;
}

Context new_context() {
  static std::once_flag once;
  std::call_once(once, [] {
    for (const dc1394log_t type : {DC1394_LOG_ERROR, DC1394_LOG_WARNING})
      dc1394_log_register_handler(type, log_detail, nullptr);
  });
  return Context(dc1394_new());
}

std::vector<std::uint64_t> find_cameras(const Context& context) {
  dc1394camera_list_t* list = nullptr;
  if (!context || dc1394_camera_enumerate(context.get(), &list) != DC1394_SUCCESS || list == nullptr)
    return {};
  std::vector<std::uint64_t> guids;
  for (std::uint32_t i = 0; i < list->num; ++i) guids.push_back(list->ids[i].guid);
  dc1394_camera_free_list(list);
  return guids;
}

Handle open_camera(const std::string& guid) {
  Handle handle{new_context(), nullptr};
  const std::vector<std::uint64_t> found = find_cameras(handle.context);
  if (found.empty()) {
    throw CaptureError(fmt::format(
        "camera \"{}\": no IIDC camera found; is it plugged in, and may this user open /dev/fw*?", guid));
  }
  const std::uint64_t wanted = guid.empty() ? found.front() : guid_of(guid).value_or(0);
  if (std::find(found.begin(), found.end(), wanted) == found.end()) {
    std::string there;
    for (const std::uint64_t one : found) there += (there.empty() ? "" : ", ") + text_of(one);
    throw CaptureError(fmt::format("camera \"{}\": not found; available: {}", guid, there));
  }
  handle.camera.reset(dc1394_camera_new(handle.context.get(), wanted));
  if (!handle.camera) throw CaptureError(fmt::format("camera \"{}\": does not answer", text_of(wanted)));
  return handle;
}

void check(dc1394error_t error, std::string_view label, std::string_view what) {
  if (error == DC1394_SUCCESS) return;
  throw CaptureError(fmt::format("camera \"{}\": {}: {}", label, what, dc1394_error_get_string(error)));
}

std::vector<dc1394video_mode_t> modes_of(dc1394camera_t* camera, std::string_view label) {
  dc1394video_modes_t all{};
  check(dc1394_video_get_supported_modes(camera, &all), label, "its modes cannot be read");
  std::vector<dc1394video_mode_t> modes;
  for (std::uint32_t i = 0; i < all.num; ++i) {
    const dc1394video_mode_t mode = all.modes[i];
    if (mode != DC1394_VIDEO_MODE_EXIF && !codings_of(camera, mode, label).empty()) modes.push_back(mode);
  }
  return modes;
}

std::vector<dc1394color_coding_t> codings_of(dc1394camera_t* camera, dc1394video_mode_t mode,
                                             std::string_view label) {
  dc1394color_codings_t all{};
  if (is_format7(mode)) {
    check(dc1394_format7_get_color_codings(camera, mode, &all), label, "its pixel formats cannot be read");
  } else {
    all.num = 1;
    check(dc1394_get_color_coding_from_video_mode(camera, mode, &all.codings[0]), label,
          "its pixel formats cannot be read");
  }
  std::vector<dc1394color_coding_t> codings;
  for (const auto& [name, coding] : kCodings) {
    if (std::find(all.codings, all.codings + all.num, coding) != all.codings + all.num)
      codings.push_back(coding);
  }
  return codings;
}

}  // namespace sslv::iidc
