// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/aravis/aravis_library.h"
#include "capture/controls.h"

#include <atomic>
#include <memory>
#include <mutex>

namespace sslv {

/// An open camera, shared by the thread that receives its images and the threads that set its controls. The
/// library's feature tree is not thread-safe.
struct AravisCamera {
  std::mutex mutex;  // guards the camera's features
  Object<ArvCamera> camera;
  bool is_streaming = false;                     // guarded by mutex
  bool is_closed = false;                        // guarded by mutex
  std::atomic<double> exposure_s{0};             // as last read; 0: unknown
  std::atomic<bool> may_exposure_change{false};  // the exposure is automatic, or the camera did not answer
};

/// Controls for all visible features of the camera's GenICam description.
std::shared_ptr<Controls> aravis_controls(std::shared_ptr<AravisCamera> camera);

/// Reads the exposure time into `camera`, whose mutex must be held. If the camera does not answer, keeps the
/// old value until the next call.
void read_exposure(AravisCamera& camera);

}  // namespace sslv
