// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "lab/process.h"
#include "lab/truth.h"

#include <iosfwd>
#include <string>

namespace sslv {

struct AnnotateOptions {
  ProcessOptions pictures;
  std::string truth_file;    // written, or continued if it exists
  std::string pages_folder;  // gets a page for each image
  std::string command;       // for the pages: the command line without corrections
  std::string frame;         // the only image to correct or to draft again; empty: all
  Corrections corrections;
  bool again = false;  // draft existing lines again
};

/// Drafts the truth of images that the file does not have yet, corrects it, and writes file and pages.
/// Reports on `out`; images that cannot be read are listed on `problems`. Throws SettingsError, CaptureError
/// and StorageError; the truth file is then unchanged.
void annotate(const Config& config, std::size_t camera_index, const AnnotateOptions& options,
              std::ostream& out, std::ostream& problems);

}  // namespace sslv
