// SPDX-License-Identifier: Apache-2.0
#include "kit/sandbox/sandbox.h"

#include "base/clock.h"
#include "base/log.h"
#include "capture/buffer_pool.h"
#include "image/shared_memory.h"
#include "kit/load_stages.h"
#include "kit/read_stamp.h"
#include "kit/sandbox/frame_codec.h"
#include "kit/sandbox/sandbox_step.h"
#include "kit/sandbox/stage_process.h"
#include "kit/sandbox/validate_parts.h"
#include "pipeline/camera_pipeline.h"
#include "pipeline/publish.h"
#include "support/allocation_count.h"
#include "support/becomes.h"
#include "support/child_process.h"
#include "support/held_thread.h"
#include "support/temporary_folder.h"
#include "tracking/gather.h"
#include "tracking/track.h"
#include "unit/kit/sandboxed_stages.h"
#include "vision/detect_balls.h"
#include "vision/detect_robots.h"
#include "vision/find_runs.h"
#include "vision/segment.h"
#include "vision/threshold.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sslv::sandbox_test {
namespace {

using sandbox::Supervisor;
using test::becomes;
using test::kPatience;
using test::Trouble;
using ::testing::HasSubstr;

const char* const kLibrary = SSLV_SANDBOXED_STAGES;

/// Restarts an ended process at once, and waits kPatience for images: on a busy computer a working process
/// may be silent for a while.
Supervisor::Options patient() {
  Supervisor::Options options;
  options.first_pause = options.longest_pause = std::chrono::milliseconds(1);
  options.starts_within = options.longest_wait = kPatience;
  options.longest_silence = options.min_deadline = kPatience;
  return options;
}
/// Each image waits for its stage until the deadline. A process that is silent for longer than
/// `longest_silence` is ended.
Supervisor::Options with_deadlines(std::chrono::milliseconds longest_silence) {
  Supervisor::Options options = patient();
  options.longest_silence = longest_silence;
  options.min_deadline = std::chrono::milliseconds(0);
  return options;
}
constexpr std::chrono::milliseconds kSoon{100};

struct PacketSink : DetectionSink {
  void publish(const FrameInfo& info, const Scene&, const RobotList& robots,
               const BallList& balls) noexcept override {
    ++packets;
    last = info.number;
    has_robots = !robots.robots.empty();
    with_robots += has_robots;
    with_balls += !balls.balls.empty();
    for (const Robot& robot : robots.robots) of_other_frame += robot.x_mm != test::place_in(info.number);
  }
  std::uint32_t last = 0;
  bool has_robots = false;
  std::size_t packets = 0, with_robots = 0, with_balls = 0, of_other_frame = 0;
};

/// A stage that runs inside the service, next to the sandboxed ones.
struct MarkBalls {
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const FrameInfo&, BallList& out) noexcept { out.balls.assign(1, Ball{}); }
};

/// The library's stages, each in a process of its own, and two stages that run inside the service.
struct Apart {
  explicit Apart(const Supervisor::Options& options = patient()) : supervisor(options) {
    rows = sandboxed_rows(kLibrary, supervisor, kPatience);
    take_places(rows.camera);
    rows.camera.push_back(stage<Publish>("publish", ""));
    rows.camera.push_back(stage<MarkBalls>("mark_balls", ""));
  }
  /// Assigns places to the library's own parts, as loading a library into a stage table does.
  static void take_places(std::vector<StageType>& camera) {
    std::size_t places = 0;
    std::set<std::size_t*> placed;
    for (StageType& row : camera) {
      for (const OwnPartUse& use : row.own_parts) {
        if (placed.insert(use.place).second) *use.place = places++;
      }
    }
  }
  Supervisor supervisor;
  StageRows rows;
};

template <class Floor>
const BasicStageType<Floor>& row(const std::vector<BasicStageType<Floor>>& rows, const std::string& name) {
  return *std::ranges::find_if(rows, [&](const auto& one) { return one.name == name; });
}

/// Two of every eight cells have a colour label: random images give many runs, regions and dots.
std::shared_ptr<const Lut> busy_lut(unsigned shift = 0) {
  std::vector<Label> table(Lut::kEntries);
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = (i + shift) % 8 < 6 ? label::kClear : static_cast<Label>(2 + (i + shift) % 6);
  return std::make_shared<Lut>(std::move(table));
}

std::shared_ptr<Scene> calibrated_scene() {
  CameraCalibration calibration;
  calibration.principal_point_x = 100, calibration.principal_point_y = 80;
  calibration.q0 = 1, calibration.q3 = 0, calibration.tz = 4000;
  auto scene = std::make_shared<Scene>();
  scene->camera.emplace(calibration);
  scene->roster[1].set(7);
  return scene;
}

MaskSettings triangle() {
  MaskSettings settings;
  settings.include.push_back({{{10, 10}, {50, 10}, {50, 50}}});
  return settings;
}

CameraContext context_of(std::shared_ptr<const Scene> scene, std::shared_ptr<const Lut> lut) {
  return {std::move(scene), std::move(lut), std::make_shared<Mask>(),
          std::make_shared<PatternTable>(league_patterns())};
}

