// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2.h"

#include "base/clock.h"
#include "base/error.h"
#include "capture/camera_thread.h"
#include "image/jpeg.h"
#include "support/allocation_count.h"
#include "support/becomes.h"
#include "support/fake_v4l2.h"
#include "support/temporary_folder.h"

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>

namespace sslv::v4l2_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr milliseconds kNow{0};

/// A fake computer with the files that the kernel and udev create for its cameras.
class V4l2 : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(root_ / "class");
    fs::create_directories(root_ / "dev/v4l/by-id");
    system_.class_folder = root_ / "class";
    system_.device_folder = root_ / "dev";
    system_.open = [this](const std::string& path) -> std::shared_ptr<V4l2Device> {
      const std::lock_guard lock(mutex_);
      const auto found = cameras_.find(path);
      errno = found == cameras_.end() ? ENOENT : EACCES;
      return found == cameras_.end() ? nullptr : found->second;
    };
  }
  /// Plugs a camera into a socket. Empty `serial`: the camera has none.
  std::shared_ptr<FakeV4l2> plug_in(int number, const std::string& socket, const std::string& serial) {
    const auto camera = std::make_shared<FakeV4l2>();
    camera->bus = "usb-" + socket;
    plug_in(camera, number, socket, serial);
    return camera;
  }
  void plug_in(const std::shared_ptr<FakeV4l2>& camera, int number, const std::string& socket,
               const std::string& serial) {
    const std::string name = "video" + std::to_string(number);
    const fs::path device = root_ / "devices/hub" / socket;
    fs::create_directories(device / "interface");
    std::ofstream(root_ / "devices/hub/serial") << "of the hub\n";
    std::ofstream(root_ / "devices/hub/idVendor") << "1d6b\n";
    std::ofstream(device / "idVendor") << "046d\n";
    if (!serial.empty()) std::ofstream(device / "serial") << serial << '\n';
    fs::create_directories(root_ / "class" / name);
    fs::remove(root_ / "class" / name / "device");
    fs::create_symlink(device / "interface", root_ / "class" / name / "device");
    std::ofstream(root_ / "dev" / name) << "";
    const std::lock_guard lock(mutex_);
    cameras_[path_of(number)] = camera;
  }
  void pull_out(int number) {
    fs::remove_all(root_ / "class" / ("video" + std::to_string(number)));
    const std::lock_guard lock(mutex_);
    cameras_.at(path_of(number))->unplug();
    cameras_.erase(path_of(number));
  }
  std::string path_of(int number) const { return root_ / "dev" / ("video" + std::to_string(number)); }

  std::unique_ptr<Source> open(const Json& options = Json::object()) {
    return open_v4l2(v4l2_backend().complete(options, ""), system_);
  }
  std::string refusal(const Json& options) {
    try {
      open(options);
    } catch (const CaptureError& error) {
      return error.what();
    }
    return "no error";
  }

  const test::TemporaryFolder folder_;
  const fs::path root_ = fs::canonical(folder_.path());
  V4l2System system_;
  std::mutex mutex_;  // guards cameras_: a camera's thread also opens cameras
  std::map<std::string, std::shared_ptr<FakeV4l2>> cameras_;
};

CapturedImage next_picture(Source& source) {
  CapturedImage image;
  std::string problem;
  EXPECT_EQ(source.next(image, problem, test::kPatience), CaptureStatus::kImage) << problem;
  return image;
}

std::string problem_of(Source& source, CaptureStatus expected) {
  CapturedImage image;
  std::string problem;
  EXPECT_EQ(source.next(image, problem, test::kPatience), expected);
  return problem;
}

FakeV4l2::Item number_item(std::uint32_t id, const char* title, int min, int max, int value) {
  return {id, V4L2_CTRL_TYPE_INTEGER, title, min, max, 1, value};
}

/// Adds the controls of a typical webcam.
void add_webcam_items(FakeV4l2& camera) {
  const auto add = [&](FakeV4l2::Item item) { camera.items[item.id] = std::move(item); };
  add({V4L2_CID_USER_CLASS, V4L2_CTRL_TYPE_CTRL_CLASS, "User Controls"});
  add(number_item(V4L2_CID_BRIGHTNESS, "Brightness", -64, 64, 5));
  add({V4L2_CID_AUTO_WHITE_BALANCE, V4L2_CTRL_TYPE_BOOLEAN, "White Balance, Automatic", 0, 1, 1, 1});
  add({V4L2_CID_CAMERA_CLASS, V4L2_CTRL_TYPE_CTRL_CLASS, "Camera Controls"});
  add({V4L2_CID_EXPOSURE_AUTO,
       V4L2_CTRL_TYPE_MENU,
       "Auto Exposure",
       0,
       3,
       1,
       3,
       0,
       {"", "Manual Mode", "", "Aperture Priority Mode"}});
  add(number_item(V4L2_CID_EXPOSURE_ABSOLUTE, "Exposure Time, Absolute", 3, 2047, 250));
  camera.items.at(V4L2_CID_EXPOSURE_ABSOLUTE).flags = V4L2_CTRL_FLAG_INACTIVE;
}

