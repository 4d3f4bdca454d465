// SPDX-License-Identifier: Apache-2.0
// expect-error: use of deleted function|call to deleted constructor
#include "image/image.h"

sslv::Image copy(const sslv::Image& image) {
  return image;
}