CameraSetup setup_of(std::span<const StageType> table, const std::vector<std::string>& stack,
                     const Json& stages = Json::object()) {
  CameraSetup setup;
  setup.pipeline = std::make_shared<Pipeline>(table, stack, "/stack");
  setup.parameters = setup.pipeline->make_parameters(stages, "/stages");
  setup.context = context_of(calibrated_scene(), busy_lut());
  return setup;
}

/// Random images, in private memory or in a shared buffer pool like a driver's.
class Images {
 public:
  explicit Images(unsigned seed) : random_(seed) {}
  void start_again(unsigned seed) { random_.seed(seed); }
  Image next(bool is_shared, int width = 200, int height = 160, bool is_deep = false) {
    const ImageView layout{
        nullptr, width, height, width * 2, PixelFormat::kUyvy, is_deep ? width * 2 * height : 0};
    const auto bytes = static_cast<std::size_t>(width * height * (is_deep ? 4 : 2));
    if (is_shared) {
      if (!pool_) {
        share_new_images(true);
        pool_.emplace(20, std::size_t{1} << 20);
        share_new_images(false);
      }
      std::uint8_t* to = nullptr;
      Image image = pool_->take(layout, to);
      fill(to, bytes);
      return image;
    }
    own_.resize(bytes);
    fill(own_.data(), bytes);
    ImageView view = layout;
    view.data = own_.data();
    return {view, nullptr, nullptr, nullptr};
  }

 private:
  void fill(std::uint8_t* to, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) to[i] = static_cast<std::uint8_t>(random_());
  }
  std::mt19937 random_;
  std::optional<BufferPool> pool_;
  std::vector<std::uint8_t> own_;
};

/// A part's encoding: equal bytes mean equal contents.
template <class T>
std::vector<std::byte> bytes_of(const T& part) {
  std::vector<std::byte> bytes(std::size_t{8} << 20);
  ByteWriter writer(bytes);
  encode(part, writer);
  EXPECT_TRUE(writer.fits());
  bytes.resize(writer.written());
  return bytes;
}

/// Compares every number, member by member: padding does not count.
template <class T>
bool same(const T& a, const T& b) {
  if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    return a == b;
  } else if constexpr (requires {
                         a.begin();
                         a.size();
                       }) {
    return a.size() == b.size() &&
           std::equal(a.begin(), a.end(), b.begin(), [](const auto& x, const auto& y) { return same(x, y); });
  } else {
    const auto left = members_of(a), right = members_of(b);
    return [&]<std::size_t... kI>(std::index_sequence<kI...>) {
      return (same(std::get<kI>(left), std::get<kI>(right)) && ...);
    }
    (std::make_index_sequence<std::tuple_size_v<decltype(left)>>{});
  }
}

void expect_equal_parts(const Frame& a, const Frame& b) {
  ASSERT_EQ(bytes_of(a.labels), bytes_of(b.labels));
  ASSERT_TRUE(same(a.runs, b.runs));
  ASSERT_TRUE(same(a.regions, b.regions));
  ASSERT_TRUE(same(a.robots, b.robots));
  ASSERT_TRUE(same(a.balls, b.balls));
}

/// Child processes of `of`, without zombies.
std::vector<pid_t> stage_processes(pid_t of = ::getpid()) {
  std::vector<pid_t> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream stat(entry.path() / "stat");
    std::string text;
    std::getline(stat, text);
    const std::size_t after = text.rfind(')');
    if (after == std::string::npos) continue;
    char state = 0;
    int parent = 0;
    if (std::sscanf(text.c_str() + after + 1, " %c %d", &state, &parent) == 2 && parent == of && state != 'Z')
      found.push_back(std::stoi(name));
  }
  return found;
}

std::size_t open_files() {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator("/proc/self/fd"),
                                                std::filesystem::directory_iterator()));
}

/// Resident memory of this process in KiB.
long resident_kib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) return std::stol(line.substr(6));
  }
  return 0;
}

TEST(SandboxedRows, AreAsTheLibrarySays) {
  const Apart apart;
  const StageRows inside = load_rows(kLibrary);
  ASSERT_EQ(apart.rows.camera.size(), inside.camera.size() + 2);
  for (std::size_t i = 0; i < inside.camera.size(); ++i) {
    const StageType &a = apart.rows.camera[i], &b = inside.camera[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.help, b.help);
    EXPECT_EQ(a.reads, b.reads);
    EXPECT_EQ(a.writes, b.writes);
    EXPECT_EQ(a.updates, b.updates);
    EXPECT_EQ(a.takes, b.takes);
    EXPECT_EQ(a.library, "sandboxed_stages.so");
    ASSERT_EQ(a.own_parts.size(), b.own_parts.size());
    for (std::size_t p = 0; p < a.own_parts.size(); ++p) {
      EXPECT_EQ(a.own_parts[p].type.name, b.own_parts[p].type.name);
      EXPECT_EQ(a.own_parts[p].type.layout, b.own_parts[p].type.layout);
      EXPECT_EQ(a.own_parts[p].is_written, b.own_parts[p].is_written);
    }
    Json schema = a.schema();
    EXPECT_EQ(schema["properties"]["deadline_ms"]["default"], 10.0);
    schema["properties"].erase("deadline_ms");
    EXPECT_EQ(schema, b.schema());
  }
  EXPECT_EQ(apart.rows.field.size(), inside.field.size());
}

