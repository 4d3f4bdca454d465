// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kit/stages.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace sslv {

/// A file or folder that was skipped, with the reason in one line.
struct LeftOutLibrary {
  std::filesystem::path file;
  std::string why;
};

struct StageLibrary {
  std::filesystem::path file;
  StageRows rows;  // `library` of each row is the file's name
};

struct LoadedStages {
  std::vector<StageLibrary> libraries;
  std::vector<LeftOutLibrary> left_out;
};

/// Additional parameter of stages that run in their own processes (kit/sandbox). For stages inside the
/// service, this parameter is accepted and kept in the settings, but ignored.
inline constexpr const char* kDeadlineKey = "deadline_ms";

/// Validates a row: names, texts, and parameters whose defaults are allowed. Creates no stage. Throws
/// StageLibraryError.
template <class Floor>
void check_row(const BasicStageType<Floor>& row);
extern template void check_row(const StageType& row);
extern template void check_row(const FieldStageType& row);

/// The stage libraries (*.so) of these folders, each once, in the same order on every computer. A missing
/// folder counts as empty; an unreadable folder is added to `left_out`.
std::vector<std::filesystem::path> stage_libraries(const std::vector<std::filesystem::path>& folders,
                                                   std::vector<LeftOutLibrary>& left_out);

/// Loads a library and returns its stages. The library stays loaded, and its code runs. Throws
/// StageLibraryError, and any exception of the library.
StageRows load_rows(const std::filesystem::path& file);

/// Loads the stage libraries of these folders; they stay loaded. Tests each library first: reads its stamp,
/// and a child process loads the library and creates each of its stages once, so that exceptions, crashes and
/// hangs happen in the child process. The libraries are tested in parallel within `within`, or twice `within`
/// if other programs keep the processors busy. Call this before any thread starts.
LoadedStages load_stages(const std::vector<std::filesystem::path>& folders,
                         std::chrono::milliseconds within = std::chrono::seconds(8));

}  // namespace sslv