// ---- images

TEST_F(V4l2, LendsTheKernelsBuffers) {
  const auto camera = plug_in(0, "1", "");
  camera->padding_bytes = 32;
  const auto source = open();
  camera->deliver(7);
  const CapturedImage image = next_picture(*source);
  const ImageView view = image.image.view();
  EXPECT_EQ(view.width, 64);
  EXPECT_EQ(view.height, 48);
  EXPECT_EQ(view.stride_bytes, 64 * 2 + 32);
  EXPECT_EQ(view.format, PixelFormat::kYuyv);
  EXPECT_EQ(view.row(47)[127], 7);
}

TEST_F(V4l2, GivesBuffersBack) {
  const auto camera = plug_in(0, "1", "");
  const auto source = open({{"buffers", 3}});
  EXPECT_EQ(camera->queued(), 3U);
  CapturedImage held;
  for (int i = 0; i < 20; ++i) {
    camera->deliver(static_cast<std::uint8_t>(i));
    held = next_picture(*source);
    EXPECT_EQ(held.image.view().data[0], i);
  }
  EXPECT_EQ(camera->queued(), 2U);
  std::thread([picture = std::move(held)] {}).join();
  EXPECT_EQ(camera->queued(), 3U);
}

TEST_F(V4l2, PicturesOutliveTheSource) {
  const auto camera = plug_in(0, "1", "");
  auto source = open({{"buffers", 4}});
  camera->deliver(1);
  camera->deliver(2);
  CapturedImage first = next_picture(*source), second = next_picture(*source);
  source.reset();
  EXPECT_FALSE(camera->streams());
  first = {};
  EXPECT_EQ(camera->queued(), 0U);  // a late buffer is not queued on a stopped device
  const auto again = open();
  camera->deliver(3);
  EXPECT_EQ(next_picture(*again).image.view().data[0], 3);
  EXPECT_EQ(second.image.view().data[0], 2);
  EXPECT_EQ(camera->mapped(), 4U + 8U);
  second = {};
  EXPECT_EQ(camera->mapped(), 8U);
  EXPECT_EQ(camera->queued(), 8U);
}

TEST_F(V4l2, AllocatesNothingForAPicture) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  const auto camera = plug_in(0, "1", "");
  const auto source = open();
  const std::vector<std::uint8_t> bytes(camera->format().sizeimage, 1);
  std::string problem;
  CapturedImage image;
  const auto turn = [&] {
    camera->deliver(bytes);
    const std::uint64_t before = allocation_count();
    EXPECT_EQ(source->next(image, problem, test::kPatience), CaptureStatus::kImage) << problem;
    return allocation_count() - before;
  };
  for (int i = 0; i < 10; ++i) EXPECT_EQ(turn(), 0U);
}

TEST_F(V4l2, DamagedPicturesAreIncomplete) {
  const auto camera = plug_in(0, "1", "");
  const auto source = open();
  camera->deliver(std::vector<std::uint8_t>(camera->format().sizeimage), V4L2_BUF_FLAG_ERROR);
  EXPECT_EQ(problem_of(*source, CaptureStatus::kIncomplete), "the driver reports it as damaged");
  camera->deliver(std::vector<std::uint8_t>(100));
  EXPECT_EQ(problem_of(*source, CaptureStatus::kIncomplete), "100 bytes arrived; 64x48 yuyv needs 6144");
  EXPECT_EQ(camera->queued(), 8U);
  camera->deliver(9);
  EXPECT_EQ(next_picture(*source).image.view().data[0], 9);
  EXPECT_EQ(source->dropped(), 0U);
}

TEST_F(V4l2, CountsGapsInSequenceNumbers) {
  const auto camera = plug_in(0, "1", "");
  const auto source = open();
  camera->lose_pictures(5);  // before the first image: not counted
  camera->deliver(1);
  next_picture(*source);
  EXPECT_EQ(source->dropped(), 0U);
  camera->lose_pictures(3);
  camera->deliver(2);
  next_picture(*source);
  EXPECT_EQ(source->dropped(), 3U);
  camera->lose_pictures(~0U - 10);  // the sequence number wraps
  camera->lose_pictures(10 + 2);
  camera->deliver(3);
  next_picture(*source);
  EXPECT_EQ(source->dropped(), 4U);
}

