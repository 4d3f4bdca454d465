// SPDX-License-Identifier: Apache-2.0
// Writes a small PPM image of each detected ball (and robot), to train detectors with. File names:
// KIND_CAMERA_FRAME_X_Y_CONFIDENCE.ppm, with the position in mm.
#include "../metric_patch.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include <base/futex.h>
#include <base/slot_queue.h>

using namespace sslv;

class RecordPatches {
 public:
  struct Params {
    bool robots = false;
    double side_mm = 100;
    static constexpr auto fields() {
      return std::tuple{flag("robots", &Params::robots, "robots too, not only balls"),
                        number("side_mm", &Params::side_mm, 10.0, 1'000.0, "mm", "side of the square")};
    }
  };

  void process(const Params& params, const FrameInfo& info, const Image& image, const Scene& scene,
               const RobotList& robots, const BallList& balls, StageNotes& notes) noexcept {
    if (folder_.empty()) return notes.warn("the environment has no SSLV_PATCHES, the folder to write to");
    if (!scene.camera || image.view().empty()) return notes.say("the camera is not calibrated");
    const auto record = [&](const char* kind, const auto& thing, double height_mm) {
      Record* slot = queue_.to_write();
      if (slot == nullptr) return void(++dropped_);  // the disk is too slow
      std::snprintf(slot->name.data(), slot->name.size(), "%s_%u_%06u_%.1f_%.1f_%.3f.ppm", kind,
                    info.camera_id, info.number, thing.x_mm, thing.y_mm, thing.confidence);
      slot->patch =
          metric_patch(image.view(), *scene.camera, thing.x_mm, thing.y_mm, height_mm, params.side_mm);
      queue_.write();
    };
    for (const Ball& ball : balls.balls) record("ball", ball, scene.field.ball_radius);
    if (params.robots)
      for (const Robot& robot : robots.robots) record("robot", robot, robot.height_mm);
    bell_.ring();
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%zu dropped%s", dropped_, is_failing_ ? ", cannot write" : "");
    is_failing_ ? notes.warn(text.data()) : notes.say(text.data());
  }

 private:
  struct Record {
    std::array<char, 96> name;
    Patch patch;
  };

  /// Runs on a thread of its own, because a disk may hang, and the camera's thread must not wait for it.
  void write_all(const std::stop_token& stop) {
    for (bool is_last = false; !is_last;) {
      is_last = stop.stop_requested();  // then writes the rest of the queue first
      const std::uint32_t mark = bell_.mark();
      for (; const Record* one = queue_.to_read(); queue_.read()) {
        std::ofstream file(folder_ / one->name.data(), std::ios::binary);
        file << "P6\n" << kPatchSide << ' ' << kPatchSide << "\n255\n";
        file.write(reinterpret_cast<const char*>(one->patch.data()), sizeof one->patch).flush();
        is_failing_ = !file;
      }
      if (!is_last) bell_.wait(mark, std::chrono::steady_clock::now() + std::chrono::milliseconds(100));
    }
  }

  // Not a setting: a person who changes settings over the network must not choose a folder to write to.
  const char* const set_ = std::getenv("SSLV_PATCHES");
  const std::filesystem::path folder_{set_ == nullptr ? "" : set_};
  SlotQueue<Record, 1024> queue_;
  Bell bell_;
  std::size_t dropped_ = 0;
  std::atomic<bool> is_failing_{false};
  std::jthread writer_{[this](const std::stop_token& stop) { write_all(stop); }};  // last: destroyed first
};
SSLV_STAGES(stage<RecordPatches>("record_patches", "writes images of balls and robots for training"))
