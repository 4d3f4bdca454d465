// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/cameras/cameras.h"
#include "services/cameras/pictures.h"
#include "services/cameras/stills.h"
#include "services/service.h"

#include <optional>
#include <vector>

namespace sslv {

/// Keeps still images for viewing, for a while, and returns their pixel values.
class StillService final : public Service, public Pictures {
 public:
  /// `cameras` must outlive this.
  explicit StillService(Cameras& cameras) : cameras_(cameras) {}

  LentPicture look(int camera_id, std::optional<int> still) override;

  std::vector<Route> routes() override;
  void each_second() override { stills_.forget_old(); }

 private:
  Response get_pixels(const Request& request);
  Response take_still(const Request& request);
  Response get_picture(const Request& request);
  Response get_labels(const Request& request);

  Cameras& cameras_;
  Stills stills_;
};

}  // namespace sslv