TEST_F(V4l2, MotionJpegIsRead) {
  const auto camera = plug_in(0, "1", "");
  camera->modes = {{V4L2_PIX_FMT_MJPEG, 64, 48, {30}}};
  const auto source = open();
  const std::vector<std::uint8_t> grey(64 * 48 * 2, 128);
  JpegEncoder encoder;
  const auto jpeg = encoder.encode({grey.data(), 64, 48, 64 * 2, PixelFormat::kUyvy}, 64, 90);
  camera->deliver(jpeg);
  const CapturedImage image = next_picture(*source);
  EXPECT_EQ(image.image.view().format, PixelFormat::kUyvy);
  EXPECT_EQ(image.image.view().width, 64);
  EXPECT_EQ(image.image.view().row(47)[127], 128);
  EXPECT_EQ(camera->queued(), 8U);  // the image is decompressed, so its buffer is queued again

  camera->deliver(jpeg.first(jpeg.size() - 8));
  EXPECT_THAT(problem_of(*source, CaptureStatus::kIncomplete), HasSubstr("Premature end of JPEG file"));
  camera->deliver(std::vector<std::uint8_t>(30, 1));
  EXPECT_THAT(problem_of(*source, CaptureStatus::kIncomplete), HasSubstr("Not a JPEG file"));
  const auto small = encoder.encode({grey.data(), 32, 48, 64, PixelFormat::kUyvy}, 32, 90);
  camera->deliver(small);
  EXPECT_EQ(problem_of(*source, CaptureStatus::kIncomplete), "32x48 pixels arrived instead of 64x48");
}

/// Cameras of embedded boards support only multi-planar calls, with one plane for the formats used here.
constexpr std::uint32_t kPlanar = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;

TEST_F(V4l2, ADeviceWithPlanesLendsItsBuffersToo) {
  const auto camera = plug_in(0, "1", "");
  camera->capabilities = kPlanar;
  camera->modes = {{V4L2_PIX_FMT_UYVY, 64, 48, {30}}, {V4L2_PIX_FMT_SRGGB8, 64, 48, {60}}};
  camera->padding_bytes = 32;
  camera->data_offset = 64;
  auto source = open({{"buffers", 3}, {"frame_rate_hz", 60}});
  for (int i = 1; i < 20; ++i) {
    camera->deliver(static_cast<std::uint8_t>(i));
    const CapturedImage image = next_picture(*source);
    const ImageView view = image.image.view();
    EXPECT_EQ(view.format, PixelFormat::kBayerRg8);
    EXPECT_EQ(view.stride_bytes, 64 + 32);
    EXPECT_EQ(view.data[0], i);
    EXPECT_EQ(view.row(47)[63], i);
  }
  EXPECT_EQ(camera->queued(), 3U);
  // Bytes are counted from the beginning of the image.
  camera->deliver(std::vector<std::uint8_t>(100));
  EXPECT_EQ(problem_of(*source, CaptureStatus::kIncomplete), "100 bytes arrived; 64x48 bayer_rg8 needs 4576");
  source.reset();
  EXPECT_FALSE(camera->streams());
  EXPECT_EQ(camera->mapped(), 0U);
  EXPECT_EQ(list_v4l2(system_).at(0).formats, (std::vector<std::string>{"uyvy", "bayer_rg8"}));
}

TEST_F(V4l2, MotionJpegInAPlaneIsRead) {
  const auto camera = plug_in(0, "1", "");
  camera->capabilities = kPlanar;
  camera->modes = {{V4L2_PIX_FMT_MJPEG, 64, 48, {30}}};
  camera->data_offset = 16;
  const auto source = open();
  const std::vector<std::uint8_t> grey(64 * 48 * 2, 128);
  JpegEncoder encoder;
  camera->deliver(encoder.encode({grey.data(), 64, 48, 64 * 2, PixelFormat::kUyvy}, 64, 90));
  EXPECT_EQ(next_picture(*source).image.view().row(47)[127], 128);
}

