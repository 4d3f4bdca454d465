// SPDX-License-Identifier: Apache-2.0
// libFuzzer: whatever packets are sent from a GigE camera's address beside its own, the camera's images keep
// arriving and none contains other memory. Uses the whole library, over loopback. An input is a sequence of
// packets, each preceded by a byte that selects its form (as it is, or a leader, trailer, block or piece with
// numbers from the following bytes) and a length of two bytes. ./run test-long
#include "base/clock.h"
#include "capture/aravis/aravis.h"
#include "fuzz/expect.h"
#include "fuzz/live_bytes.h"
#include "support/becomes.h"
#include "support/gige_server.h"
#include "support/gvsp_packets.h"

#include <algorithm>
#include <memory>
#include <span>

namespace sslv {

unsigned seen = 0;  // keeps the compiler from removing the reads

namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr std::uint8_t kOurs = 7;

struct Camera {
  Camera() {
    server.set_defaults(kWidth, kHeight, PixelFormat::kMono8, 200);
    open();
  }

  void open() {
    source.reset();
    const Json options{{"camera", "127.0.0.1"},
                       {"chunks", true},
                       {"use_incomplete", true},
                       {"silence_s", test::kPatience.count()}};
    test::becomes([&] {
      try {
        source = aravis_backend().open(aravis_backend().complete(options, ""), {});
      } catch (const CaptureError&) {  // it answered too late
      }
      return source != nullptr;
    });
    port = forger.stream_port_of("127.0.0.1");
  }

  /// Reads all waiting images; returns how many of them are the camera's own.
  int look() {
    // A busy computer may pause this program for longer than a camera's heartbeat timeout.
    constexpr double kHeldUp_s = 1, kLately_s = 10;
    const double now_s = steady_s();
    if (now_s - looked_s > kHeldUp_s) held_up_s = now_s;
    looked_s = now_s;
    int own = 0;
    for (;;) {
      CapturedImage image;
      std::string problem;
      const CaptureStatus status = source->next(image, problem, std::chrono::milliseconds(0));
      if (status == CaptureStatus::kLost && now_s - held_up_s < kLately_s) {
        open();
        return own;
      }
      expect(status != CaptureStatus::kLost, "the camera is lost");
      if (status == CaptureStatus::kTimeout) return own;
      if (status != CaptureStatus::kImage) continue;
      const ImageView& view = image.image.view();
      for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width * bytes_per_pixel(view.format); ++x) seen += view.row(y)[x];
      }
      own += view.width == kWidth && view.row(0)[0] == kOurs ? 1 : 0;
    }
  }

  GigeServer server{"127.0.0.1", "FUZZED",
                    [](std::uint8_t* pixels, int width, int height, PixelFormat format) {
                      std::fill_n(pixels, width * height * bytes_per_pixel(format), kOurs);
                    }};
  std::unique_ptr<Source> source;
  test::UdpForger forger;
  std::uint16_t port = 0;
  double looked_s = steady_s(), held_up_s = 0;
  std::uint64_t frame = 0x4000;  // far from the camera's own numbers, which would otherwise count as late
};

std::string packet_of(std::uint8_t how, std::uint64_t frame, std::string_view data) {
  using namespace test;
  const auto number = [&](std::size_t at) {
    std::uint32_t out = 0;
    for (std::size_t i = at; i < std::min(at + 4, data.size()); ++i)
      out = out << 8 | static_cast<std::uint8_t>(data[i]);
    return out;
  };
  const std::string rest(data.substr(std::min<std::size_t>(data.size(), 4)));
  const bool is_extended = how % 2 == 1;
  const auto packet = [&](GvspKind kind, std::uint32_t id, const std::string& behind,
                          std::uint8_t parts = 0) {
    return is_extended ? gvsp_extended_packet(kind, frame, id, behind, parts)
                       : gvsp_packet(kind, static_cast<std::uint16_t>(frame), id, behind);
  };
  switch (how / 2 % 7) {
    case 0: return std::string(data);
    case 1: return packet(GvspKind::kLeader, 0, rest);
    case 2:
      return packet(GvspKind::kLeader, 0,
                    gvsp_image_leader(number(0) & 0xffff, number(2) & 0xffff, kGvspMono8,
                                      static_cast<std::uint16_t>(1 + number(4) % 12), how));
    case 3:
      return packet(GvspKind::kLeader, 0,
                    gvsp_multipart_leader({{number(0) & 0xff, number(1) & 0xff, number(2) & 0xffff},
                                           {number(4), number(8), number(12)}}),
                    static_cast<std::uint8_t>(how % 3));
    case 4: return packet(GvspKind::kTrailer, number(0) & 0xff, rest);
    case 5: return packet(GvspKind::kPayload, number(0) & 0x7, rest);
    default: return packet(GvspKind::kMultipart, number(0) & 0xff, gvsp_piece(number(2), rest));
  }
}

}  // namespace
}  // namespace sslv

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sslv;
  static Camera camera;
  const LiveBytes live(kMaxLiveBytes);
  static int inputs = 0;
  std::string_view rest(reinterpret_cast<const char*>(bytes), size);
  ++camera.frame;
  while (rest.size() >= 3) {
    const auto byte = [&](std::size_t at) { return static_cast<std::uint8_t>(rest[at]); };
    const std::size_t length = std::min<std::size_t>(byte(1) + 256U * byte(2), rest.size() - 3);
    camera.forger.send(camera.port, packet_of(byte(0), camera.frame, rest.substr(3, length)));
    rest.remove_prefix(3 + length);
  }
  camera.look();
  if (++inputs % 1024 == 0)
    expect(test::becomes([&] { return camera.look() > 0; }), "its own images do not come");
  return 0;
}