TEST(SandboxedRows, ParametersAreReadByTheLibrary) {
  const Apart apart;
  const StageType& type = row(apart.rows.camera, "see_all");
  const Json complete = type.parse({{"deadline_ms", 5}}, "/stages/see_all").complete;
  EXPECT_EQ(complete, Json({{"factor", 2.0}, {"deadline_ms", 5.0}}));
  const auto refusal = [&](const Json& json) -> std::string {
    try {
      type.parse(json, "/stages/see_all");
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({{"factor", 5}}), [] {
    try {
      stage<test::SeeAll>("", "").parse({{"factor", 5}}, "/stages/see_all");
    } catch (const SettingsError& error) {
      return std::string(error.what());
    }
    return std::string();
  }());
  EXPECT_THAT(refusal({{"deadline_ms", 0.1}}), HasSubstr("/stages/see_all/deadline_ms: 0.1 is not allowed"));
  EXPECT_THAT(refusal({{"other", 1}}), HasSubstr("/stages/see_all/other: no such parameter"));
}

TEST(SandboxedRows, AStageThatSendsIsRefused) {
  ::setenv("SSLV_TEST_PUBLISHES", "1", 1);
  Supervisor supervisor(patient());
  try {
    sandboxed_rows(kLibrary, supervisor, kPatience);
    ADD_FAILURE() << "is not refused";
  } catch (const StageLibraryError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("stage 'publishes' cannot run in a process of its own: it sends results itself"));
  }
  ::unsetenv("SSLV_TEST_PUBLISHES");
}

/// Sets an environment variable to 1 for its own lifetime.
struct Variable {
  explicit Variable(const char* its_name) : name(its_name) { ::setenv(name, "1", 1); }
  ~Variable() { ::unsetenv(name); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;
  const char* name;
};

TEST(SandboxedRows, ANonFiniteDefaultIsRefused) {
  const Variable set("SSLV_TEST_NAN_DEFAULT");
  Supervisor supervisor(patient());
  try {
    sandboxed_rows(kLibrary, supervisor, kPatience);
    ADD_FAILURE() << "is not refused";
  } catch (const StageLibraryError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("its parameter 'a' has a default or a range that is not a finite number"));
  }
}

TEST(SandboxedRows, DoNotWaitForALibrarysChildProcesses) {
  const Variable set("SSLV_TEST_LEAVES_CHILD");
  Supervisor supervisor(patient());
  EXPECT_FALSE(sandboxed_rows(kLibrary, supervisor, kPatience).camera.empty());
}

/// Why create() fails.
std::string why_not_made(const StageType& type) {
  try {
    type.create();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "it is made";
}

TEST(SandboxedRows, ALibraryThatWasExchangedIsRefused) {
  const Apart apart;
  const Variable set("SSLV_TEST_OTHER_PARTS");
  EXPECT_EQ(why_not_made(row(apart.rows.camera, "double_tags")), "it is made");
  EXPECT_THAT(why_not_made(row(apart.rows.camera, "find_tags")),
              HasSubstr("its library was replaced and has other parts now"));
}

TEST(SandboxedRows, AStampIsReadAgainAtEachStart) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "stages.so";
  std::filesystem::copy_file(kLibrary, file);
  Supervisor supervisor(patient());
  const StageRows rows = sandboxed_rows(file, supervisor, kPatience);
  std::ifstream in(kLibrary, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), {});
  bytes[bytes.find(std::string(kStampMagic) + '\0') + offsetof(StageStamp, kit_version)] = 99;
  std::filesystem::remove(file);
  std::ofstream(file, std::ios::binary) << bytes;
  EXPECT_THAT(why_not_made(row(rows.camera, "find_tags")),
              HasSubstr("is built for version 99 of the stage kit"));
}

TEST(SandboxedRows, AStageThatHangsAtStartIsWaitedForOnce) {
  Supervisor::Options options = patient();
  options.longest_wait = std::chrono::milliseconds(20);
  const Apart apart(options);
  std::vector<std::unique_ptr<Step<CameraFloor>>> steps;
  for (int i = 0; i < 8; ++i) steps.push_back(row(apart.rows.camera, "hangs_at_start").create());
  EXPECT_TRUE(becomes([] { return stage_processes().size() == 8; })) << "they start all the same";
}

TEST(SandboxedRows, AMissingLibraryIsRefused) {
  Supervisor supervisor(patient());
  EXPECT_THROW(sandboxed_rows("/nowhere/stages.so", supervisor, kPatience), StageLibraryError);
}

TEST(SandboxedRows, AConstructorsExceptionIsReportedAtOnce) {
  const Apart apart;
  const CameraSetup setup = setup_of(apart.rows.camera, {"cannot_start"});
  EXPECT_EQ(setup.pipeline->note(0).kind, StageNotes::Kind::kWarning);
  EXPECT_THAT(setup.pipeline->note(0).text, HasSubstr("cannot start: there is no such device"));
}