TEST_F(V4l2, Nv12BecomesUyvy) {
  for (const std::uint32_t capabilities :
       {std::uint32_t{V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING}, kPlanar}) {
    const auto camera = plug_in(0, "1", "");
    camera->capabilities = capabilities;
    camera->modes = {{V4L2_PIX_FMT_NV12, 8, 4, {30}}};
    camera->padding_bytes = 4;
    const auto source = open({{"buffers", 3}});
    std::vector<std::uint8_t> bytes(12 * 6);
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 8; ++x) {
        bytes[static_cast<std::size_t>(12 * y + x)] = static_cast<std::uint8_t>(10 * y + x);
        bytes[static_cast<std::size_t>(12 * (4 + y / 2) + x)] =
            static_cast<std::uint8_t>(100 + 50 * (y / 2) + x);
      }
    }
    camera->deliver(bytes);
    const CapturedImage image = next_picture(*source);
    const ImageView view = image.image.view();
    EXPECT_EQ(view.format, PixelFormat::kUyvy);
    EXPECT_EQ(camera->queued(), 3U);  // the image is a copy
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 8; ++x) {
        EXPECT_EQ(view.row(y)[2 * x], 100 + 50 * (y / 2) + x);
        EXPECT_EQ(view.row(y)[2 * x + 1], 10 * y + x);
      }
    }
    camera->deliver(std::span(bytes).first(12 * 5));
    EXPECT_EQ(problem_of(*source, CaptureStatus::kIncomplete), "60 bytes arrived; 8x4 nv12 needs 68");
    std::vector<CapturedImage> held;
    for (int i = 0; i < 2; ++i) {
      camera->deliver(bytes);
      held.push_back(next_picture(*source));
    }
    camera->deliver(bytes);
    problem_of(*source, CaptureStatus::kTimeout);  // all image buffers are in use
    EXPECT_EQ(source->dropped(), 1U);
    camera->modes = {{V4L2_PIX_FMT_NV12, 8, 5, {30}}};
    EXPECT_THAT(refusal({{"pixel_format", "nv12"}}), HasSubstr("nv12 refused: it does not support 8x5"));
  }
}

TEST_F(V4l2, APictureInSeveralPlanesIsRefused) {
  const auto camera = plug_in(0, "1", "A1");
  camera->capabilities = kPlanar;
  camera->planes = 2;
  EXPECT_EQ(refusal({{"camera", "A1"}}),
            "camera \"A1\": pixel_format yuyv refused: the camera delivers it in 2 planes");
}

TEST_F(V4l2, ADeviceWithBothKindsOfCallsIsAskedWithoutPlanes) {
  const auto camera = plug_in(0, "1", "");
  camera->capabilities = kPlanar | V4L2_CAP_VIDEO_CAPTURE;
  const auto source = open();
  camera->deliver(7);
  EXPECT_EQ(next_picture(*source).image.view().data[0], 7);
}

// ---- loss

TEST_F(V4l2, AnUnpluggedCameraIsLostAtOnce) {
  const auto camera = plug_in(0, "1", "A1");
  const auto source = open({{"silence_s", 3600}, {"camera", "A1"}});
  camera->deliver(1);
  const CapturedImage held = next_picture(*source);
  camera->unplug();
  EXPECT_EQ(problem_of(*source, CaptureStatus::kLost), "camera \"A1\": it is no longer connected");
}

TEST_F(V4l2, ADriverThatFailsIsLost) {
  const auto camera = plug_in(0, "1", "A1");
  const auto source = open({{"camera", "A1"}});
  camera->fail(VIDIOC_DQBUF, EIO);
  EXPECT_EQ(problem_of(*source, CaptureStatus::kLost),
            "camera \"A1\": it delivers no more images: Input/output error");
}

TEST_F(V4l2, ACameraThatDoesNotTakeItsBuffersIsLost) {
  const auto camera = plug_in(0, "1", "A1");
  const auto source = open({{"camera", "A1"}});
  camera->deliver(1);
  CapturedImage image = next_picture(*source);
  camera->fail(VIDIOC_QBUF, EINVAL);
  image = {};
  std::string problem;
  EXPECT_EQ(source->next(image, problem, kNow), CaptureStatus::kLost);
  EXPECT_EQ(problem, "camera \"A1\": its buffers cannot be queued again: Invalid argument");
}

TEST_F(V4l2, ASilentCameraIsLostUnlessWeHoldItsBuffers) {
  const auto camera = plug_in(0, "1", "A1");
  const auto source = open({{"camera", "A1"}, {"silence_s", 0.1}, {"buffers", 3}});
  std::vector<CapturedImage> held;
  for (int i = 0; i < 3; ++i) {
    camera->deliver(1);
    held.push_back(next_picture(*source));
  }
  CapturedImage image;
  std::string problem;
  EXPECT_EQ(source->next(image, problem, milliseconds(150)), CaptureStatus::kTimeout);
  held.clear();
  EXPECT_EQ(source->next(image, problem, milliseconds(150)), CaptureStatus::kLost);
  EXPECT_EQ(problem, "camera \"A1\": no image for 0.1 s");
}

