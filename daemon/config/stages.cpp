// SPDX-License-Identifier: Apache-2.0
// TABLES stage name -> type. To add a stage: a class in vision/ (for a field stage: in tracking/), a row here
// (docs/extending.md).
#include "config/stages.h"

#include "base/log.h"
#include "base/plain_text.h"
#include "image/shared_memory.h"
#include "kit/read_stamp.h"
#include "kit/sandbox/sandbox.h"
#include "pipeline/publish.h"
#include "tracking/agreement.h"
#include "tracking/clocks.h"
#include "tracking/gather.h"
#include "tracking/track.h"
#include "vision/detect_balls.h"
#include "vision/detect_robots.h"
#include "vision/find_regions.h"
#include "vision/find_runs.h"
#include "vision/segment.h"
#include "vision/threshold.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Time limits for stage libraries at the service's start, on a computer that is not busy; systemd allows
/// 30 s for the whole start. kMaxLoading: testing the libraries that run in this program. kMaxStarting: all
/// libraries together, including the first starts of stages in separate processes. kMinDescribing: time for
/// describing the libraries of separate processes, even if less is left.
constexpr std::chrono::milliseconds kMaxLoading{8000}, kMaxStarting{10'000}, kMinDescribing{2000};

struct Outside {
  StageRows rows;
  std::vector<OwnPartType> parts;  // by place; each part has one place, shared by both tables
  std::map<std::size_t*, std::string> places;
  std::vector<LeftOutLibrary> left_out;
  MissingStages missing = MissingStages::kRefused;
  std::atomic<bool> is_used{false};                 // no more stages can be added
  std::unique_ptr<sandbox::Supervisor> supervisor;  // null: no stage runs in a separate process
};
Outside& outside() {
  static Outside outside;
  return outside;
}

template <class Floor>
void check_names(const std::vector<BasicStageType<Floor>>& rows,
                 std::span<const BasicStageType<Floor>> table) {
  for (auto row = rows.begin(); row != rows.end(); ++row) {
    const auto has_its_name = [&](const auto& other) { return other.name == row->name; };
    if (std::any_of(rows.begin(), row, has_its_name) || std::ranges::any_of(table, has_its_name))
      throw StageLibraryError(
          fmt::format("has a stage '{}', but another stage already has this name", row->name));
  }
}

/// Limit for the number of frame parts that libraries may add: each needs a bit in the PartSet of both stage
/// tables.
constexpr std::size_t kMaxOwnParts =
    PartSet().size() - std::max(kPartCount<CameraFloor>, kPartCount<FieldFloor>);

/// All frame parts of libraries, including those of a new library. Throws StageLibraryError if the new
/// library does not fit the earlier ones.
struct NewParts {
  std::vector<OwnPartType> parts;
  std::map<std::size_t*, std::string> places;

  template <class Floor>
  void add(const std::vector<BasicStageType<Floor>>& rows) {
    for (const auto& row : rows) {
      for (const OwnPartUse& use : row.own_parts) {
        const auto known = std::ranges::find(parts, use.type.name, &OwnPartType::name);
        if (known == parts.end()) {
          parts.push_back(use.type);
        } else if (known->layout != use.type.layout) {
          throw StageLibraryError(fmt::format(
              "defines the part '{}' with a different layout than an earlier library", use.type.name));
        }
        const auto [place, is_new] = places.emplace(use.place, use.type.name);
        if (!is_new && place->second != use.type.name) {
          throw StageLibraryError(
              fmt::format("stores its part '{}' and the part '{}' in the same place: build it with hidden "
                          "visibility (-fvisibility=hidden)",
                          use.type.name, place->second));
        }
      }
    }
    if (parts.size() > kMaxOwnParts) {
      throw StageLibraryError(
          fmt::format("brings the total of libraries' own parts to {}; at most {} are allowed", parts.size(),
                      kMaxOwnParts));
    }
  }
};

/// Assigns places to the frame parts of these stages, and adds the stages to the table.
template <class Floor>
void take(std::vector<BasicStageType<Floor>> rows, std::vector<BasicStageType<Floor>>& table,
          const std::vector<OwnPartType>& parts) {
  for (auto& row : rows) {
    for (const OwnPartUse& use : row.own_parts) {
      const auto known = std::ranges::find(parts, use.type.name, &OwnPartType::name);
      *use.place = static_cast<std::size_t>(known - parts.begin());
      (use.is_written ? row.writes : row.reads).set(kPartCount<Floor> + *use.place);
    }
    table.push_back(std::move(row));
  }
}

const std::vector<StageType>& own_stages() {
  static const std::vector kStages{
      stage<Segment>("segment",
                     "finds the regions of labelled pixels: threshold, find_runs and find_regions in one"),
      stage<Threshold>("threshold", "labels every pixel by the colour lookup table"),
      stage<FindRuns>("find_runs", "run-length encodes the labelled image"),
      stage<FindRegions>("find_regions", "joins runs into regions"),
      stage<DetectRobots>("detect_robots", "finds robots by the pattern table"),
      stage<DetectBalls>("detect_balls", "finds balls"),
      stage<Publish>("publish", "sends the detections"),
  };
  return kStages;
}

const std::vector<FieldStageType>& own_field_stages() {
  static const std::vector kStages{
      field_stage<Gather>("gather", "accepts valid camera results"),
      field_stage<Clocks>("clocks", "corrects capture times"),
      field_stage<Agreement>("agreement", "learns and removes offsets between cameras"),
      field_stage<Track>("track", "tracks robots and balls and estimates their current state"),
      field_stage<PublishField>("publish", "sends the tracks, and shows them in the panel"),
  };
  return kStages;
}

template <class Row>
std::vector<Row> joined(std::vector<Row> own, const std::vector<Row>& from_outside) {
  own.insert(own.end(), from_outside.begin(), from_outside.end());
  return own;
}

}  // namespace

