// SPDX-License-Identifier: Apache-2.0
#pragma once

// The only header that a stage library includes. A stage library is a shared object with stages for the
// stacks of cameras and of the field; docs/extending.md shows one.
//
//   #include <kit/stages.h>
//
//   class CountBalls {
//    public:
//     struct Params { static constexpr auto fields() { return std::tuple{}; } };
//     void process(const Params&, const sslv::BallList& balls, sslv::StageNotes& notes) noexcept;
//   };
//
//   SSLV_STAGES(sslv::stage<CountBalls>("count_balls", "says how many balls there are"))

#include "kit/stamp.h"
#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"

#include <utility>
#include <vector>

namespace sslv {

/// All stages of one library.
struct StageRows {
  std::vector<StageType> camera;
  std::vector<FieldStageType> field;
};

inline void add_row(StageRows& rows, StageType row) {
  rows.camera.push_back(std::move(row));
}
inline void add_row(StageRows& rows, FieldStageType row) {
  rows.field.push_back(std::move(row));
}

inline void add_row(StageRows& rows, StageRows more) {
  for (StageType& row : more.camera) rows.camera.push_back(std::move(row));
  for (FieldStageType& row : more.field) rows.field.push_back(std::move(row));
}

/// Collects rows in any order: stage<S>(name, help) for a camera's stack, field_stage<S>(name, help) for the
/// field's stack, or StageRows if the library creates rows at run time.
template <class... Rows>
StageRows stage_rows(Rows... rows) {
  StageRows out;
  (add_row(out, std::move(rows)), ...);
  return out;
}

/// The type and name of the function that a library exports.
using StageRowsFunction = void (*)(StageRows& out);
inline constexpr const char* kStageRowsFunction = "sslv_stage_rows";

}  // namespace sslv

/// Use once in a library, with all of its stages.
#define SSLV_STAGES(...)                                                                      \
  extern "C" {                                                                                \
  [[gnu::section("sslv_stamp"), gnu::used,                                                    \
    gnu::visibility("default")]] extern constinit const ::sslv::StageStamp sslv_stage_stamp = \
      ::sslv::this_stamp();                                                                   \
  [[gnu::visibility("default")]] void sslv_stage_rows(::sslv::StageRows& out) {               \
    out = ::sslv::stage_rows(__VA_ARGS__);                                                    \
  }                                                                                           \
  }