/// The kernel gives a replugged camera another number.
TEST_F(V4l2, TheCameraThreadFindsACameraThatWasPluggedInAgain) {
  auto camera = plug_in(0, "1", "A1");
  plug_in(1, "2", "B2");
  std::atomic<int> last{0};
  CameraThread thread(
      "camera 0", {},
      [this] {
        return open({{"camera", "A1"}, {"silence_s", 3600}});
      },
      [&](CapturedImage&& image) { last = image.image.view().data[0]; }, {milliseconds(5), milliseconds(20)});
  thread.start();
  ASSERT_TRUE(test::becomes([&] { return camera->streams(); }));
  camera->deliver(1);
  ASSERT_TRUE(test::becomes([&] { return last == 1; }));
  pull_out(0);
  ASSERT_TRUE(test::becomes([&] { return thread.health().state == CameraState::kLost; }));
  EXPECT_THAT(thread.health().error, HasSubstr("camera \"A1\": "));

  camera = plug_in(7, "3", "A1");
  ASSERT_TRUE(test::becomes([&] { return camera->streams(); })) << thread.health().error;
  camera->deliver(2);
  EXPECT_TRUE(test::becomes([&] { return last == 2; }));
}

// ---- which camera

TEST_F(V4l2, CamerasThatSwapNumbersStayThemselves) {
  const auto left = plug_in(0, "1", "A1"), right = plug_in(1, "2", "B2");
  open({{"camera", "A1"}, {"width", 64}});
  plug_in(right, 0, "2", "B2");
  plug_in(left, 1, "1", "A1");
  const auto source = open({{"camera", "A1"}});
  EXPECT_TRUE(left->streams());
  EXPECT_FALSE(right->streams());
  const auto by_bus = open({{"camera", "usb-2"}});
  EXPECT_TRUE(right->streams());
}

TEST_F(V4l2, HasManyNames) {
  const auto camera = plug_in(3, "1", "A1");
  plug_in(0, "2", "B2");
  fs::create_symlink(path_of(3), root_ / "dev/v4l/by-id/usb-Fake_Camera_A1-video-index0");
  for (const std::string& name :
       {std::string("A1"), std::string("usb-1"), path_of(3), std::string("usb-Fake_Camera_A1-video-index0"),
        std::string(root_ / "dev/v4l/by-id/usb-Fake_Camera_A1-video-index0")}) {
    const auto source = open({{"camera", name}});
    EXPECT_TRUE(camera->streams()) << name;
  }
}

TEST_F(V4l2, SaysWhichCamerasThereAre) {
  EXPECT_EQ(refusal({{"camera", "A1"}}), "camera \"A1\": there is no video device");
  plug_in(0, "1", "same"), plug_in(1, "2", "same"), plug_in(2, "3", "");
  EXPECT_EQ(refusal({{"camera", "A1"}}),
            "camera \"A1\": not found; available: \"usb-1\" (Fake Camera), \"usb-2\" (Fake Camera), "
            "\"usb-3\" (Fake Camera)");
  EXPECT_EQ(refusal({{"camera", "same"}}),
            "camera \"same\": 2 cameras have this name; use one of \"usb-1\" (Fake Camera), \"usb-2\" (Fake "
            "Camera)");
  EXPECT_EQ(refusal({{"camera", "/dev/nothing"}}), "camera \"/dev/nothing\": No such file or directory");
  cameras_.at(path_of(2))->capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  EXPECT_EQ(refusal({{"camera", path_of(2)}}),
            "camera \"" + path_of(2) + "\": this device delivers no images");
  for (auto& [path, camera] : cameras_) camera.reset();
  EXPECT_EQ(
      refusal({{"camera", "A1"}}),
      "camera \"A1\": " + path_of(2) + ": Permission denied; only members of the group video may use it");
}

/// A depth camera has two devices, for colour and infrared images.
TEST_F(V4l2, DevicesOfOneCameraAreToldApartByTheirLinks) {
  plug_in(0, "1", "A1"), plug_in(1, "1", "A1");
  fs::create_directories(root_ / "dev/v4l/by-path");
  fs::create_symlink(path_of(0), root_ / "dev/v4l/by-path/usb-1-index0");
  fs::create_symlink(path_of(1), root_ / "dev/v4l/by-path/usb-1-index2");
  EXPECT_EQ(refusal({{"camera", "A1"}}),
            "camera \"A1\": 2 cameras have this name; use one of \"usb-1-index0\" (Fake Camera), "
            "\"usb-1-index2\" (Fake "
            "Camera)");
  const auto source = open({{"camera", "usb-1-index2"}});
  EXPECT_TRUE(cameras_.at(path_of(1))->streams());
}

