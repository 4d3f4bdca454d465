// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/cameras/cameras.h"

#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace sslv::test {

/// No cameras except those with an image ring.
class NoCameras final : public Cameras {
 public:
  std::map<int, std::shared_ptr<RecordedCamera>> recorded_ones;

  std::map<int, std::shared_ptr<RecordedCamera>> recorded() const override { return recorded_ones; }
  std::vector<CameraNow> all() const override { return {}; }
  CameraNow get(int) const override { throw std::logic_error("not asked for"); }
  std::optional<LentFrame> wait_frame(int, std::uint64_t, std::chrono::milliseconds) override { return {}; }
  bool change_light(int, const std::shared_ptr<const Lut>&, std::shared_ptr<const Lut>) override {
    return false;
  }
  void add_observer(CameraObserver&) override {}
  std::string hanging() const override { return {}; }
  std::string missing() const override { return {}; }
};

}  // namespace sslv::test