/// Runs the stack inside the service and in sandboxes on the same random images, and expects equal results.
/// `change` may modify the context of both.
void expect_equal(const Apart& apart, const std::vector<StageType>& inside,
                  const std::vector<std::string>& stack,
                  const std::function<void(int, CameraContext&)>& change,
                  const Json& stages = Json::object()) {
  PacketSink sink;
  const CameraSetup ours = setup_of(inside, stack, stages),
                    theirs = setup_of(apart.rows.camera, stack, stages);
  CameraPipeline a(3, sink, ours), b(3, sink, theirs);
  Images images_a(1), images_b(1);
  CameraContext context = ours.context;
  for (int i = 0; i < 30; ++i) {
    change(i, context);
    CameraSetup next_a = ours, next_b = theirs;
    next_a.context = next_b.context = context;
    a.change(next_a);
    b.change(next_b);
    const bool is_shared = i % 3 != 0, is_deep = i % 5 == 0;
    const int width = i < 20 ? 200 : 160;
    const Frame& in =
        a.process(images_a.next(false, width, 160, is_deep), {100.0 + i, 5.0, std::nullopt, i % 2 == 0});
    const Frame& out =
        b.process(images_b.next(is_shared, width, 160, is_deep), {100.0 + i, 5.0, std::nullopt, i % 2 == 0});
    const testing::ScopedTrace trace(__FILE__, __LINE__, stack[0] + ", frame " + std::to_string(i));
    ASSERT_NO_FATAL_FAILURE(expect_equal_parts(in, out)) << b.setup()->pipeline->note(0).text;
    ASSERT_FALSE(bytes_of(in.balls) == bytes_of(BallList{}) &&
                 bytes_of(in.regions) == bytes_of(RegionList{}));
  }
}

TEST(SandboxedStage, DoesTheSameAsInTheService) {
  const Apart apart;
  std::vector<StageType> inside = load_rows(kLibrary).camera;
  inside.push_back(stage<Publish>("publish", ""));
  const auto change = [](int i, CameraContext& context) {
    if (i % 4 == 1) context.adapted_lut = busy_lut(static_cast<unsigned>(i));
    if (i % 5 == 2) {
      auto scene = calibrated_scene();
      scene->field.ball_radius = 20 + i;
      context.scene = scene;
    }
    if (i == 9) context.scene = std::make_shared<Scene>();
    if (i == 13) context.mask = std::make_shared<Mask>(triangle());
    if (i == 17) {
      auto patterns = std::make_shared<PatternTable>(league_patterns());
      patterns->codes.pop_back();
      context.patterns = patterns;
    }
  };
  expect_equal(apart, inside, {"see_all"}, change, {{"see_all", {{"factor", 3}}}});
  expect_equal(apart, inside, {"segment", "detect_robots", "detect_balls"}, change);
  expect_equal(apart, inside, {"threshold", "find_runs", "see_all"}, change);
}

TEST(SandboxedStage, PartsOfLibrariesGoFromOneProcessToTheNext) {
  const Apart apart;
  PacketSink sink;
  CameraPipeline camera(
      0, sink, setup_of(apart.rows.camera, {"mark_balls", "find_tags", "double_tags", "count_tags"}));
  for (unsigned i = 0; i < 20; ++i) {
    const Frame& frame = camera.process({}, {});
    ASSERT_EQ(frame.balls.balls.size(), 4u);
    EXPECT_EQ(frame.balls.balls[3].x_mm, 4);
    EXPECT_EQ(frame.balls.balls[3].y_mm, i + 0.5);
    EXPECT_EQ(frame.balls.balls[3].area_px, 2u);
  }
}

TEST(SandboxedStage, AnInvalidReplyLeavesALibrarysPartUnchanged) {
  const Apart apart;
  const StageRows inside = load_rows(kLibrary);
  std::vector<StageType> rows{row(inside.camera, "find_tags"), row(inside.camera, "count_tags"),
                              row(apart.rows.camera, "spoil_tags"), stage<MarkBalls>("mark_balls", "")};
  for (const StageType& one : rows) {
    for (const OwnPartUse& use : one.own_parts) *use.place = 0;  // the only part of a library
  }
  PacketSink sink;
  CameraPipeline camera(0, sink, setup_of(rows, {"mark_balls", "find_tags", "spoil_tags", "count_tags"}));
  for (unsigned i = 0; i < 5; ++i) {
    const Frame& frame = camera.process({}, {});
    ASSERT_EQ(frame.balls.balls.size(), 4U);
    for (int tag = 0; tag < 3; ++tag) {
      EXPECT_EQ(frame.balls.balls[1 + static_cast<std::size_t>(tag)].x_mm, tag);
      EXPECT_EQ(frame.balls.balls[1 + static_cast<std::size_t>(tag)].y_mm, i + 0.5);
    }
  }
  EXPECT_THAT(camera.setup()->pipeline->note(2).text, HasSubstr("gave invalid results for 5 of"));
}