TEST_F(V4l2, AreListedWithTheirSettings) {
  const auto camera = plug_in(10, "1", "A1");
  camera->modes = {{V4L2_PIX_FMT_MJPEG, 64, 48, {30}},
                   {V4L2_PIX_FMT_YUYV, 64, 48, {30}},
                   {V4L2_PIX_FMT_H264, 64, 48, {30}}};
  plug_in(2, "2", "");
  plug_in(3, "2", "")->capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  const std::vector<FoundCamera> found = list_v4l2(system_);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].source, (Json{{"backend", "v4l2"}, {"camera", "usb-2"}}));
  EXPECT_EQ(found[1].source, (Json{{"backend", "v4l2"}, {"camera", "A1"}}));
  EXPECT_EQ(found[1].name, "Fake Camera A1 (fake, usb-1)");
  EXPECT_EQ(found[1].model, "Fake Camera");
  EXPECT_EQ(found[1].serial, "A1");
  EXPECT_THAT(found[1].formats, ElementsAre("yuyv", "mjpeg"));
}

// ---- format

TEST_F(V4l2, AutoTakesWhatIsFastEnough) {
  const auto camera = plug_in(0, "1", "");
  camera->modes = {{V4L2_PIX_FMT_GREY, 64, 48, {90}},
                   {V4L2_PIX_FMT_MJPEG, 64, 48, {60, 30, 15}},
                   {V4L2_PIX_FMT_YUYV, 64, 48, {15, 5}},
                   {V4L2_PIX_FMT_YUYV, 32, 24, {60}}};
  const auto chosen = [&](const Json& options) {
    open(options);
    return camera->format().pixelformat;
  };
  EXPECT_EQ(chosen({{"frame_rate_hz", 15}}), V4L2_PIX_FMT_YUYV);
  EXPECT_EQ(chosen({{"frame_rate_hz", 30}}), V4L2_PIX_FMT_MJPEG);
  EXPECT_EQ(chosen({{"width", 32}, {"height", 24}}), V4L2_PIX_FMT_YUYV);
  EXPECT_EQ(chosen({{"width", 64}, {"height", 48}}), V4L2_PIX_FMT_GREY);
  EXPECT_EQ(chosen({{"pixel_format", "mjpeg"}, {"frame_rate_hz", 15}}), V4L2_PIX_FMT_MJPEG);
}

TEST_F(V4l2, ASizeThatIsNotAskedForMayChangeWithTheFormat) {
  const auto camera = plug_in(0, "1", "");
  camera->modes = {{V4L2_PIX_FMT_MJPEG, 640, 480, {30}}, {V4L2_PIX_FMT_YUYV, 64, 48, {30}}};
  open();
  EXPECT_EQ(camera->format().width, 640U);
  camera->modes.erase(camera->modes.begin());
  open({{"pixel_format", "yuyv"}});
  EXPECT_EQ(camera->format().width, 64U);
}

TEST_F(V4l2, NamesWhatTheCameraDoesNotTake) {
  const auto camera = plug_in(0, "1", "A1");
  camera->modes = {{V4L2_PIX_FMT_YUYV, 64, 48, {30, 15}}, {V4L2_PIX_FMT_YUYV, 32, 24, {60}}};
  const auto refused = [&](Json options) {
    options["camera"] = "A1";
    return refusal(options);
  };
  EXPECT_EQ(refused({{"pixel_format", "rgb24"}}),
            "camera \"A1\": pixel_format rgb24 refused: the camera has yuyv");
  EXPECT_EQ(
      refused({{"width", 1000}, {"height", 48}}),
      "camera \"A1\": width x height 1000x48 refused: the camera set 64x48 instead; it has 64x48, 32x24");
  EXPECT_EQ(
      refused({{"width", 64}, {"height", 48}, {"frame_rate_hz", 25}}),
      "camera \"A1\": frame_rate_hz 25 refused: the camera set 30 instead; it has 30, 15 for 64x48 yuyv");
  camera->failing = {{VIDIOC_S_FMT, EBUSY}};
  EXPECT_EQ(refused({{"width", 64}, {"height", 48}}),
            "camera \"A1\": pixel_format yuyv refused: another program uses it");
  camera->failing = {{VIDIOC_REQBUFS, EBUSY}};
  EXPECT_EQ(refused({{"width", 64}, {"height", 48}}), "camera \"A1\": another program uses it");
  camera->failing = {{VIDIOC_STREAMON, ENOSPC}};
  EXPECT_EQ(refused({{"width", 64}, {"height", 48}}),
            "camera \"A1\": does not start: its USB bus has too little bandwidth left");
  EXPECT_EQ(camera->mapped(), 0U);
}

