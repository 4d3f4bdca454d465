// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "ctl/process.h"
#include "ctl/truth.h"

#include <iosfwd>
#include <string>

namespace sslv {

struct AnnotateOptions {
  ProcessOptions pictures;
  std::string truth_file;    // written, or gone on with
  std::string pages_folder;  // gets a page for each image
  std::string command;       // for the pages: what was called, without corrections
  std::string frame;         // only this image is corrected or drafted again; empty: all
  Corrections corrections;
  bool again = false;  // draft what is there already once more
};

/// Drafts the truth of images that the file does not have yet, corrects it, and writes file and pages. What
/// was done goes to `out`, images that cannot be read to `problems`. Throws SettingsError, CaptureError and
/// StorageError; the truth file is then as it was.
void annotate(const Config& config, std::size_t camera_index, const AnnotateOptions& options,
              std::ostream& out, std::ostream& problems);

}  // namespace sslv
