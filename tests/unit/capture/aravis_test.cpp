// SPDX-License-Identifier: Apache-2.0
#include "capture/aravis/aravis.h"

#include "base/clock.h"
#include "base/error.h"
#include "capture/aravis/aravis_images.h"
#include "capture/camera_thread.h"
#include "capture/control_queue.h"
#include "image/shared_memory.h"
#include "net/network_cards.h"
#include "support/allocation_count.h"
#include "support/becomes.h"
#include "support/gige_server.h"
#include "support/gvsp_packets.h"
#include "vision/disc_fit.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <latch>
#include <map>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include <dlfcn.h>
#include <gmock/gmock.h>

// The library's headers use implicit conversions of C.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#include <arv.h>
#pragma GCC diagnostic pop

namespace sslv::aravis_test {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

constexpr const char* kAddress = "127.0.0.1";
constexpr const char* kSerial = "SSLV01";

std::uint8_t pixel(int number, int place) {
  return static_cast<std::uint8_t>(7 * place + place / 251 + 31 * number);
}

/// A fake camera on the loopback interface. pixel() computes each image's pixels from its number.
class Gige : public testing::Test {
 protected:
  void SetUp() override { plug_in(); }

  void plug_in() {
    server_.emplace(kAddress, kSerial,
                    [this](std::uint8_t* pixels, int width, int height, PixelFormat format) {
                      const int number = sent_++;
                      const int bytes = width * height * bytes_per_pixel(format);
                      for (int i = 0; i < bytes; ++i) pixels[i] = pixel(number, i);
                    });
    server_->set_defaults(320, 240, PixelFormat::kBayerRg8, 100);
  }
  void pull_the_plug() { server_.reset(); }

  static std::unique_ptr<Source> open(Json options = Json::object()) {
    if (!options.contains("camera")) options["camera"] = kAddress;
    if (!options.contains("silence_s")) options["silence_s"] = test::kPatience.count();
    const Json complete = aravis_backend().complete(options, "");
    std::unique_ptr<Source> source;
    EXPECT_TRUE(test::becomes([&] {
      try {
        source = aravis_backend().open(complete, {});
      } catch (const CaptureError& error) {
        // The library waits one second for an answer; on a busy computer, it sometimes takes longer.
        if (std::string(error.what()).find("cannot be opened") == std::string::npos) throw;
      }
      return source != nullptr;
    }));
    return source;
  }
  static std::string refusal(const Json& options) {
    try {
      open(options);
    } catch (const CaptureError& error) {
      return error.what();
    }
    return "no error";
  }