TEST(V4l2Options, UnknownOnesAreRefused) {
  EXPECT_THROW(v4l2_backend().complete({{"exposure", 3}}, "/cameras/0/source"), SettingsError);
  EXPECT_THROW(v4l2_backend().complete({{"buffers", 1}}, "/cameras/0/source"), SettingsError);
  EXPECT_THROW(v4l2_backend().complete({{"controls", 1}}, "/cameras/0/source"), SettingsError);
  EXPECT_EQ(v4l2_backend().complete(Json::object(), "").at("pixel_format"), "auto");
}

// ---- times

TEST_F(V4l2, PicturesHaveTheMiddleOfTheirExposure) {
  const auto camera = plug_in(0, "1", "");
  add_webcam_items(*camera);
  const auto source =
      open({{"controls", {{"auto_exposure", "Manual Mode"}, {"exposure_time_absolute", 2000}}}});
  const auto expect_middle_after = [&](double half_exposure_s) {
    constexpr double kRounding = 1e-3;
    const double before_s = unix_time_s();
    camera->deliver(1);  // the fake stamps the start of the exposure
    const CaptureTimes times = next_picture(*source).times;
    EXPECT_GE(times.t_capture_s, before_s + half_exposure_s - kRounding);
    EXPECT_LE(times.t_capture_s, unix_time_s() + half_exposure_s + kRounding);
    EXPECT_TRUE(times.t_capture_sigma_s);
  };
  expect_middle_after(0.1);
  camera->change_item(V4L2_CID_EXPOSURE_ABSOLUTE, 10000, 0);
  CapturedImage image;
  std::string problem;
  EXPECT_EQ(source->next(image, problem, test::kPatience), CaptureStatus::kTimeout);  // only the event
  expect_middle_after(0.5);

  camera->stamp_flags = 0;
  camera->deliver(1);
  EXPECT_FALSE(next_picture(*source).times.t_capture_sigma_s);
}

// ---- controls

TEST_F(V4l2, ShowsWhatCanBeSet) {
  const auto camera = plug_in(0, "1", "");
  add_webcam_items(*camera);
  const auto add = [&](FakeV4l2::Item item) { camera->items[item.id] = std::move(item); };
  add({V4L2_CID_POWER_LINE_FREQUENCY,
       V4L2_CTRL_TYPE_INTEGER_MENU,
       "Line Frequency",
       0,
       1,
       1,
       1,
       0,
       {"50", "60"}});
  add({V4L2_CID_BASE + 0x1000, V4L2_CTRL_TYPE_BUTTON, "Reset", 0, 0, 0, 0, V4L2_CTRL_FLAG_WRITE_ONLY});
  add({V4L2_CID_BASE + 0x1001, V4L2_CTRL_TYPE_STRING, "Owner", 0, 8, 1, 0, 0, {}, "me"});
  add({V4L2_CID_BASE + 0x1002, V4L2_CTRL_TYPE_INTEGER64, "Time", 0, 1LL << 40, 1, 1LL << 33,
       V4L2_CTRL_FLAG_READ_ONLY});
  add({V4L2_CID_BASE + 0x1003, V4L2_CTRL_TYPE_BITMASK, "Mask", 0, 0xffffffff, 0, -1});
  add({V4L2_CID_BASE + 0x1004, V4L2_CTRL_TYPE_INTEGER, "Gone", 0, 1, 1, 0, V4L2_CTRL_FLAG_DISABLED});
  add({V4L2_CID_BASE + 0x1005, V4L2_CTRL_TYPE_U8, "Matrix", 0, 1});
  const auto source = open();
  std::vector<std::string> names;
  for (const Control& control : source->controls()->list()) names.push_back(control.name);
  EXPECT_THAT(names, ElementsAre("brightness", "white_balance_automatic", "line_frequency", "reset", "owner",
                                 "time", "mask", "auto_exposure", "exposure_time_absolute"));
  const auto control = [&](const char* name) { return source->controls()->get(name); };
  EXPECT_EQ(control("brightness").value, 5);
  EXPECT_EQ(control("brightness").least, -64);
  EXPECT_EQ(control("brightness").category, "User Controls");
  EXPECT_EQ(control("white_balance_automatic").title, "White Balance, Automatic");
  EXPECT_EQ(control("white_balance_automatic").value, true);
  EXPECT_EQ(control("line_frequency").value, "60");
  EXPECT_THAT(control("line_frequency").choices, ElementsAre("50", "60"));
  EXPECT_EQ(control("reset").kind, ControlKind::kAction);
  EXPECT_TRUE(control("reset").value.is_null());
  EXPECT_EQ(control("owner").value, "me");
  EXPECT_EQ(control("time").value, 1LL << 33);
  EXPECT_FALSE(control("time").writable);
  EXPECT_EQ(control("mask").value, 0xffffffff);
  EXPECT_EQ(control("auto_exposure").value, "Aperture Priority Mode");
  EXPECT_THAT(control("auto_exposure").choices, ElementsAre("Manual Mode", "Aperture Priority Mode"));
  EXPECT_FALSE(control("exposure_time_absolute").writable);  // exposure is automatic
  EXPECT_EQ(control("exposure_time_absolute").unit, "100 us");
  EXPECT_EQ(control("exposure_time_absolute").category, "Camera Controls");
}

