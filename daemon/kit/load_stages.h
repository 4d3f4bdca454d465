// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kit/stages.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace sslv {

/// A file that was left out, and why; one line.
struct LeftOutLibrary {
  std::filesystem::path file;
  std::string why;
};

struct StageLibrary {
  std::filesystem::path file;
  StageRows rows;  // each with the file's name
};

struct LoadedStages {
  std::vector<StageLibrary> libraries;
  std::vector<LeftOutLibrary> left_out;
};

/// What a stage in a process of its own has besides its parameters (kit/apart). One that runs inside keeps it
/// for the day on which it goes back, and does nothing with it.
inline constexpr const char* kDeadlineKey = "deadline_ms";

/// Whether a row says of its stage what the settings can rely on: names, texts, and parameters whose defaults
/// are allowed. Makes no stage. Throws StageLibraryError.
template <class Floor>
void check_row(const BasicStageType<Floor>& row);
extern template void check_row(const StageType& row);
extern template void check_row(const FieldStageType& row);

/// The stage libraries (*.so) of these folders, in the same order on every computer, each once. A folder that
/// is not there has none; one that cannot be read goes to `left_out`.
std::vector<std::filesystem::path> stage_libraries(const std::vector<std::filesystem::path>& folders,
                                                   std::vector<LeftOutLibrary>& left_out);

/// The stages of one library, which stays loaded: its code runs. Throws StageLibraryError, and whatever the
/// library throws.
StageRows load_rows(const std::filesystem::path& file);

/// Loads the stage libraries of these folders, for good. Before a library is loaded its stamp is read,
/// and a process of its own loads it and makes each of its stages once: what throws, crashes or hangs does so
/// there. That is done with all libraries at the same time, which have `within` together; twice that where
/// other programs have the processors. To be called before any thread starts.
LoadedStages load_stages(const std::vector<std::filesystem::path>& folders,
                         std::chrono::milliseconds within = std::chrono::seconds(8));

}  // namespace sslv
