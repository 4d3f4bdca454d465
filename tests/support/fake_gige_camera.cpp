// SPDX-License-Identifier: Apache-2.0
// A GigE Vision camera that serves simulated or recorded images:
//
//   fake_gige_camera INTERFACE_ADDRESS SERIAL FILE
//
// FILE is JSON with "source" and "calibration" as in a camera of the daemon's settings and "field" as in the
// settings; the last two are optional. "lost_packets": fraction of packets that are lost; "heartbeat_s": how
// long its client may be silent.
// Prints "ready" when it serves; stops on SIGINT or SIGTERM.

#include "base/params_json.h"
#include "capture/files/file.h"
#include "capture/simulator/simulator.h"
#include "support/gige_server.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <string>

#include <signal.h>

namespace sslv {
namespace {

struct Setup {
  Json source = Json::object();
  std::optional<CameraCalibration> calibration;
  FieldSize field;
  double lost_packets = 0, heartbeat_s = 3;
  static constexpr auto fields() {
    return std::tuple{
        object("source", &Setup::source, "\"backend\" and its options"),
        group("calibration", &Setup::calibration, "what a simulated camera sees"),
        group("field", &Setup::field, "what a simulated camera looks at"),
        number("lost_packets", &Setup::lost_packets, 0.0, 1.0, "", "share that gets lost"),
        number("heartbeat_s", &Setup::heartbeat_s, 0.5, 3600.0, "s", "how long its client may be silent")};
  }
};

Setup read_setup(const char* path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(std::string(path) + " cannot be read");
  return params_from_json<Setup>(Json::parse(file), path);
}

/// A source that is paced by the camera's client; `frame_rate_hz` receives its rate in the settings, or 30.
std::unique_ptr<Source> open_source(const Setup& setup, double& frame_rate_hz) {
  Json options = setup.source;
  const std::string name = options.at("backend").get<std::string>();
  options.erase("backend");
  const std::array backends{simulator_backend(), file_backend()};
  const auto backend =
      std::find_if(backends.begin(), backends.end(), [&](const Backend& one) { return one.name == name; });
  if (backend == backends.end()) throw std::runtime_error("source/backend: \"simulator\" or \"files\"");
  options = backend->complete(options, "source");
  const Json& rate = options.at("frame_rate_hz");
  frame_rate_hz = rate.is_number() && rate > 0 ? rate.get<double>() : 30;
  options["frame_rate_hz"] = 0;
  SourceContext context;
  context.scene.field = setup.field;
  if (setup.calibration) context.scene.camera.emplace(*setup.calibration);
  return backend->open(options, context);
}

/// Waits for a complete image; throws std::runtime_error if the source has ended or failed.
CapturedImage take(Source& source) {
  for (;;) {
    CapturedImage image;
    std::string problem;
    switch (source.next(image, problem, std::chrono::milliseconds(1000))) {
      case CaptureStatus::kImage: return image;
      case CaptureStatus::kTimeout: break;
      case CaptureStatus::kIncomplete: std::fprintf(stderr, "%s\n", problem.c_str()); break;
      case CaptureStatus::kEnd: throw std::runtime_error("the recording has ended; set \"loop\"");
      case CaptureStatus::kLost: throw std::runtime_error(problem);
    }
  }
}

/// The image in the client's size and format; black if these differ from the source's.
void fill(Source& source, std::uint8_t* pixels, int width, int height, PixelFormat format) {
  const auto row_bytes = static_cast<std::size_t>(width) * static_cast<std::size_t>(bytes_per_pixel(format));
  try {
    const CapturedImage captured = take(source);
    const ImageView& view = captured.image.view();
    if (view.format != format || view.width != width || view.height != height) {
      std::memset(pixels, 0, row_bytes * static_cast<std::size_t>(height));
      return;
    }
    for (int y = 0; y < height; ++y) {
      std::memcpy(pixels + static_cast<std::size_t>(y) * row_bytes, view.row(y), row_bytes);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "no picture: %s\n", error.what());
  }
}

void serve(const char* address, const char* serial, const char* path) {
  double frame_rate_hz = 0;
  const Setup setup = read_setup(path);
  const std::unique_ptr<Source> source = open_source(setup, frame_rate_hz);
  const CapturedImage first = take(*source);
  const ImageView& view = first.image.view();

  // Before the library starts threads, which inherit the signal mask.
  sigset_t ending;
  sigemptyset(&ending);
  sigaddset(&ending, SIGINT);
  sigaddset(&ending, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ending, nullptr);

  GigeServer server(address, serial, [&](std::uint8_t* pixels, int width, int height, PixelFormat format) {
    fill(*source, pixels, width, height, format);
  });
  server.set_defaults(view.width, view.height, view.format, frame_rate_hz);
  server.lose_packets(setup.lost_packets);
  server.set_heartbeat(setup.heartbeat_s);
  std::puts("ready");
  std::fflush(stdout);
  int signal = 0;
  sigwait(&ending, &signal);
}

}  // namespace
}  // namespace sslv

int main(int argument_count, char** arguments) {
  if (argument_count != 4) {
    std::fputs("usage: fake_gige_camera INTERFACE_ADDRESS SERIAL FILE\n", stderr);
    return 64;
  }
  try {
    sslv::serve(arguments[1], arguments[2], arguments[3]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fake_gige_camera: %s\n", error.what());
    return 1;
  }
}