TEST_F(V4l2, SetsControls) {
  const auto camera = plug_in(0, "1", "");
  add_webcam_items(*camera);
  camera->items[V4L2_CID_BASE + 0x1001] = {V4L2_CID_BASE + 0x1001, V4L2_CTRL_TYPE_STRING, "Owner", 0, 4};
  const auto source = open();
  Controls& controls = *source->controls();
  const auto refused = [&](const char* name, const Json& value) -> std::string {
    try {
      controls.set(name, value);
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "no error";
  };
  controls.set("brightness", -20);
  EXPECT_EQ(camera->value_of(V4L2_CID_BRIGHTNESS), -20);
  EXPECT_EQ(controls.get("brightness").value, -20);
  controls.set("white_balance_automatic", false);
  EXPECT_EQ(controls.get("white_balance_automatic").value, false);
  controls.set("owner", "us");
  EXPECT_EQ(controls.get("owner").value, "us");
  EXPECT_EQ(refused("owner", "nobody"), "owner: \"nobody\" refused: it is too long");
  EXPECT_EQ(refused("exposure_time_absolute", 100),
            "exposure_time_absolute: 100 refused: another control sets it, such as an automatic mode");
  controls.set("auto_exposure", "Manual Mode");
  controls.set("exposure_time_absolute", 100);
  EXPECT_EQ(camera->value_of(V4L2_CID_EXPOSURE_ABSOLUTE), 100);
  EXPECT_EQ(refused("brightness", 100),
            "brightness: 100 is not allowed; expected a whole number from -64 to 64");
  EXPECT_EQ(refused("sharpness", 1), "sharpness: the camera has no such control");
  camera->fail(VIDIOC_S_EXT_CTRLS, ERANGE);
  EXPECT_EQ(refused("brightness", 1), "brightness: 1 refused: Numerical result out of range");
}

TEST_F(V4l2, ControlsAreSetBeforeItDelivers) {
  const auto camera = plug_in(0, "1", "");
  add_webcam_items(*camera);
  // The exposure time is refused until automatic exposure is off, so the order of the settings must not
  // matter.
  const auto source = open({{"controls",
                             {{"exposure_time_absolute", 100},
                              {"auto_exposure", "Manual Mode"},
                              {"zoom", 3},
                              {"brightness", 99}}}});
  EXPECT_THAT(camera->order_set(), ElementsAre(V4L2_CID_EXPOSURE_AUTO, V4L2_CID_EXPOSURE_ABSOLUTE, 0));
  EXPECT_THAT(source->warnings(),
              ElementsAre("brightness: 99 is not allowed; expected a whole number from -64 to 64",
                          "zoom: the camera has no such control"));
}

TEST_F(V4l2, ControlsLiveOnWithoutTheCamera) {
  const auto camera = plug_in(0, "1", "");
  add_webcam_items(*camera);
  auto source = open();
  const std::shared_ptr<Controls> controls = source->controls();
  camera->unplug();
  EXPECT_THROW(controls->set("brightness", 1), CaptureError);
  source.reset();
  EXPECT_THROW(controls->list(), CaptureError);
  EXPECT_THROW(controls->get("brightness"), CaptureError);
}

}  // namespace
}  // namespace sslv::v4l2_test
