// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/color.h"
#include "vision/label.h"
#include "vision/lut.h"

#include <span>

namespace sslv {

/// A colour that a person selected in an image, preferably averaged over a few pixels. The label belongs to a
/// print or the ball, or to an object to be distinguished from them: field, white (a line), black (a robot's
/// top), clear (anything else to be left out).
struct ColorSample {
  Label label;
  Rgb color;
};

/// Labels of cells that look like field, white or black.
enum class BackgroundLabels {
  kClear,  // all clear: for detectors, which then have few runs
  kNamed,  // their own labels: for showing the table to a person
};

/// Makes a table from a few samples of each label: three are enough in even light, else six to nine from all
/// parts of the image, darkest and brightest included.
///
/// Works in RGB; distances are in 8-bit grey levels. As the light changes, a colour moves on a ray from
/// black; the same happens where a colour blends with the black around it. So each label is represented by a
/// line through its samples, sorted by brightness. The line extends from halfway to the robots' black up to
/// 1.6 x the brightest sample, and further if the field's samples show light levels that the label's samples
/// lack. Field and white, with their blends, are represented by such lines from 0.5 x the darkest to 1.45 x
/// the brightest sample, because light differs from frame to frame. A cell gets the label of the nearest
/// line; the unit of distance is a tolerance of 1.5 + 7 % of the line's brightness + noise. The noise is
/// twice the distance of the samples from their lines, but at least 4. Beyond four tolerances a cell is
/// clear. In doubt a cell is background. Samples that are averages of many pixels do not show the noise:
/// `noise_grey` is the noise of a pixel (sigma), if it is known.
///
/// Limits: objects without samples are left out only beyond four tolerances. In less than a tenth of normal
/// light, the tolerance is larger than the distances between the colours. A label without samples is not in
/// the table; without samples of field, white or black, cells with such colours may get the label of a print
/// or the ball. Takes 40 to 80 ms.
ColorTable table_from_samples(std::span<const ColorSample> samples,
                              BackgroundLabels background = BackgroundLabels::kClear, double noise_grey = 0);
/// The table of table_from_samples(), prepared for lookup.
Lut lut_from_samples(std::span<const ColorSample> samples,
                     BackgroundLabels background = BackgroundLabels::kClear, double noise_grey = 0);

}  // namespace sslv