TEST(SandboxedStage, TooLongAListIsNotAllocated) {
  Frame sent;
  sent.balls.balls.resize(250'000);
  PartSet balls;
  balls.set(part_index<CameraFloor, BallList>());
  std::vector<std::byte> bytes(std::size_t{64} << 20);
  ByteWriter writer(bytes);
  EXPECT_FALSE(sandbox::encode_parts<CameraFloor>(sent, balls, writer, true)) << "who sends it sees that";
  ASSERT_TRUE(writer.fits());
  std::span<const std::byte> all = std::span(bytes).first(writer.written());
  Frame received;
  EXPECT_FALSE(sandbox::decode_limited_parts<CameraFloor>(all, received, balls));
  EXPECT_EQ(received.balls.balls.capacity(), 0U);
}

TEST(SandboxedStage, ItsNotesComeBack) {
  const Apart apart;
  PacketSink sink;
  const CameraSetup setup = setup_of(apart.rows.camera, {"see_all"});
  CameraPipeline camera(0, sink, setup);
  Images images(1);
  camera.process(images.next(false), {});
  EXPECT_EQ(setup.pipeline->note(0).text, "odd");
  EXPECT_EQ(setup.pipeline->note(0).kind, StageNotes::Kind::kWarning);
  camera.process(images.next(false), {});
  EXPECT_EQ(setup.pipeline->note(0).text, "even");
  EXPECT_EQ(setup.pipeline->note(0).kind, StageNotes::Kind::kNote);
}

struct TestClock : FieldClock {
  double now_s() const noexcept override { return time_s; }
  double time_s = 1000;
};
struct TrackSink : FieldSink {
  void publish(const TrackedField&) noexcept override {}
};

TEST(SandboxedFieldStage, DoesTheSameAsInTheService) {
  const Apart apart;
  const std::vector<FieldStageType> inside = load_rows(kLibrary).field;
  for (const std::vector<std::string>& stack :
       {std::vector<std::string>{"field_all"}, {"gather", "field_all"}}) {
    // Only `arrived` must be written before: `tracked` and `observations` count as written by another stage.
    std::vector<FieldStageType> rows_a = inside, rows_b = apart.rows.field;
    for (auto* rows : {&rows_a, &rows_b}) {
      for (FieldStageType& one : *rows) one.reads &= PartSet(1);
    }
    FieldPipeline a(rows_a, stack, ""), b(rows_b, stack, "");
    const auto params_a = a.make_parameters(Json::object(), ""),
               params_b = b.make_parameters(Json::object(), "");
    FieldFrame frame_a, frame_b;
    TestClock clock;
    TrackSink sink;
    FieldSize field;
    field.field_lines.emplace(2, FieldLine{"line", 1, 2, 3, 4, 10});
    BallModel ball;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> anywhere(-1, 1);
    for (unsigned i = 0; i < 50; ++i) {
      clock.time_s += 0.01;
      ball.radius_mm += 1;
      CameraSightings& image = frame_a.arrived.image;
      image.frame_number = i;
      image.t_capture_s = clock.time_s - 0.01;
      image.camera_mm = {0, 0, 4000};
      image.robots.resize(i % 7);
      for (RobotSighting& robot : image.robots) {
        robot.team = random() % 2 == 0 ? Team::kBlue : Team::kYellow;
        robot.id = static_cast<int>(random() % 16);
        robot.place_mm = {anywhere(random), anywhere(random)};
        robot.orientation_rad = anywhere(random);
        robot.height_mm = 140;
        robot.place_cov_mm2 = Eigen::Matrix2d::Identity() * (1 + anywhere(random) / 2);
        robot.orientation_sigma_rad = 0.01;
      }
      image.balls.resize(i % 3);
      for (BallSighting& one : image.balls) {
        one.place_mm = {anywhere(random), anywhere(random)};
        one.place_cov_mm2 = Eigen::Matrix2d::Identity();
        one.confidence = 1;
      }
      frame_b.arrived = frame_a.arrived;
      a.run({frame_a, field, ball, clock, sink}, params_a);
      b.run({frame_b, field, ball, clock, sink}, params_b);
      ASSERT_EQ(bytes_of(frame_a.observations), bytes_of(frame_b.observations)) << i;
      ASSERT_EQ(bytes_of(frame_a.tracked), bytes_of(frame_b.tracked)) << i;
      ASSERT_EQ(bytes_of(frame_a.sightings), bytes_of(frame_b.sightings)) << i;
      ASSERT_EQ(bytes_of(frame_a.left_out), bytes_of(frame_b.left_out)) << i;
      ASSERT_EQ(frame_a.tracked.number, i + 1);
    }
  }
}

TEST(SandboxedStage, AllocatesNothingInTheService) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  const Apart apart;
  PacketSink sink;
  CameraPipeline camera(0, sink,
                        setup_of(apart.rows.camera, {"find_tags", "double_tags", "segment", "detect_robots",
                                                     "detect_balls", "publish"}));
  Images images(1);
  const auto run = [&](int frames) {
    for (int i = 0; i < frames; ++i) {
      images.start_again(static_cast<unsigned>(i) % 5);
      camera.process(images.next(i % 2 == 0), {});
    }
  };
  run(200);
  const auto before = allocation_count();
  run(300);
  EXPECT_EQ(allocation_count() - before, 0u);
}

