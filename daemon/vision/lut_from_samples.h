// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/color.h"
#include "vision/label.h"
#include "vision/lut.h"

#include <span>

namespace sslv {

/// A colour that somebody pointed at in an image, best averaged over a few pixels. The label says what was
/// there: a print's or the ball's colour, or what is to be told apart from them: field, white (a line), black
/// (a robot's top), clear (anything else to be left out).
struct ColorSample {
  Label label;
  Rgb color;
};

/// What cells get that look like field, white or black.
enum class BackgroundLabels {
  kClear,  // none: what detectors want, and runs are few
  kNamed,  // theirs: for people who look at the table
};

/// Makes a table from a few samples of each label: three will do where light is even, else six to nine from
/// all parts of the image, darkest and brightest included.
///
/// Works in RGB; distances are in 8-bit grey levels. Under more or less light a colour moves on a ray from
/// black, and so it does where it blends with the black around it. So each label is a line through its
/// samples, sorted by brightness, from halfway to the robots' black up to 1.6 x the brightest, and further
/// where the field's samples tell of light that the label's have not seen. Field and white, with their
/// blends, are such lines from 0.5 x the darkest to 1.45 x the brightest: light differs from frame to frame.
/// A cell gets the label of the line that is nearest, in units of a tolerance: 1.5 + 7 % of the line's
/// brightness + noise, which is twice what samples are seen to lie off their lines, and 4 at least. Beyond
/// four tolerances it is clear. In doubt it is background. Samples that are averages of many pixels do not
/// show the noise: `noise_grey` is that of a pixel (sigma), when it is known.
///
/// Limits: what nobody pointed at is left out only beyond those four. In light below a tenth the tolerance is
/// larger than what separates the colours. A label without samples is not in the table; without samples of
/// field, white or black, what looks like these may get a colour's label. Takes 40 to 80 ms.
ColorTable table_from_samples(std::span<const ColorSample> samples,
                              BackgroundLabels background = BackgroundLabels::kClear, double noise_grey = 0);
/// The same, made ready.
Lut lut_from_samples(std::span<const ColorSample> samples,
                     BackgroundLabels background = BackgroundLabels::kClear, double noise_grey = 0);

}  // namespace sslv
