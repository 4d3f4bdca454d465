// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "geometry/scene.h"

#include <cstdint>
#include <span>
#include <string>

namespace sslv {

/// Where an image's page stands among the others.
struct AnnotationPlace {
  std::string command;         // that corrects the images, ready for a shell
  std::string previous, next;  // pages' file names; empty: there is none
};

/// The file name of an image's page.
std::string annotation_page_name(const std::string& frame);

/// An HTML page that needs nothing else: the image with a numbered mark on everything that a line of a
/// truth file (see truth.h) has, and the words for a correction that is pointed at.
std::string annotation_page(const Json& line, std::span<const std::uint8_t> jpeg, const Scene& scene,
                            const AnnotationPlace& place);

}  // namespace sslv