/// A camera with a working stage, one that misbehaves, and publish.
struct Troubled {
  explicit Troubled(Trouble trouble, const Supervisor::Options& options = patient(), double deadline_ms = 10)
      : apart(options), setup(of(trouble, deadline_ms)), camera(0, sink, setup) {}
  CameraSetup of(Trouble trouble, double deadline_ms) const {
    return setup_of(
        apart.rows.camera, {"mark_balls", "make_trouble", "publish"},
        {{"make_trouble", {{"trouble", static_cast<int>(trouble)}, {"deadline_ms", deadline_ms}}}});
  }
  void frame() {
    camera.process({}, {});
    ++frames;
    EXPECT_EQ(sink.packets, frames);
    EXPECT_EQ(sink.last + 1, frames);
    EXPECT_EQ(sink.with_balls, frames);
    EXPECT_EQ(sink.of_other_frame, 0u);
  }
  StageNotes::Note note() const { return setup.pipeline->note(1); }
  int times_started_again() const {
    const std::string text = note().text, before = "; restarted ";
    const std::size_t at = text.find(before);
    return at == std::string::npos ? 0 : std::stoi(text.substr(at + before.size()));
  }
  Apart apart;
  PacketSink sink;
  CameraSetup setup;
  CameraPipeline camera;
  std::size_t frames = 0;
};

TEST(SandboxedStage, ACrashIsReportedAndCostsOnlyItsOwnResults) {
  Troubled troubled(Trouble::kCrash);
  EXPECT_TRUE(becomes([&] {
    troubled.frame();
    return troubled.times_started_again() >= 3;
  })) << troubled.note().text;
  EXPECT_THAT(troubled.note().text, HasSubstr("its process was killed by signal 11 at "));
  EXPECT_EQ(troubled.note().kind, StageNotes::Kind::kWarning);
  EXPECT_EQ(troubled.sink.with_robots, 0u);
}

TEST(SandboxedStage, AnExitIsReported) {
  Troubled troubled(Trouble::kExit);
  EXPECT_TRUE(becomes([&] {
    troubled.frame();
    return troubled.note().text.find("its process exited with code 3 at ") != std::string::npos;
  })) << troubled.note().text;
}

TEST(SandboxedStage, AHangingProcessIsRestarted) {
  Troubled troubled(Trouble::kHang, with_deadlines(kSoon), 1);
  EXPECT_TRUE(becomes([&] {
    troubled.frame();
    return troubled.times_started_again() >= 2;
  })) << troubled.note().text;
  EXPECT_EQ(troubled.sink.with_robots, 0u);
}