void add_stages(StageRows rows) {
  Outside& all = outside();
  if (all.is_used) throw std::logic_error("stages are added too late");
  check_names<CameraFloor>(rows.camera, joined(own_stages(), all.rows.camera));
  check_names<FieldFloor>(rows.field, joined(own_field_stages(), all.rows.field));
  NewParts parts{all.parts, all.places};
  parts.add(rows.camera);
  parts.add(rows.field);
  all.parts = std::move(parts.parts);
  all.places = std::move(parts.places);
  take(std::move(rows.camera), all.rows.camera, all.parts);
  take(std::move(rows.field), all.rows.field, all.parts);
}

void add_stage_libraries(const StageFolders& folders, MissingStages missing) {
  if (folders.inside.empty() && folders.sandboxed.empty()) return;
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + kMaxStarting;
  const auto left = [end] {
    const auto time = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    return std::max(time, std::chrono::milliseconds(0));
  };
  Outside& all = outside();
  all.missing = missing;
  LoadedStages loaded = load_stages(folders.inside, kMaxLoading);
  all.left_out = std::move(loaded.left_out);
  const auto add = [&all](const std::filesystem::path& file, const auto& make_rows) {
    try {
      add_stages(make_rows());
      log::info("stages of {} loaded", escaped_text(file.string()));
    } catch (const std::exception& error) {
      all.left_out.push_back({file, error.what()});
    }
  };
  for (StageLibrary& library : loaded.libraries)
    add(library.file, [&library] { return std::move(library.rows); });
  // load_stages() forks, so it ran before any thread started; threads start below.
  const std::vector<std::filesystem::path> files = stage_libraries(folders.sandboxed, all.left_out);
  if (!files.empty()) all.supervisor = std::make_unique<sandbox::Supervisor>();
  std::vector<std::future<StageRows>> described;
  for (const std::filesystem::path& file : files) {
    described.push_back(
        std::async(std::launch::async, [&all, &file, within = std::max(left(), kMinDescribing)] {
          check_stamp(read_stamp(file));
          return sandboxed_rows(file, *all.supervisor, within);
        }));
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    add(files[i], [&] {
      StageRows rows = described[i].get();
      share_new_images(true);
      return rows;
    });
  }
  if (all.supervisor) all.supervisor->wait_at_most(left());
  for (const LeftOutLibrary& one : all.left_out)
    log::error("{} {}; it is left out", escaped_text(one.file.string()), one.why);
}

void ask_stages_to_stop() {
  if (outside().supervisor) outside().supervisor->ask_to_stop();
}

EndOfStageProcesses::~EndOfStageProcesses() {
  outside().supervisor.reset();
}

void leave_out_missing_stages() {
  outside().missing = MissingStages::kLeftOut;
}

std::span<const LeftOutLibrary> left_out_libraries() {
  return outside().left_out;
}

MissingStages missing_stages() {
  return outside().missing;
}

std::span<const StageType> stage_table() {
  static const std::vector<StageType> kAll = joined(own_stages(), outside().rows.camera);
  outside().is_used = true;
  return kAll;
}

std::vector<std::string> default_stack() {
  return {"segment", "detect_robots", "detect_balls", "publish"};
}

std::span<const FieldStageType> field_stage_table() {
  static const std::vector<FieldStageType> kAll = joined(own_field_stages(), outside().rows.field);
  outside().is_used = true;
  return kAll;
}

std::vector<std::string> default_field_stack() {
  return {"gather", "clocks", "agreement", "track", "publish"};
}

}  // namespace sslv
