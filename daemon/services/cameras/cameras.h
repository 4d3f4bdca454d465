// SPDX-License-Identifier: Apache-2.0
#pragma once

// The cameras as other services see them.

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

/// A camera at one moment.
struct CameraNow {
  int id = 0;
  std::shared_ptr<const CameraSettings> settings;
  std::shared_ptr<const CameraSetup> setup;
  CameraHealth health;

  const CameraContext& context() const { return setup->context; }
};

/// Is told what becomes of cameras.
class CameraObserver {
 public:
  virtual ~CameraObserver() = default;
  /// These show something else from now on, or are gone: what is known of their images is void. Called while
  /// a change is applied: no long work.
  virtual void cameras_changed(const std::set<int>& camera_ids) noexcept = 0;
};

/// May be used from any thread.
class Cameras {
 public:
  virtual ~Cameras() = default;

  virtual std::vector<CameraNow> all() const = 0;
  /// Throws HttpError 404 for one that there is not.
  virtual CameraNow get(int camera_id) const = 0;

  /// See WaitFrame.
  virtual std::optional<LentFrame> wait_frame(int camera_id, std::uint64_t newer_than,
                                              std::chrono::milliseconds timeout) = 0;

  /// The next frame uses this table, which is the accepted one adapted to the light. False when that is no
  /// longer the accepted one.
  virtual bool change_light(int camera_id, const std::shared_ptr<const Lut>& accepted,
                            std::shared_ptr<const Lut> adapted) = 0;

  /// The last seconds of each camera, by its id.
  virtual std::map<int, std::shared_ptr<RecordedCamera>> recorded() const = 0;

  /// `observer` must outlive this, or all changes of settings.
  virtual void add_observer(CameraObserver& observer) = 0;

  /// Why the service must be restarted, and what is missing for all cameras to run, a line for each; both
  /// empty when all is well.
  virtual std::string hanging() const = 0;
  virtual std::string missing() const = 0;
};

/// For work that takes frames from a camera.
inline WaitFrame frames_of(Cameras& cameras) {
  return [&cameras](int camera_id, std::uint64_t newer_than, std::chrono::milliseconds timeout) {
    return cameras.wait_frame(camera_id, newer_than, timeout);
  };
}

}  // namespace sslv
