// SPDX-License-Identifier: Apache-2.0
#pragma once

// Interface of the cameras for other services.

#include "capture/camera_thread.h"
#include "config/config.h"
#include "pipeline/camera_pipeline.h"
#include "services/cameras/fresh_frames.h"
#include "services/cameras/recorded_camera.h"

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sslv {

/// The state of a camera at one moment.
struct CameraNow {
  int id = 0;
  std::shared_ptr<const CameraSettings> settings;
  std::shared_ptr<const CameraSetup> setup;
  CameraHealth health;

  const CameraContext& context() const { return setup->context; }
};

/// Receives notifications when cameras change.
class CameraObserver {
 public:
  virtual ~CameraObserver() = default;
  /// These cameras now show something else or were removed: everything derived from their images is invalid.
  /// Called while a change is applied: must return quickly.
  virtual void cameras_changed(const std::set<int>& camera_ids) noexcept = 0;
};

/// Thread-safe.
class Cameras {
 public:
  virtual ~Cameras() = default;

  virtual std::vector<CameraNow> all() const = 0;
  /// Throws HttpError 404 if there is no such camera.
  virtual CameraNow get(int camera_id) const = 0;

  /// See WaitFrame.
  virtual std::optional<LentFrame> wait_frame(int camera_id, std::uint64_t newer_than,
                                              std::chrono::milliseconds timeout) = 0;

  /// The next frame uses `adapted`, the accepted table adapted to the light. Returns false if `accepted` is
  /// no longer the accepted table.
  virtual bool change_light(int camera_id, const std::shared_ptr<const Lut>& accepted,
                            std::shared_ptr<const Lut> adapted) = 0;

  /// The recorders of the cameras' last seconds, by camera id.
  virtual std::map<int, std::shared_ptr<RecordedCamera>> recorded() const = 0;

  /// `observer` must outlive this object, or at least all changes of settings.
  virtual void add_observer(CameraObserver& observer) = 0;

  /// hanging() returns the reason for restarting the service. missing() returns a line for each camera that
  /// is not running, with the reason. Both are empty if there is no problem.
  virtual std::string hanging() const = 0;
  virtual std::string missing() const = 0;
};

/// For jobs that need a camera's frames.
inline WaitFrame frames_of(Cameras& cameras) {
  return [&cameras](int camera_id, std::uint64_t newer_than, std::chrono::milliseconds timeout) {
    return cameras.wait_frame(camera_id, newer_than, timeout);
  };
}

}  // namespace sslv
