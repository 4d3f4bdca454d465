// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "geometry/scene.h"

#include <cstdint>
#include <span>
#include <string>

namespace sslv {

/// Links of an image's page.
struct AnnotationPlace {
  std::string command;         // command that corrects the images, quoted for a shell
  std::string previous, next;  // file names of pages; empty: no such page
};

/// The file name of an image's page.
std::string annotation_page_name(const std::string& frame);

/// Returns a self-contained HTML page: the image with a numbered mark on everything in a line of a truth file
/// (see truth.h), and the options that correct the mark or place that a person clicks.
std::string annotation_page(const Json& line, std::span<const std::uint8_t> jpeg, const Scene& scene,
                            const AnnotationPlace& place);

}  // namespace sslv