  std::atomic<int> sent_{0};
  std::optional<GigeServer> server_;
};

/// The next status other than kTimeout.
CaptureStatus next(Source& source, CapturedImage& image, std::string& problem) {
  CaptureStatus status = CaptureStatus::kTimeout;
  test::becomes([&] {
    status = source.next(image, problem, milliseconds(100));
    return status != CaptureStatus::kTimeout;
  });
  return status;
}

/// The next complete image; skips damaged ones.
CapturedImage next_picture(Source& source) {
  CapturedImage image;
  std::string problem;
  CaptureStatus status = CaptureStatus::kTimeout;
  test::becomes([&] {
    status = next(source, image, problem);
    return status != CaptureStatus::kIncomplete;
  });
  EXPECT_EQ(status, CaptureStatus::kImage) << "no picture: " << problem;
  return image;
}

bool lacks_packets(CaptureStatus status, const std::string& problem) {
  return status == CaptureStatus::kIncomplete &&
         (problem == "packets are missing" || problem == "its last packets did not arrive");
}

void expect_our_pixels(const ImageView& view) {
  ASSERT_FALSE(view.empty());
  const int bytes = view.width * bytes_per_pixel(view.format);
  ASSERT_EQ(view.stride_bytes, bytes);
  int number = 0;
  while (number < 256 && pixel(number, 0) != view.data[0]) ++number;
  for (int i = 0; i < bytes * view.height; ++i) ASSERT_EQ(view.data[i], pixel(number, i)) << "byte " << i;
}

TEST_F(Gige, PicturesArriveUnchanged) {
  const auto source = open();
  for (int i = 0; i < 5; ++i) {
    const CapturedImage image = next_picture(*source);
    EXPECT_EQ(image.image.view().width, 320);
    EXPECT_EQ(image.image.view().height, 240);
    EXPECT_EQ(image.image.view().format, PixelFormat::kBayerRg8);
    expect_our_pixels(image.image.view());
  }
}

/// GenICam's "p" packing: lowest bits first.
GigeServer::Pack packed_p(std::size_t bits) {
  return [bits](const std::uint8_t* pixels, std::size_t count, std::uint8_t* packed) {
    std::fill_n(packed, count * bits / 8, std::uint8_t{0});
    for (std::size_t i = 0; i < count; ++i) {
      // A pattern below the upper eight bits.
      const unsigned value = (pixels[i] << (bits - 8)) | (i & ((1u << (bits - 8)) - 1));
      for (std::size_t bit = 0; bit < bits; ++bit) {
        const std::size_t place = i * bits + bit;
        packed[place / 8] = static_cast<std::uint8_t>(packed[place / 8] | (value >> bit & 1) << place % 8);
      }
    }
  };
}

/// Expects the pattern that packed_p() and similar functions write below the upper eight bits.
void expect_low_bits(const ImageView& view, std::size_t bits) {
  ASSERT_NE(view.to_low_bits, 0);
  const std::uint8_t* low = view.data + view.to_low_bits;
  const std::size_t low_bits = bits - 8;
  for (std::size_t i = 0; i < 320 * 240; ++i)
    ASSERT_EQ(low[i], (i & ((1U << low_bits) - 1)) << (8 - low_bits)) << "byte " << i;
}

TEST_F(Gige, ForgedPacketsShowNothingAndEndNothing) {
  using namespace test;
  const auto source = open({{"chunks", true}});
  next_picture(*source);
  const UdpForger forger;
  const std::uint16_t port = forger.stream_port_of(kAddress);
  constexpr std::uint32_t kBytes = 320 * 240;
  // Far from the camera's own frame ids: just below a forged one, they would count as late.
  std::uint64_t frame = 0x4000;
  bool was_refused = false;
  const auto expect_our_own = [&] {
    for (int own = 0; own < 3;) {
      CapturedImage image;
      std::string problem;
      const CaptureStatus status = next(*source, image, problem);
      ASSERT_NE(status, CaptureStatus::kLost) << problem;
      was_refused |= problem.starts_with("0 bytes arrived");
      if (status != CaptureStatus::kImage) continue;
      ++own;
      EXPECT_EQ(image.image.view().width, 320);
      expect_our_pixels(image.image.view());
    }
  };
  const auto send = [&](const std::vector<std::string>& packets) {
    for (const std::string& packet : packets) forger.send(port, packet);
    ++frame;
    expect_our_own();
  };
  const auto leader = [&](const std::string& data, std::uint8_t parts = 0) {
    return gvsp_extended_packet(GvspKind::kLeader, frame, 0, data, parts);
  };
  const auto trailer = [&](std::uint32_t id) { return gvsp_extended_packet(GvspKind::kTrailer, frame, id); };

  // Leaders that claim the buffer's size or more, without payload.
  // On a busy computer, the library sometimes drops such a frame before it is an image.
  EXPECT_TRUE(test::becomes([&] {
    send({leader(gvsp_multipart_leader({{320, 240, kBytes}}), 1), trailer(1)});
    return was_refused || HasFatalFailure();
  }));
  send({leader(gvsp_multipart_leader({{700, 700, 490'000}}), 1), trailer(1)});
  send({leader(gvsp_multipart_leader({{16384, 16384, 1U << 28}}), 1), trailer(1)});
  send({leader(gvsp_multipart_leader({{2, 2, kBytes}}), 1), trailer(1)});
  send({leader(gvsp_multipart_leader({{320, 240, kBytes, kGvspMono8, 10}}), 1), trailer(1)});
  send({leader(gvsp_image_leader(320, 240)), trailer(1)});
  send({leader(gvsp_image_leader(320, 240, kGvspMono8, kGvspImage, 65535)), trailer(1)});
  // Leaders that claim chunks, without payload.
  send({leader(gvsp_image_leader(320, 240, kGvspMono8, kGvspImage | kGvspWithChunks)), trailer(1)});
  send({leader(gvsp_multipart_leader({{320, 240, kBytes}}, kGvspMultipartImage | kGvspWithChunks), 1),
        trailer(1)});
  // Numbers from which the library computes sizes of memory and places to copy to.
  send({trailer(0xfffffffe)});
  send(
      {trailer(0xffffff), gvsp_extended_packet(GvspKind::kPayload, frame, 0xfffff0, std::string(1000, 'x'))});
  send({leader(gvsp_multipart_leader({{1, 1, std::uint64_t{1} << 40}}), 1)});
  send({leader(gvsp_multipart_leader({{1, 1, 1}}), 255), trailer(1)});
  send({gvsp_extended_packet(GvspKind::kAllIn, frame, 0, gvsp_image_leader(320, 240)),
        gvsp_extended_packet(GvspKind::kPayload, frame, 1'000'000, std::string(1000, 'x'))});
  send({leader(gvsp_image_leader(320, 240)), gvsp_extended_packet(GvspKind::kPayload, frame, 1)});
  send({"", "x", leader("").substr(0, 19)});
}

TEST(AravisPictures, AreValidatedAgainstTheBuffer) {
  constexpr std::size_t kBytes = 320 * 240;
  const std::vector<std::uint8_t> buffer(kBytes + 100);
  const ClaimedPicture good{ARV_PIXEL_FORMAT_MONO_8, 320, 240, 0, 0, kBytes, kBytes, kBytes + 100};
  std::string problem;
  const auto is_valid = [&](const auto& change) {
    ClaimedPicture claimed = good;
    change(claimed);
    const SentPicture sent = sound_picture(claimed, buffer.data(), problem);
    return sent.format != nullptr;
  };
  using Claimed = ClaimedPicture&;
  EXPECT_TRUE(is_valid([](Claimed) {}));
  EXPECT_TRUE(is_valid([](Claimed it) { it.offset = 100, it.came += 100; }));
  EXPECT_TRUE(is_valid([](Claimed it) { it.height = 120, it.padding_bytes = 320; }));
  EXPECT_FALSE(is_valid([](Claimed it) { it.came = 0; }));
  EXPECT_EQ(problem, "0 bytes arrived; 320x240 of format 0x01080001 needs 76800");
  EXPECT_FALSE(is_valid([](Claimed it) { --it.came; }));
  EXPECT_FALSE(is_valid([](Claimed it) { --it.bytes; }));
  EXPECT_FALSE(is_valid([](Claimed it) { it.offset = 1; }));
  EXPECT_FALSE(is_valid([](Claimed it) { it.offset = 101, it.came += 1000; }));
  EXPECT_FALSE(
      is_valid([](Claimed it) { it.offset = -std::uintptr_t{1}, it.came = it.bytes = ~std::size_t{0}; }));
  EXPECT_FALSE(is_valid([](Claimed it) { it.allocated = kBytes - 1; }));
  EXPECT_FALSE(
      is_valid([](Claimed it) { it.width = 16384, it.height = 16384, it.bytes = it.came = 1U << 28; }));
  EXPECT_FALSE(is_valid([](Claimed it) { it.padding_bytes = 1; }));
  EXPECT_FALSE(is_valid([](Claimed it) { it.padding_bytes = -1; }));
  EXPECT_FALSE(is_valid([](Claimed it) { it.width = -2; }));
  EXPECT_FALSE(is_valid([](Claimed it) { it.format = 7; }));
  EXPECT_EQ(problem, "320x240 pixels of format 0x00000007 are not supported");
  EXPECT_TRUE(is_valid([](Claimed it) { it.format = ARV_PIXEL_FORMAT_YUV_411_PACKED, it.width = 4; }));
  EXPECT_FALSE(is_valid([](Claimed it) { it.format = ARV_PIXEL_FORMAT_YUV_411_PACKED, it.width = 6; }));
}

TEST_F(Gige, DeeperPixelsKeepAllTheirBits) {
  const auto twelve_unpacked = [](const std::uint8_t* pixels, std::size_t count, std::uint8_t* packed) {
    for (std::size_t i = 0; i < count; ++i) {
      packed[2 * i] = static_cast<std::uint8_t>(pixels[i] << 4 | (i & 15));
      packed[2 * i + 1] = static_cast<std::uint8_t>(pixels[i] >> 4);
    }
  };
  const auto gige_packed = [](const std::uint8_t* pixels, std::size_t count, std::uint8_t* packed) {
    for (std::size_t i = 0; i < count; i += 2) {
      packed[i / 2 * 3] = pixels[i];
      packed[i / 2 * 3 + 1] = static_cast<std::uint8_t>((i & 15) | ((i + 1) & 15) << 4);
      packed[i / 2 * 3 + 2] = pixels[i + 1];
    }
  };
  struct Sent {
    std::uint32_t format;
    std::size_t bits;
    GigeServer::Pack pack;
  };
  const std::vector<Sent> formats{
      {0x01100011, 12, twelve_unpacked},  // BayerRG12
      {0x010a0058, 10, packed_p(10)},     // BayerRG10p
      {0x010c0059, 12, packed_p(12)},     // BayerRG12p
      {0x010c002b, 12, gige_packed},      // BayerRG12Packed
  };
  for (const auto& [format, bits, pack] : formats) {
    server_->send_packed(format, pack);
    const auto source = open({{"buffers", 3}});
    for (int i = 0; i < 10; ++i) {
      const CapturedImage image = next_picture(*source);
      ASSERT_EQ(image.image.view().format, PixelFormat::kBayerRg8) << std::hex << format;
      expect_our_pixels(image.image.view());
      expect_low_bits(image.image.view(), bits);
    }
  }
}

TEST_F(Gige, LowBitsOfACameraReachTheFits) {
  // A disc 0.75 levels above a background of 50: in 8 bits, both are 50.
  constexpr double kU = 160, kV = 120, kRadiusPx = 6;
  server_->send_packed(0x01100011, [](const std::uint8_t*, std::size_t count, std::uint8_t* packed) {
    for (std::size_t i = 0; i < count; ++i) {
      const double du = static_cast<double>(i % 320) - kU, dv = static_cast<double>(i / 320) - kV;
      const int value = 50 * 16 + (std::hypot(du, dv) < kRadiusPx ? 12 : 0);
      packed[2 * i] = static_cast<std::uint8_t>(value);
      packed[2 * i + 1] = static_cast<std::uint8_t>(value >> 8);
    }
  });
  const auto source = open();
  const CapturedImage image = next_picture(*source);
  const PlanePatch patch{{kU, kV}, {0, 0}, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0};  // 1 mm per pixel
  DiscMeter meter;
  const DiscFit fit = fit_disc(meter.measure(image.image.view(), patch, {0, 0, kRadiusPx, 4}, {}, 0.3));
  ASSERT_TRUE(fit.ok);
  for (std::size_t color = 0; color < 3; ++color) {
    EXPECT_NEAR(fit.contrast[color], 0.75, 0.1);
    EXPECT_NEAR(fit.color[color], 50.75, 0.1);
  }
}

TEST_F(Gige, AHeldUnpackedPictureOutlivesTheSource) {
  server_->send_packed(0x010c0059, packed_p(12));
  CapturedImage held;
  {
    const auto source = open();
    held = next_picture(*source);
  }
  expect_our_pixels(held.image.view());
}

TEST_F(Gige, MonoPicturesArriveUnchanged) {
  const auto source = open({{"pixel_format", "mono8"}});
  for (int i = 0; i < 5; ++i) {
    const CapturedImage image = next_picture(*source);
    EXPECT_EQ(image.image.view().format, PixelFormat::kMono8);
    expect_our_pixels(image.image.view());
  }
}

/// Whether all pixels are of the same sent image.
bool is_whole(const ImageView& view) {
  const int number = (view.data[0] - pixel(0, 0)) * 223;  // 31 * 223 = 1 modulo 256
  for (int i = 0; i < view.width * view.height; ++i) {
    if (view.data[i] != pixel(number & 255, i)) return false;
  }
  return true;
}

struct Taken {
  int whole = 0, torn = 0, refused = 0;  // refused: packets are missing
};
/// Counts received images until `is_enough`.
Taken take_until(Source& source, const std::function<bool(const Taken&)>& is_enough) {
  Taken taken;
  EXPECT_TRUE(test::becomes([&] {
    CapturedImage image;
    std::string problem;
    const CaptureStatus status = next(source, image, problem);
    if (status == CaptureStatus::kImage) ++(is_whole(image.image.view()) ? taken.whole : taken.torn);
    if (lacks_packets(status, problem)) ++taken.refused;
    return is_enough(taken);
  }));
  return taken;
}

TEST_F(Gige, ATornImageIsNotComplete) {
  const auto source = open({{"packet_size", 1000}});
  next_picture(*source);
  server_->lose_packets(0.01);
  const Taken taken =
      take_until(*source, [](const Taken& now) { return now.whole > 50 && now.refused > 50; });
  EXPECT_EQ(taken.torn, 0);
  EXPECT_GT(source->packets()->missing, 0u);
}

TEST_F(Gige, PicturesWithPacketsMissingCanBeUsed) {
  const auto source = open({{"packet_size", 1000}, {"use_incomplete", true}});
  next_picture(*source);
  server_->lose_packets(0.01);
  const Taken taken = take_until(*source, [](const Taken& now) { return now.whole > 50 && now.torn > 50; });
  EXPECT_EQ(taken.refused, 0);
}

TEST_F(Gige, PicturesAreTheDriversOwnBuffers) {
  const auto source = open({{"buffers", 5}});
  std::set<const std::uint8_t*> places;
  for (int i = 0; i < 50; ++i) places.insert(next_picture(*source).image.view().data);
  EXPECT_LE(places.size(), 5u);
}

TEST_F(Gige, AppliesItsOptions) {
  const auto source = open({{"pixel_format", "rgb24"},
                            {"width", 200},
                            {"height", 100},
                            {"offset_x", 20},
                            {"frame_rate_hz", 80},
                            {"exposure_us", 1500},
                            {"gain", 3},
                            {"packet_size", 1000},
                            {"buffers", 5}});
  const CapturedImage image = next_picture(*source);
  EXPECT_EQ(image.image.view().width, 200);
  EXPECT_EQ(image.image.view().height, 100);
  EXPECT_EQ(image.image.view().format, PixelFormat::kRgb24);
  expect_our_pixels(image.image.view());
}

TEST_F(Gige, PicturesHaveTimes) {
  const auto source = open();
  const CapturedImage first = next_picture(*source), second = next_picture(*source);
  EXPECT_LT(std::abs(first.times.t_capture_s - unix_time_s()), test::kPatience.count());
  EXPECT_LT(first.times.t_capture_s, second.times.t_capture_s);
  ASSERT_TRUE(first.times.t_capture_camera_s && second.times.t_capture_camera_s);
  EXPECT_LT(*first.times.t_capture_camera_s, *second.times.t_capture_camera_s);
  // Until the camera's clock is known, only the arrival determines the time.
  EXPECT_FALSE(first.times.t_capture_sigma_s);
  EXPECT_TRUE(test::becomes([&] { return next_picture(*source).times.t_capture_sigma_s.has_value(); }));
}

TEST_F(Gige, TheClockOfACameraWithPtpIsTheHosts) {
  // The fake camera uses this computer's clock.
  const auto source = open({{"controls", {{"PtpEnable", true}, {"ExposureTimeAbs", 2000}}}});
  EXPECT_TRUE(source->warnings().empty());
  CapturedImage image;
  ASSERT_TRUE(test::becomes([&] {
    image = next_picture(*source);
    return image.times.is_by_ptp;
  }));
  EXPECT_NEAR(image.times.t_capture_s, *image.times.t_capture_camera_s + 0.001, 1e-6);
}

TEST_F(Gige, AnAutomaticExposureIsFollowed) {
  const auto source = open({{"controls", {{"ExposureAuto", "Continuous"}, {"ExposureTimeAbs", 2000}}}});
  const auto shift_s = [&] {
    const CapturedImage image = next_picture(*source);
    return image.times.t_capture_s - *image.times.t_capture_camera_s;
  };
  // Until the camera's clock is known, t_capture_s is half the exposure before the arrival. The fake camera's
  // images arrive at about t_capture_camera_s.
  server_->set_exposure(300000);
  EXPECT_TRUE(test::becomes([&] { return shift_s() < -0.1; }));
}

/// Delays the camera's answer to exposure queries until the test counts down let_go.
struct HeldAnswer {
  void ask() {
    if (std::this_thread::get_id() == pictures_taken_by) {
      asked_by_that_one = true;
      return;
    }
    was_asked = true;
    let_go.wait();
    has_answered = true;
  }
  const std::thread::id pictures_taken_by = std::this_thread::get_id();
  std::atomic<bool> asked_by_that_one{false}, was_asked{false}, has_answered{false};
  std::latch let_go{1};

  static inline std::atomic<HeldAnswer*> newest{nullptr};
};

/// Replaces the packet size that the camera reports; 0: it does not answer in time.
std::optional<guint> told_packet_bytes;

/// Requests for this register do not reach the camera; 0: all do.
std::atomic<guint32> unanswered_register{0};

bool is_unanswered(const char* packet, std::size_t size) {
  constexpr char kRequest = 0x42;  // of GigE Vision's control protocol
  constexpr std::size_t kAddressAt = 8;
  if (unanswered_register == 0 || size < kAddressAt + 4 || packet[0] != kRequest) return false;
  guint32 address = 0;
  std::memcpy(&address, packet + kAddressAt, sizeof address);
  return GUINT32_FROM_BE(address) == unanswered_register;
}

}  // namespace
}  // namespace sslv::aravis_test

/// Replaces the library's function and calls it.
extern "C" double arv_camera_get_exposure_time(ArvCamera* camera, GError** error) {
  static const auto real =
      reinterpret_cast<double (*)(ArvCamera*, GError**)>(dlsym(RTLD_NEXT, "arv_camera_get_exposure_time"));
  if (sslv::aravis_test::HeldAnswer* held = sslv::aravis_test::HeldAnswer::newest) held->ask();
  return real(camera, error);
}
extern "C" guint arv_camera_gv_get_packet_size(ArvCamera* camera, GError** error) {
  static const auto real =
      reinterpret_cast<guint (*)(ArvCamera*, GError**)>(dlsym(RTLD_NEXT, "arv_camera_gv_get_packet_size"));
  if (sslv::aravis_test::told_packet_bytes == 0U)
    g_set_error_literal(error, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_TIMEOUT, "it does not answer");
  return sslv::aravis_test::told_packet_bytes ? *sslv::aravis_test::told_packet_bytes : real(camera, error);
}
/// Fails to send the request instead of losing it: the library then retries at once, rather than waiting
/// seconds for an answer. The final error is the same.
extern "C" gssize g_socket_send_to(GSocket* socket, GSocketAddress* address, const gchar* packet, gsize size,
                                   GCancellable* cancellable, GError** error) {
  static const auto real =
      reinterpret_cast<decltype(&g_socket_send_to)>(dlsym(RTLD_NEXT, "g_socket_send_to"));
  if (!sslv::aravis_test::is_unanswered(packet, size))
    return real(socket, address, packet, size, cancellable, error);
  g_set_error_literal(error, G_IO_ERROR, G_IO_ERROR_HOST_UNREACHABLE, "lost by the test");
  return -1;
}

namespace sslv::aravis_test {
namespace {

TEST_F(Gige, ACameraThatDoesNotSayItsPacketSizeIsNotOpen) {
  told_packet_bytes = 0;
  EXPECT_EQ(refusal(Json::object()), "camera \"127.0.0.1\": no packet size: it does not answer");
  told_packet_bytes = 56;
  EXPECT_EQ(refusal(Json::object()),
            "camera \"127.0.0.1\": its packet size of 56 bytes leaves no space for data");
  told_packet_bytes = 57;
  EXPECT_EQ(refusal(Json::object()), "no error");
  told_packet_bytes.reset();
}

TEST_F(Gige, ACameraThatDoesNotAnswerIsNotOpen) {
  constexpr guint32 kPtpEnable = 0x404, kTimestampTickFrequency = 0x440;  // as GigeServer has them
  for (const guint32 address : std::initializer_list<guint32>{
           ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, ARV_FAKE_CAMERA_REGISTER_X_OFFSET,
           ARV_FAKE_CAMERA_REGISTER_BINNING_HORIZONTAL, kPtpEnable, kTimestampTickFrequency}) {
    unanswered_register = address;
    EXPECT_THAT(refusal({{"chunks", true}}), HasSubstr("camera \"127.0.0.1\": does not answer: "))
        << std::hex << address;
  }
  unanswered_register = 0;
  EXPECT_EQ(refusal({{"chunks", true}}), "no error");
}

TEST_F(Gige, RetriesAnUnansweredExposure) {
  constexpr guint32 kExposureAuto = 0x400;  // as GigeServer has it
  const std::map<std::string, guint32> unanswered_in{{"Off", ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US},
                                                     {"Continuous", kExposureAuto}};
  for (const auto& [mode, address] : unanswered_in) {
    server_->set_exposure(2000);
    open({{"controls", {{"ExposureAuto", mode}}}});
    unanswered_register = address;
    const auto source = open();
    server_->set_exposure(300000);
    unanswered_register = 0;
    EXPECT_TRUE(test::becomes([&] {
      const CapturedImage image = next_picture(*source);
      return image.times.t_capture_s - *image.times.t_capture_camera_s < -0.1;
    })) << mode;
  }
}

TEST_F(Gige, ACameraThatDoesNotSayItsExposureDelaysNoPicture) {
  HeldAnswer held;
  const auto source = open({{"controls", {{"ExposureAuto", "Continuous"}}}});
  HeldAnswer::newest = &held;
  test::becomes([&] {
    next_picture(*source);
    return held.was_asked || held.asked_by_that_one;
  });
  EXPECT_FALSE(held.asked_by_that_one) << "pictures wait for the answer";
  EXPECT_TRUE(held.was_asked);
  for (int i = 0; i < 20; ++i) next_picture(*source);
  EXPECT_FALSE(held.has_answered);
  HeldAnswer::newest = nullptr;
  held.let_go.count_down();
}

TEST_F(Gige, WorksWithoutTheRequestedChunks) {
  const auto source = open({{"chunks", true}});
  expect_our_pixels(next_picture(*source).image.view());
}

TEST_F(Gige, ControlsAreThoseOfTheCamera) {
  const auto source = open({{"exposure_us", 1500}});
  const auto controls = source->controls();
  std::map<std::string, Control> all;
  for (const Control& control : controls->list()) all[control.name] = control;
  EXPECT_EQ(all["ExposureTimeAbs"].kind, ControlKind::kNumber);
  EXPECT_EQ(all["ExposureTimeAbs"].value, 1500);
  EXPECT_GT(all["ExposureTimeAbs"].most, 10000);
  EXPECT_EQ(all["ExposureTimeAbs"].category, "AcquisitionControl");
  EXPECT_TRUE(all["ExposureTimeAbs"].writable);
  EXPECT_EQ(all["Width"].kind, ControlKind::kInteger);
  EXPECT_EQ(all["Width"].value, 320);
  EXPECT_EQ(all["PixelFormat"].kind, ControlKind::kChoice);
  EXPECT_EQ(all["PixelFormat"].value, "BayerRG8");
  EXPECT_THAT(all["PixelFormat"].choices, testing::Contains("Mono8"));
  EXPECT_EQ(all["TriggerSoftware"].kind, ControlKind::kAction);
  EXPECT_EQ(all["DeviceModelName"].kind, ControlKind::kText);
  EXPECT_FALSE(all["SensorWidth"].writable);
  EXPECT_FALSE(all.contains("AcquisitionStop"));
}

TEST_F(Gige, ControlsAreSetWhileItRuns) {
  const auto source = open();
  const auto controls = source->controls();
  controls->set("GainRaw", 7);
  EXPECT_EQ(controls->get("GainRaw").value, 7);
  controls->set("ExposureTimeAbs", 2500.0);
  EXPECT_EQ(controls->get("ExposureTimeAbs").value, 2500.0);
  // Controls that change the image size cannot be set while streaming.
  EXPECT_TRUE(controls->get("Width").reopens);
  EXPECT_FALSE(controls->get("GainRaw").reopens);
  EXPECT_THROW(controls->set("Width", 100), NeedsReopening);
  expect_our_pixels(next_picture(*source).image.view());
}

TEST_F(Gige, ControlsSayWhatTheyTake) {
  const auto source = open();
  const auto controls = source->controls();
  const auto refusal_of = [&](const char* name, const Json& value) -> std::string {
    try {
      controls->set(name, value);
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(refusal_of("GainRaw", 99), "GainRaw: 99 is not allowed; expected a whole number from 0 to 10");
  EXPECT_THAT(refusal_of("PixelFormat", "Sepia"),
              HasSubstr("\"Sepia\" is not allowed; expected one of \"BayerBG8\", "));
  EXPECT_EQ(refusal_of("Colour", 1), "Colour: the camera has no such control");
  EXPECT_EQ(refusal_of("SensorWidth", 100), "SensorWidth: cannot be set now: it is read-only");
}

TEST_F(Gige, ControlsOfTheSettingsAreSetAtTheOpening) {
  const auto source = open({{"controls", {{"GainRaw", 5}, {"TriggerMode", "Off"}, {"ExposureTimeAbs", -4}}}});
  EXPECT_EQ(source->controls()->get("GainRaw").value, 5);
  ASSERT_EQ(source->warnings().size(), 1u);
  EXPECT_THAT(source->warnings()[0], HasSubstr("ExposureTimeAbs: -4 is not allowed; expected a number from"));
  expect_our_pixels(next_picture(*source).image.view());  // it still streams
}

TEST_F(Gige, WhatASelectorChoosesIsAControlForEachChoice) {
  const Json saved = {{"BalanceRatio[Blue]", 150}};
  const auto source = open({{"controls", saved}});
  EXPECT_THAT(source->warnings(), testing::IsEmpty());
  const auto controls = source->controls();
  std::map<std::string, Control> all;
  for (const Control& control : controls->list()) all[control.name] = control;
  for (const char* absent : {"BalanceRatio", "BalanceRatioSelector"})
    EXPECT_FALSE(all.contains(absent)) << absent;
  ASSERT_TRUE(all.contains("BalanceRatio[Red]"));
  EXPECT_EQ(all["BalanceRatio[Blue]"].value, 150);
  const Json red = all["BalanceRatio[Red]"].value;

  controls->queue().set("BalanceRatio[Red]", 90);
  controls->queue().set("BalanceRatio[Blue]", 91);
  EXPECT_EQ(controls->get("BalanceRatio[Red]").value, 90);
  EXPECT_EQ(controls->get("BalanceRatio[Blue]").value, 91);
  EXPECT_EQ(controls->queue().unsaved(saved).size(), 2U);
  controls->queue().revert({}, saved);
  EXPECT_EQ(controls->get("BalanceRatio[Red]").value, red);
  EXPECT_EQ(controls->get("BalanceRatio[Blue]").value, 150);

  // Older settings use this name, for the control of the selected choice.
  EXPECT_EQ(controls->get("BalanceRatioSelector").value, "Red");
  EXPECT_EQ(controls->get("BalanceRatio").value, red);
  EXPECT_THROW(controls->get("BalanceRatio[Green]"), SettingsError);
  EXPECT_THROW(controls->get("GainRaw[Red]"), SettingsError);

  // Controls of other selectors show the value of the selected item. They are not restored: with another
  // selection, that would change another item.
  EXPECT_TRUE(all["LineInverter"].depends);
  EXPECT_TRUE(all["LineSelector"].depends);
  EXPECT_FALSE(all["GainRaw"].depends);
  controls->queue().set("LineInverter", true);
  controls->queue().set("LineSelector", "Line1");
  EXPECT_EQ(controls->get("LineInverter").value, false);
  EXPECT_THAT(controls->queue().unsaved(saved), testing::IsEmpty());
}

TEST_F(Gige, ControlsOutliveTheSource) {
  auto source = open();
  const auto controls = source->controls();
  source.reset();
  EXPECT_THROW(controls->list(), CaptureError);
  EXPECT_THROW(controls->set("GainRaw", 1), CaptureError);
}

TEST_F(Gige, PicturesOutliveTheSource) {
  CapturedImage held, dropped_late;
  {
    const auto source = open();
    held = next_picture(*source);
    dropped_late = next_picture(*source);
  }
  expect_our_pixels(held.image.view());
  dropped_late = {};
  const auto again = open();
  expect_our_pixels(next_picture(*again).image.view());
  expect_our_pixels(held.image.view());
}

TEST_F(Gige, BuffersComeBack) {
  const auto source = open({{"buffers", 3}});
  for (int i = 0; i < 20; ++i) next_picture(*source);
}

TEST_F(Gige, ItsBuffersCanBeLookedAtByOtherProcesses) {
  share_new_images(true);
  Image last;
  {
    const auto source = open({{"buffers", 3}});
    share_new_images(false);
    CapturedImage image;
    for (int i = 0; i < 20; ++i) {
      image = next_picture(*source);
      const ImageView& view = image.image.view();
      const auto bytes = static_cast<std::size_t>(view.stride_bytes * view.height);
      EXPECT_TRUE(shared_place(view.data, bytes));
    }
    last = std::move(image.image);
  }
  EXPECT_TRUE(shared_place(last.view().data, 1)) << "also when the source is gone";
  const std::uint8_t* const data = last.view().data;
  last = Image();
  EXPECT_FALSE(shared_place(data, 1));
}

std::uint64_t allocations_for_pictures(Source& source, int count) {
  CapturedImage image;
  std::string problem;
  for (int i = 0; i < 10; ++i) next_picture(source);
  std::uint64_t allocations = 0;
  int images = 0;
  // A packet may get lost here; reporting that allocates.
  EXPECT_TRUE(test::becomes([&] {
    const std::uint64_t before = allocation_count();
    if (next(source, image, problem) == CaptureStatus::kImage) {
      allocations += allocation_count() - before;
      ++images;
    }
    return images == count;
  })) << problem;
  return allocations;
}

TEST_F(Gige, AllocatesNothingForAPicture) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  EXPECT_EQ(allocations_for_pictures(*open(), 200), 0U);
  server_->send_packed(0x010c0059, packed_p(12));
  EXPECT_EQ(allocations_for_pictures(*open(), 50), 0U);
}

TEST_F(Gige, SaysWhyAPictureIsIncomplete) {
  const auto source = open();
  next_picture(*source);
  server_->lose_packets(0.2);
  CapturedImage image;
  std::string problem;
  EXPECT_TRUE(test::becomes([&] {
    const CaptureStatus status = next(*source, image, problem);
    return lacks_packets(status, problem);
  })) << problem;
}

TEST_F(Gige, ASilentCameraIsLost) {
  std::unique_ptr<Source> source;
  CapturedImage image;
  std::string problem;
  CaptureStatus status = CaptureStatus::kTimeout;
  // On a busy computer, images may arrive too late.
  ASSERT_TRUE(test::becomes([&] {
    source.reset();
    source = open({{"silence_s", 1}});
    status = next(*source, image, problem);
    return status == CaptureStatus::kImage;
  })) << problem;
  pull_the_plug();
  while (status == CaptureStatus::kImage || status == CaptureStatus::kIncomplete) {
    status = next(*source, image, problem);
  }
  EXPECT_EQ(status, CaptureStatus::kLost);
  EXPECT_EQ(problem, "camera \"127.0.0.1\": no image for 1 s");
  plug_in();  // otherwise closing would wait for answers
}

/// A restarted camera no longer knows this client; only its answers to the heartbeat show that.
TEST_F(Gige, ARestartedCameraIsLost) {
  const auto source = open({{"silence_s", 3600}});
  next_picture(*source);
  pull_the_plug();
  plug_in();
  CapturedImage image;
  std::string problem;
  CaptureStatus status = CaptureStatus::kImage;
  while (status == CaptureStatus::kImage || status == CaptureStatus::kIncomplete) {
    status = next(*source, image, problem);
  }
  EXPECT_EQ(status, CaptureStatus::kLost);
  EXPECT_EQ(problem, "camera \"127.0.0.1\": no longer answers");
}

TEST_F(Gige, TheCameraThreadReopensARestartedCamera) {
  std::atomic<int> taken{0};
  CameraThread thread(
      "camera 0", {},
      [] {
        return open({{"silence_s", 0.3}});
      },
      [&](CapturedImage&&) { ++taken; }, {milliseconds(10), milliseconds(100), test::kPatience});
  thread.start();
  const auto wait_for_more = [&] {
    return test::becomes([&, before = taken.load()] { return taken >= before + 3; });
  };
  ASSERT_TRUE(wait_for_more());
  pull_the_plug();
  ASSERT_TRUE(test::becomes([&] { return thread.health().state != CameraState::kRunning; }));
  EXPECT_THAT(thread.health().error, HasSubstr("camera \"127.0.0.1\": "));
  plug_in();
  EXPECT_TRUE(wait_for_more()) << thread.health().error;
  EXPECT_GE(thread.health().reconnects, 1U);
}

TEST_F(Gige, IsListedAndOpenedBySerial) {
  std::vector<FoundCamera> found;
  std::vector<FoundCamera>::const_iterator ours;
  ASSERT_TRUE(test::becomes([&] {
    found = aravis_backend().list();
    ours = std::find_if(found.begin(), found.end(), [](const FoundCamera& camera) {
      return camera.source == Json{{"backend", "aravis"}, {"camera", kSerial}};
    });
    return ours != found.end();
  }));
  EXPECT_EQ(ours->name, "Aravis Fake SSLV01 (GigEVision, 127.0.0.1)");
  std::unique_ptr<Source> source;
  ASSERT_TRUE(test::becomes([&] {
    try {
      source = open({{"camera", kSerial}});
    } catch (const CaptureError&) {  // it answered too late for this search
    }
    return source != nullptr;
  }));
  expect_our_pixels(next_picture(*source).image.view());
}

/// The address of a network card of this machine, for a second camera; empty if there is none.
std::string card_address() {
  for (const NetworkCard& card : network_cards()) {
    if (!card.is_loopback && !card.addresses.empty()) return card.addresses.front().to_string();
  }
  return "";
}

/// Two cameras that differ only in width. No images are captured, because a packet socket does not receive
/// what a machine sends to its own card.
TEST(AravisSerials, CamerasThatSwapAddressesKeepTheirNames) {
  const std::string other_address = card_address();
  if (other_address.empty()) GTEST_SKIP() << "no network card for the second camera";
  const auto serve = [](const std::string& address, const std::string& serial, int width) {
    auto server = std::make_unique<GigeServer>(address, serial, [](std::uint8_t*, int, int, PixelFormat) {});
    server->set_defaults(width, 48, PixelFormat::kMono8, 100);
    return server;
  };
  // The results of the last search are reused for a moment.
  const auto width_of = [](const std::string& serial) {
    int width = 0;
    test::becomes([&] {
      try {
        const auto source = aravis_backend().open(aravis_backend().complete({{"camera", serial}}, ""), {});
        width = source->controls()->get("Width").value.get<int>();
      } catch (const CaptureError&) {
      }
      return width > 0;
    });
    return width;
  };
  auto left = serve(kAddress, "LEFT", 64), right = serve(other_address, "RIGHT", 128);
  EXPECT_EQ(width_of("LEFT"), 64);
  EXPECT_EQ(width_of("RIGHT"), 128);
  left.reset();
  right.reset();
  left = serve(other_address, "LEFT", 64);
  right = serve(kAddress, "RIGHT", 128);
  EXPECT_EQ(width_of("LEFT"), 64);
  EXPECT_EQ(width_of("RIGHT"), 128);
}

TEST_F(Gige, NamesWhatTheCameraDoesNotTake) {
  EXPECT_EQ(refusal({{"width", 4000}}),
            "camera \"127.0.0.1\": width 4000 refused: the camera allows 1 .. 320");
  EXPECT_EQ(refusal({{"gain", 99}}), "camera \"127.0.0.1\": gain 99 refused: the camera allows 0 .. 10");
  EXPECT_EQ(
      refusal({{"pixel_format", "yuyv"}}),
      "camera \"127.0.0.1\": pixel_format yuyv refused: the camera has bayer_bg8, bayer_gb8, bayer_gr8, "
      "bayer_rg8, mono8, rgb24");
}

TEST_F(Gige, NamesACameraThatIsNotThere) {
  std::string found;
  EXPECT_TRUE(test::becomes([&] {
    found = refusal({{"camera", "XY-404"}});
    return found.find("\"SSLV01\" (Aravis-Fake-SSLV01)") != std::string::npos;
  })) << found;
  EXPECT_THAT(found, HasSubstr("camera \"XY-404\": not found; available: "));
}

TEST(Aravis, UnknownOptionsAreRefused) {
  EXPECT_THROW(aravis_backend().complete({{"exposure", 3}}, "/cameras/0/source"), SettingsError);
  EXPECT_THROW(aravis_backend().complete({{"buffers", 1}}, "/cameras/0/source"), SettingsError);
  const Json defaults = aravis_backend().complete(Json::object(), "");
  EXPECT_EQ(defaults.at("camera"), "");
  EXPECT_EQ(defaults.at("exposure_us"), nullptr);
}

}  // namespace
}  // namespace sslv::aravis_test
