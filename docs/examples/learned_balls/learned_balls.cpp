// SPDX-License-Identifier: Apache-2.0
// A small neural network decides which candidates are balls. Set detect_balls to let doubtful balls pass
// (min_confidence); record_patches writes the training images, and train.py makes balls.onnx from them.
#include "../metric_patch.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include <dlfcn.h>
#include <opencv2/dnn.hpp>

using namespace sslv;

class LearnedBalls {
 public:
  struct Params {
    double min_confidence = 0.5;
    static constexpr auto fields() {
      return std::tuple{
          number("min_confidence", &Params::min_confidence, 0.0, 1.0, "", "balls below it are not reported"),
      };
    }
  };

  /// Reads balls.onnx from this library's folder, because the two are copied together. If a constructor
  /// throws, the service runs without this library and shows the admin the error.
  LearnedBalls() {
    Dl_info self{};
    dladdr(&kSideMm, &self);  // any address in this library
    const auto file = std::filesystem::path(self.dli_fname).replace_filename("balls.onnx");
    if (!std::filesystem::exists(file)) throw std::runtime_error("there is no " + file.string());
    net_ = cv::dnn::readNetFromONNX(file.string());
    cv::setNumThreads(1);  // the calling thread: the camera's
    judge(Patch{});        // OpenCV allocates the network's memory now instead of at the first ball
  }

  void process(const Params& params, const Scene& scene, const Image& image, Update<BallList> list,
               StageNotes& notes) noexcept {
    if (!scene.camera || image.view().empty()) return notes.clear();
    try {
      for (Ball& ball : list->balls) {
        ball.confidence = judge(metric_patch(image.view(), *scene.camera, ball.x_mm, ball.y_mm,
                                             scene.field.ball_radius, kSideMm));
      }
    } catch (const cv::Exception& error) {
      return notes.warn(error.what());  // a stage must not throw
    }
    std::erase_if(list->balls, [&](const Ball& ball) { return ball.confidence < params.min_confidence; });
    std::ranges::sort(list->balls, std::ranges::greater(), &Ball::confidence);
    notes.clear();
  }

 private:
  static constexpr double kSideMm = 100;  // as in the recorded patches

  /// Confidence that this is a ball, 0 .. 1. OpenCV allocates a little memory each time.
  double judge(const Patch& patch) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(patch.data());
    std::transform(bytes, bytes + sizeof patch, input_.begin<float>(),
                   [](std::uint8_t level) { return static_cast<float>(level) / 255; });
    net_.setInput(input_);
    return net_.forward().at<float>(0);
  }

  cv::dnn::Net net_;
  cv::Mat input_ = cv::Mat(1, static_cast<int>(sizeof(Patch)), CV_32F);
};
SSLV_STAGES(stage<LearnedBalls>("learned_balls", "judges balls with a network that was trained"))
