// SPDX-License-Identifier: Apache-2.0
#include "unit/kit/sandboxed_stages.h"

#include "kit/stages.h"
#include "tracking/gather.h"
#include "tracking/track.h"
#include "vision/detect_balls.h"
#include "vision/detect_robots.h"
#include "vision/find_runs.h"
#include "vision/segment.h"
#include "vision/threshold.h"

#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <thread>

#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

namespace sslv::test {
namespace {

/// Keeps writing random bytes into all memory that the service reads from this process.
void scribble(std::uint64_t seed) {
  constexpr std::size_t kBytes = 64 * 1024;
  constexpr int kFromStage = 5;
  void* const place = ::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_SHARED, kFromStage, 0);
  if (place == MAP_FAILED) return;
  auto* const words = static_cast<volatile std::uint32_t*>(place);
  for (;;) {
    seed = seed * 6364136223846793005U + 1442695040888963407U;
    const std::size_t at = (seed >> 33U) % (kBytes / 4);
    // The service reads all of the first 16 words, so these are written most often.
    words[seed % 3 == 0 ? at % 16 : at] = static_cast<std::uint32_t>(seed >> (seed % 32));
  }
}

}  // namespace

void MakeTrouble::process(const Params& params, const FrameInfo& info, RobotList& out,
                          RegionList& regions) noexcept {
  Robot robot{};
  robot.id = 1;
  robot.confidence = 1;
  robot.x_mm = place_in(info.number);
  out.robots.assign(1, robot);
  switch (static_cast<Trouble>(params.trouble)) {
    case Trouble::kNone: break;
    case Trouble::kCrash: std::raise(SIGSEGV); break;
    case Trouble::kHang:
      for (;;) ::pause();
    case Trouble::kNan: out.robots[0].y_mm = std::nan(""); break;
    case Trouble::kOverlong: out.robots.assign(400'000, robot); break;
    case Trouble::kBadId: out.robots[0].id = 256; break;
    case Trouble::kScribble:
      if (random == 1) std::thread(scribble, random = 12345).detach();
      break;
    case Trouble::kSlow: {
      const timespec time{static_cast<time_t>(params.sleep_ms / 1000),
                          static_cast<long>(std::fmod(params.sleep_ms, 1000) * 1e6)};
      ::nanosleep(&time, nullptr);
      break;
    }
    case Trouble::kPrints:
      for (int i = 0; i < 100; ++i) std::printf("line %d of frame %u\n", i, info.number);
      break;
    case Trouble::kExit: std::_Exit(3);
    case Trouble::kBadRegions: regions.begin.fill(1'000'000); break;
    case Trouble::kBadNote: break;
  }
}

CannotStart::CannotStart() {
  throw std::runtime_error("there is no such device");
}

HangsAtStart::HangsAtStart() {
  for (;;) ::pause();
}

namespace {

bool is_set(const char* name) {
  return std::getenv(name) != nullptr;
}

/// Starts a process that leaves the process group and keeps the open files.
const int kLeft = [] {
  if (!is_set("SSLV_TEST_LEAVES_CHILD")) return 0;
  const pid_t child = ::fork();
  if (child == 0) {
    ::setsid();
    if (::fork() != 0) ::_exit(0);
    ::alarm(30);
    for (;;) ::pause();
  }
  return ::waitpid(child, nullptr, 0);
}();

StageRows make_rows() {
  StageRows rows;
  rows.camera = {
      stage<SeeAll>("see_all", "sees all that it is given"),
      stage<LookAround>("look_around", ""),
      is_set("SSLV_TEST_OTHER_PARTS") ? stage<CountTags>("find_tags", "") : stage<FindTags>("find_tags", ""),
      stage<DoubleTags>("double_tags", ""),
      stage<SpoilTags>("spoil_tags", ""),
      stage<CountTags>("count_tags", ""),
      stage<MakeTrouble>("make_trouble", ""),
      stage<CannotStart>("cannot_start", ""),
      stage<HangsAtStart>("hangs_at_start", ""),
      stage<Segment>("segment", ""),
      stage<Threshold>("threshold", ""),
      stage<FindRuns>("find_runs", ""),
      stage<DetectRobots>("detect_robots", ""),
      stage<DetectBalls>("detect_balls", "")};
  rows.field = {field_stage<FieldAll>("field_all", ""), field_stage<Gather>("gather", ""),
                field_stage<Track>("track", "")};
  if (is_set("SSLV_TEST_NAN_DEFAULT")) rows.camera.push_back(stage<NanDefault>("nan_default", ""));
  if (is_set("SSLV_TEST_PUBLISHES")) rows.camera.push_back(stage<Publishes>("publishes", ""));
  return rows;
}

}  // namespace
}  // namespace sslv::test

SSLV_STAGES(sslv::test::make_rows())
