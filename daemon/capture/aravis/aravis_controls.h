// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/aravis/aravis_library.h"
#include "capture/controls.h"

#include <atomic>
#include <memory>
#include <mutex>

namespace sslv {

/// An open camera. The thread that takes its images and the threads that set its controls share it. The
/// library's feature tree is for one thread at a time.
struct AravisCamera {
  std::mutex mutex;  // guards the camera's features
  Object<ArvCamera> camera;
  bool is_streaming = false;                     // guarded
  bool is_closed = false;                        // guarded
  std::atomic<double> exposure_s{0};             // as it was last read; 0: not known
  std::atomic<bool> may_exposure_change{false};  // it is automatic, or was not answered
};

/// All features of the camera's GenICam description that somebody may see.
std::shared_ptr<Controls> aravis_controls(std::shared_ptr<AravisCamera> camera);

/// The exposure time as the camera has it now, kept in `camera`; its mutex must be held. If the camera does
/// not answer, what was known stays until it is asked again.
void read_exposure(AravisCamera& camera);

}  // namespace sslv
