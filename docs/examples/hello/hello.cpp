// SPDX-License-Identifier: Apache-2.0
// A stage in ten minutes: removes balls that lie outside the lines, and reports their number.
#include <cmath>
#include <cstdio>

#include <kit/stages.h>

class Hello {
 public:
  // The stage's settings. Each line defines a range, a default, a help text and a field in the panel.
  struct Params {
    double margin_mm = 100;
    static constexpr auto fields() {
      return std::tuple{
          sslv::number("margin_mm", &Params::margin_mm, 0.0, 10'000.0, "mm", "balls may be outside by")};
    }
  };

  // The arguments are what the stage needs: the field, the detected balls (Update: to change them), a line
  // for the admin. Runs for each image on the camera's thread, so it must neither block nor throw.
  void process(const Params& params, const sslv::Scene& scene, sslv::Update<sslv::BallList> balls,
               sslv::StageNotes& notes) noexcept {
    const double max_x_mm = scene.field.field_length / 2.0 + params.margin_mm;
    const double max_y_mm = scene.field.field_width / 2.0 + params.margin_mm;
    removed_ += std::erase_if(balls->balls, [&](const sslv::Ball& ball) {
      return std::abs(ball.x_mm) > max_x_mm || std::abs(ball.y_mm) > max_y_mm;
    });
    std::array<char, 64> text;  // a std::string would allocate for each image
    std::snprintf(text.data(), text.size(), "%zu balls removed", removed_);
    notes.say(text.data());
  }

 private:
  std::size_t removed_ = 0;  // a member keeps its value from image to image
};
SSLV_STAGES(sslv::stage<Hello>("hello", "removes balls outside the lines"))
