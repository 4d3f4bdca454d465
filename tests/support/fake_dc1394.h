// SPDX-License-Identifier: Apache-2.0
#pragma once

// A substitute for libdc1394: the same C functions, for fake cameras that a test plugs in. It follows the
// library's headers and, for everything that they leave open, version 2.2.6 on Linux:
//  - buffers are handed out in ring order, whichever of them the card has filled;
//  - a frame for which no buffer is queued is silently lost;
//  - once a camera is gone, stopping its capture fails and leaks memory and file;
//  - a lack of bandwidth is reported as a lack of channels.
// Nothing happens automatically: the test sends the frames, so no test waits for time to pass.

#include "image/color.h"

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <dc1394/dc1394.h>

namespace sslv::fake_iidc {

struct Feature {
  std::uint32_t min = 0, max = 1023;
  std::array<std::uint32_t, 3> values{};  // or blue/U, red/V; or red, green, blue; or target and current
  std::vector<dc1394feature_mode_t> modes{DC1394_FEATURE_MODE_MANUAL};
  dc1394feature_mode_t mode = DC1394_FEATURE_MODE_MANUAL;
  bool readable = true, switchable = false, on = true;
  bool absolute = false, absolute_on = false;
  float absolute_min = 0, absolute_max = 0, absolute_value = 0;
  dc1394error_t refusal = DC1394_SUCCESS;  // result of setting it

  // Only for the trigger.
  std::vector<dc1394trigger_mode_t> trigger_modes{};
  dc1394trigger_mode_t trigger_mode = DC1394_TRIGGER_MODE_0;
  std::vector<dc1394trigger_source_t> sources{};
  dc1394trigger_source_t source = DC1394_TRIGGER_SOURCE_0;
  bool polarity_capable = false;
  dc1394trigger_polarity_t polarity = DC1394_TRIGGER_ACTIVE_LOW;
};

struct Format7 {
  std::uint32_t max_width = 0, max_height = 0;
  std::uint32_t unit_width = 4, unit_height = 2, unit_x = 2, unit_y = 2;
  std::vector<dc1394color_coding_t> codings{};
  std::uint32_t unit_packet = 4, max_packet = 4096, recommended_packet = 4096;
  std::optional<dc1394color_filter_t> filter{};  // none: unknown
  // Current settings.
  dc1394color_coding_t coding = DC1394_COLOR_CODING_MONO8;
  std::uint32_t left = 0, top = 0, width = 0, height = 0, packet = 0;
};

struct Camera {
  std::uint64_t guid = 0;
  std::string vendor = "Fake", model = "Camera";
  std::map<dc1394video_mode_t, std::vector<dc1394framerate_t>> native{};
  std::map<dc1394video_mode_t, Format7> format7{};
  std::map<dc1394feature_t, Feature> features{};
  bool can_1394b = false;
  int memory_channels = 0;
  std::uint32_t data_depth = 8;  // of 16-bit codings
  const char* platform = "juju";
  // Current settings.
  dc1394video_mode_t mode = DC1394_VIDEO_MODE_640x480_MONO8;
  dc1394framerate_t rate = DC1394_FRAMERATE_15;
  dc1394speed_t speed = DC1394_ISO_SPEED_100;
  dc1394operation_mode_t operation = DC1394_OPERATION_MODE_LEGACY;
  bool sending = false;
  int loaded_channel = -1, saved_channel = -1;
};

/// A typical league camera: 780x580 in Format7_0, some fixed modes, and every kind of feature.
Camera league_camera(std::uint64_t guid);

/// Unplugs everything and resets the counts.
void clear();
void plug_in(const Camera& camera);
/// From now on the camera's handles fail, and threads waiting for a frame wake up.
void unplug(std::uint64_t guid);
/// A bus reset after which the camera still answers but no longer sends.
void stop_by_bus_reset(std::uint64_t guid);

struct Send {
  bool corrupt = false;
  std::uint64_t timestamp_us = 0;  // Unix time; 0: now
};
/// The camera sends a frame. Returns its number for colour_at(); -1: it is not sending.
int send(std::uint64_t guid, const Send& how = {});
/// What the sensor sees: squares of 8 pixels.
Rgb colour_at(int x, int y, int number);

/// The current state of a plugged camera.
Camera state_of(std::uint64_t guid);

struct Counts {
  int handles = 0;    // open cameras
  int captures = 0;   // set up and not stopped
  int overflows = 0;  // frames for which there was no buffer
  int bus_resets = 0;
};
Counts counts();

}  // namespace sslv::fake_iidc