TEST(SandboxedStage, ALateAnswerIsNeverOfALaterFrame) {
  Supervisor::Options options = with_deadlines(kPatience);
  options.most_failures_in_a_row = 1'000'000;
  Troubled troubled(Trouble::kSlow, options, 1);
  for (int i = 0; i < 2000; ++i) {
    troubled.frame();
    const timespec pause{0, 200'000};
    ::nanosleep(&pause, nullptr);
  }
  // If this thread is delayed as well, an answer may still be in time.
  EXPECT_TRUE(becomes([&] {
    troubled.frame();
    return troubled.note().text.find("took longer than 1 ms for ") != std::string::npos;
  })) << troubled.note().text;
  // With a deadline that it meets, its results are used again.
  CameraSetup quick_one = troubled.setup;
  quick_one.parameters =
      troubled.setup.pipeline->make_parameters({{"make_trouble", {{"deadline_ms", 1000}}}}, "");
  troubled.camera.change(quick_one);
  EXPECT_TRUE(becomes([&] {
    troubled.frame();
    return troubled.sink.has_robots;
  }));
}

TEST(SandboxedStage, ItsNotesAreShownBesideItsErrors) {
  const sandbox::StageProcess process("stage", "library", "camera", "");
  sandbox::SandboxReport report;
  StageNotes notes;
  const auto told = [&] {
    report.tell(process, 10, notes);
    return std::pair(notes.read().kind, notes.read().text);
  };
  report.set_own_note(StageNotes::Kind::kNote, std::string_view("2 balls removed"));
  report.add(sandbox::SandboxReport::Outcome::kDone);
  EXPECT_EQ(told(), std::pair(StageNotes::Kind::kNote, std::string("2 balls removed")));
  report.add(sandbox::SandboxReport::Outcome::kLate);
  EXPECT_EQ(told(), std::pair(StageNotes::Kind::kWarning,
                              std::string("took longer than 10 ms for 1 of the last 512 images, which were "
                                          "processed without its results; it says: 2 balls removed")));
  report.set_own_note(StageNotes::Kind::kWarning, std::string(StageNotes::kMaxText, 'x'));
  EXPECT_THAT(told().second, AllOf(testing::SizeIs(StageNotes::kMaxText), HasSubstr("it says: xxx")));
}

TEST(SandboxedStage, InvalidResultsAreDropped) {
  for (const Trouble trouble : {Trouble::kNan, Trouble::kOverlong, Trouble::kBadRegions}) {
    Troubled troubled(trouble);
    for (int i = 0; i < 10; ++i) troubled.frame();
    EXPECT_EQ(troubled.sink.with_robots, 0u) << static_cast<int>(trouble);
    EXPECT_THAT(troubled.note().text, HasSubstr("gave invalid results for 10 of the last 512 images"));
  }
}

/// The image's other results are used, as with a stage inside the service.
TEST(SandboxedStage, OnlyTheInvalidRobotIsDropped) {
  Troubled troubled(Trouble::kBadId);
  for (int i = 0; i < 10; ++i) troubled.frame();
  EXPECT_EQ(troubled.sink.with_robots, 0u);
  EXPECT_EQ(troubled.setup.pipeline->left_out(1).robots, 10u);
  EXPECT_EQ(troubled.note().kind, StageNotes::Kind::kNone) << troubled.note().text;
}

TEST(SandboxedStage, ItsProcessSurvivesTooLargeImages) {
  Supervisor::Options options = patient();
  options.most_failures_in_a_row = 3;
  const Apart apart(options);
  PacketSink sink;
  const CameraSetup setup = setup_of(apart.rows.camera, {"threshold"});
  CameraPipeline camera(0, sink, setup);
  Images images(1);
  const std::vector<pid_t> before = stage_processes();
  ASSERT_EQ(before.size(), 1u);
  // This image is larger than the memory shared with the process, and not in shared memory itself.
  const std::vector<std::uint8_t> pixels(std::size_t{16'384} * 4100);
  const Image large({pixels.data(), 16'384, 4100, 16'384, PixelFormat::kMono8, 0}, nullptr, nullptr, nullptr);
  for (int i = 0; i < 10; ++i) camera.process(Image(large.view(), nullptr, nullptr, nullptr), {});
  EXPECT_EQ(setup.pipeline->note(0).text,
            "was skipped for 10 of the last 512 images: no space for the parts that it reads");
  // The same process continues with images that fit.
  EXPECT_TRUE(becomes([&] { return camera.process(images.next(false), {}).labels.width > 0; }));
  EXPECT_EQ(stage_processes(), before);
}

TEST(SandboxedStage, APausedSupervisorDelaysNoImage) {
  sandbox::StageProcess process("stage", "library", "camera", "");
  sandbox::SandboxReport report;
  StageNotes notes;
  sandbox::StageProcess::Losses losses;
  expect_never_waits(
      [&] {
        ++losses.count;
        process.losses.store(losses);
      },
      [&] {
        report.add(sandbox::SandboxReport::Outcome::kNoProcess);
        report.tell(process, 10, notes);
      });
}

TEST(SandboxedStage, GarbageInTheSharedMemoryHarmsNobody) {
  Troubled troubled(Trouble::kScribble, with_deadlines(kSoon), 2);
  for (int i = 0; i < 3000; ++i) {
    const Frame& frame = troubled.camera.process({}, {});
    ++troubled.frames;
    EXPECT_EQ(troubled.sink.packets, troubled.frames);
    EXPECT_EQ(frame.balls.balls.size(), 1u);
    for (const Robot& robot : frame.robots.robots) EXPECT_TRUE(is_valid(robot));
    EXPECT_TRUE(sandbox::is_valid(frame.regions, frame));
    (void)troubled.note();
  }
}

TEST(SandboxedStage, ItsOutputIsLogged) {
  log::set_level(log::Level::kInfo);
  Troubled troubled(Trouble::kPrints);
  troubled.frame();
  EXPECT_TRUE(becomes([&] {
    const auto lines = log::recent().newer_than(0, log::Level::kInfo).lines;
    return std::ranges::any_of(
        lines, [](const auto& line) { return line.text == "stage 'make_trouble': line 3 of frame 0"; });
  }));
  log::set_level(log::Level::kError);
}

/// Expects that no frame is lost and nothing leaks.
void kill_again_and_again(int kills) {
  Supervisor::Options options = patient();
  options.longest_silence = std::chrono::seconds(1);
  Troubled troubled(Trouble::kNone, options);
  const auto works = [&] {
    return becomes([&] {
      troubled.frame();
      return troubled.sink.has_robots;
    });
  };
  ASSERT_TRUE(works());
  std::size_t files = 0;
  long memory_kib = 0;
  for (int i = 0; i < kills; ++i) {
    if (i == kills / 10) {
      files = open_files();
      memory_kib = resident_kib();
    }
    // Some processes hang or crash instead of being killed.
    const int signal = i % 20 == 19 ? SIGSTOP : i % 4 == 3 ? SIGSEGV : SIGKILL;
    std::vector<pid_t> processes;
    ASSERT_TRUE(becomes([&] {
      processes = stage_processes();
      return processes.size() == 1 && ::kill(processes[0], signal) == 0;
    }));
    ASSERT_TRUE(becomes([&] {
      troubled.frame();
      return !troubled.sink.has_robots || stage_processes() != processes;
    }));
    ASSERT_TRUE(works()) << i << " " << troubled.note().text;
  }
  // On a busy computer, a working process may also exceed the longest silence and be ended.
  EXPECT_GE(troubled.times_started_again(), kills) << troubled.note().text;
  EXPECT_EQ(open_files(), files);
  EXPECT_LE(resident_kib() - memory_kib, 4096);
}

TEST(SandboxedStage, KilledAgainAndAgainNoFrameIsLostAndNothingLeaks) {
  kill_again_and_again(20);
}

TEST(SandboxedStage, KilledForLongNoFrameIsLostAndNothingLeaks) {
  kill_again_and_again(200);
}

TEST(SandboxedStage, NoProcessAndNoFileIsLeft) {
  const std::size_t before = open_files();
  {
    Troubled troubled(Trouble::kNone);
    troubled.frame();
    EXPECT_EQ(stage_processes().size(), 1u);
  }
  EXPECT_EQ(open_files(), before);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST(SandboxedStage, ItEndsWithItsStack) {
  Troubled troubled(Trouble::kNone);
  troubled.frame();
  troubled.setup = {};
  troubled.camera.change(setup_of(troubled.apart.rows.camera, {"mark_balls"}));
  (void)troubled.camera.setup();
  EXPECT_TRUE(becomes([] { return stage_processes().empty(); }));
}

TEST(SandboxedStage, GoesOnWithoutItsSupervisor) {
  auto supervisor = std::make_unique<Supervisor>(patient());
  StageRows rows = sandboxed_rows(kLibrary, *supervisor, kPatience);
  const auto step = row(rows.camera, "make_trouble").create();
  supervisor.reset();
  Frame frame;
  const CameraContext context = context_of(calibrated_scene(), busy_lut());
  PacketSink sink;
  const auto params = row(rows.camera, "make_trouble").parse(Json::object(), "").params;
  step->run({frame, context, sink}, params.get());
  EXPECT_TRUE(frame.robots.robots.empty());
}

TEST(SandboxedStage, EndsWithTheServiceAlsoWhenItHangs) {
  test::ChildProcess service({"/proc/self/exe", "--hang"});
  service.wait_for_line("hangs");
  const auto processes = stage_processes(service.pid());
  ASSERT_EQ(processes.size(), 1u);
  const int pidfd = static_cast<int>(::syscall(SYS_pidfd_open, processes[0], 0));
  ASSERT_GE(pidfd, 0);
  service.send_signal(SIGKILL);
  pollfd ended{pidfd, POLLIN, 0};
  EXPECT_EQ(::poll(&ended, 1, std::chrono::milliseconds(kPatience).count()), 1);
  ::close(pidfd);
}

/// A stage's process inherits only what the service passes to it explicitly.
TEST(SandboxedStage, ItsProcessHasNoMoreThanItNeeds) {
  const int secret = ::open("/dev/null", O_RDONLY);  // without O_CLOEXEC
  Troubled troubled(Trouble::kNone);
  troubled.frame();
  const auto processes = stage_processes();
  ASSERT_EQ(processes.size(), 1u);
  const auto proc = std::filesystem::path("/proc") / std::to_string(processes[0]);
  std::set<std::string> files;
  for (const auto& file : std::filesystem::directory_iterator(proc / "fd"))
    files.insert(file.path().filename());
  EXPECT_EQ(files, (std::set<std::string>{"0", "1", "2", "3", "4", "5"}));
  std::ifstream status(proc / "status");
  std::string all((std::istreambuf_iterator<char>(status)), {});
  EXPECT_THAT(all, HasSubstr("NoNewPrivs:\t1"));
  EXPECT_THAT(all, HasSubstr("SigBlk:\t0000000000000000"));
  ::close(secret);
}

TEST(SharedMemory, LocatesAddressesInIt) {
  const SharedMemory a(8192), b(4096);
  std::vector<std::uint8_t> other(100);
  const auto place = shared_place(a.data() + 100, 8092);
  ASSERT_TRUE(place);
  EXPECT_EQ(place->id, a.id());
  EXPECT_EQ(place->offset, 100u);
  EXPECT_EQ(shared_place(b.data(), 4096)->id, b.id());
  EXPECT_FALSE(shared_place(a.data() + 100, 8093)) << "not all of it lies there";
  EXPECT_FALSE(shared_place(other.data(), 100));
  EXPECT_EQ(::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, a.file(), 0), MAP_FAILED);
}

TEST(PartCodec, RefusesInvalidBytes) {
  Observations part;
  part.robots.resize(3);
  part.balls.resize(2);
  std::vector<std::byte> bytes = bytes_of(part);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const std::span<const std::byte> all = bytes;
    ByteReader reader(all.first(length));
    Observations out;
    EXPECT_FALSE(decode(reader, out)) << length;
  }
  std::mt19937 random(1);
  for (int i = 0; i < 20'000; ++i) {
    auto changed = bytes;
    for (int n = 0; n < 3; ++n) changed[random() % changed.size()] = static_cast<std::byte>(random());
    ByteReader reader(changed, true);
    Observations out;
    if (!decode(reader, out)) continue;
    EXPECT_LE(out.robots.size(), 8u);
    for (const auto& robot : out.robots) EXPECT_LE(static_cast<int>(robot.name.team), 1);
  }
}

int hang() {
  Troubled troubled(Trouble::kHang, with_deadlines(std::chrono::hours(1)), 1);
  troubled.frame();
  std::cout << "hangs" << std::endl;
  for (;;) ::pause();
}

}  // namespace
}  // namespace sslv::sandbox_test

int main(int argc, char** argv) {
  if (const auto code = sslv::stage_process_main(argc, argv)) return *code;
  sslv::log::set_level(sslv::log::Level::kError);
  if (argc > 1 && std::string_view(argv[1]) == "--hang") return sslv::sandbox_test::hang();
  ::testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
