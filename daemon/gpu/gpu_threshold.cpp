// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_threshold.h"

#include "gpu/gl.h"
#include "gpu/threshold_pass.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include <EGL/egl.h>

namespace sslv {
namespace {

using Clock = std::chrono::steady_clock;

bool is_rgb(PixelFormat format) {
  return is_bayer(format) || format == PixelFormat::kRgb24 || format == PixelFormat::kBgr24;
}

/// Bytes of a row that the labels cover, without the padding at the end of the row, which the camera driver
/// may omit after the last row.
std::size_t used_row_bytes(const ImageView& view, const LabelImage& labels) {
  return static_cast<std::size_t>(labels.width * labels.cell_px * bytes_per_pixel(view.format));
}

void copy_rows(const ImageView& view, std::size_t row_bytes, const GroupedImage& grouped, std::uint8_t* out,
               const RowsThere* there) {
  const std::size_t out_row = grouped.image_row_bytes();
  const int rows = grouped.image_rows();
  // This thread reads a band while another thread writes the next bands.
  constexpr std::size_t kBandBytes = 128 << 10;
  const int band = there == nullptr ? rows : static_cast<int>(std::max<std::size_t>(1, kBandBytes / out_row));
  for (int begin = 0; begin < rows; begin += band) {
    const int end = std::min(rows, begin + band);
    if (there != nullptr) there->wait_for(end);
    if (view.stride_bytes == static_cast<std::ptrdiff_t>(out_row)) {
      const auto whole = static_cast<std::size_t>(end - begin - 1);
      std::memcpy(out, view.row(begin), whole * out_row + row_bytes);
      out += (whole + 1) * out_row;
    } else {
      for (int y = begin; y < end; ++y, out += out_row) std::memcpy(out, view.row(y), row_bytes);
    }
  }
}

/// Copies the labels inside the mask; without a mask, all labels.
void copy_labels(const Mask* mask, const std::uint8_t* in, std::size_t in_row, LabelImage& labels) {
  for (int y = 0; y < labels.height; ++y, in += in_row) {
    Label* row = labels.row(y);
    if (mask == nullptr) {
      std::copy(in, in + labels.width, row);
      continue;
    }
    int clear_from = 0;
    for (const Mask::Interval interval : mask->row(y, labels.cell_px)) {
      const int begin = std::min<int>(interval.begin, labels.width);
      const int end = std::min<int>(interval.end, labels.width);
      std::fill(row + clear_from, row + begin, label::kClear);
      std::copy(in + begin, in + end, row + begin);
      clear_from = end;
    }
    std::fill(row + clear_from, row + labels.width, label::kClear);
  }
}

}  // namespace

TableView table_for(const Lut& lut, PixelFormat format) {
  const LutTable& table = is_rgb(format) ? lut.rgb() : lut.yuv();
  return {lut.id(), is_rgb(format), table.bits, table.labels};
}

/// Measures shader time with the GPU's own clock.
struct GpuThreshold::Timer {
  GlName query{[](GLuint name) { glDeleteQueries(1, &name); }};
  PFNGLGETQUERYOBJECTUI64VEXTPROC result = nullptr;

  Timer() {
    result = reinterpret_cast<PFNGLGETQUERYOBJECTUI64VEXTPROC>(eglGetProcAddress("glGetQueryObjectui64vEXT"));
    GLuint name = 0;
    glGenQueries(1, &name);
    query = GlName(name, [](GLuint old) { glDeleteQueries(1, &old); });
    clear_disjoint();
  }
  /// Whether the clock jumped since the last call.
  static bool clear_disjoint() {
    GLint jumped = 0;
    glGetIntegerv(GL_GPU_DISJOINT_EXT, &jumped);
    return jumped != 0;
  }
  void begin() const { glBeginQuery(GL_TIME_ELAPSED_EXT, query.get()); }
  static void end() { glEndQuery(GL_TIME_ELAPSED_EXT); }
  /// Call after glFinish(). Returns `otherwise` if the clock has no valid result.
  std::chrono::nanoseconds elapsed(std::chrono::nanoseconds otherwise) const {
    GLuint64 ns = 0;
    if (result != nullptr) result(query.get(), GL_QUERY_RESULT, &ns);
    const bool jumped = clear_disjoint();
    return jumped || ns == 0 ? otherwise : std::chrono::nanoseconds(ns);
  }
};

GpuThreshold::GpuThreshold(GpuContext& context) : context_(context) {
  const GpuContext::Use use(context_);
  if (!use) throw GpuError("the context is lost or in use: " + context.renderer());
  start_again();
  // Mesa's software renderer counts only its rasteriser's time.
  if (context.has_timer() && !context.is_software()) timer_ = std::make_unique<Timer>();
}

GpuThreshold::~GpuThreshold() {
  // A current context lets GL free its objects; a lost context has destroyed them.
  const GpuContext::Use use(context_);
  pass_.reset();
  timer_.reset();
}

void GpuThreshold::start_again() {
  loaded_.reset();
  pass_ = std::make_unique<ThresholdPass>();
}

bool GpuThreshold::fail(std::string problem) {
  problem_ = std::move(problem);
  return false;
}

bool GpuThreshold::set_lut(const Lut& lut, PixelFormat format) noexcept {
  const GpuContext::Use use(context_);
  if (!use) return fail(context_.is_lost() ? "the context is lost" : "another thread uses the context");
  return load(table_for(lut, format), format);
}

bool GpuThreshold::load(const TableView& table, PixelFormat format) {
  std::string problem;
  if (!pass_->prepare(format, table.bits, problem)) return fail(std::move(problem));
  const std::pair wanted{table.lut_id, table.is_rgb};
  if (loaded_ == wanted) return true;
  pass_->load(table.labels);
  problem = context_.take_problem();
  if (problem.empty()) {
    loaded_ = wanted;
    return true;
  }
  start_again();
  return fail(std::move(problem));
}

bool GpuThreshold::process(const TableView& table, const Mask* mask, const ImageView& view,
                           LabelImage& labels, Steps* steps, const RowsThere* rows) noexcept {
  labels.cell_px = is_bayer(view.format) ? 2 : 1;
  labels.width = view.width / labels.cell_px;
  labels.height = view.height / labels.cell_px;
  labels.labels.resize(static_cast<std::size_t>(labels.width) * static_cast<std::size_t>(labels.height));
  const GpuContext::Use use(context_);
  if (!use) return fail(context_.is_lost() ? "the context is lost" : "another thread uses the context");
  if (steps != nullptr) *steps = {};
  if (labels.labels.empty()) return true;
  const GroupedImage grouped{view.format, (labels.width + kCellsAGroup - 1) / kCellsAGroup, labels.height};
  if (!pass_->takes(grouped)) return fail("the image is too large for this GPU");
  if (!load(table, view.format)) return false;
  const bool is_made = make_labels(grouped, mask, view, labels, steps, rows);
  std::string problem = context_.take_problem();
  if (is_made && problem.empty()) return true;
  // GL may have skipped work (out of memory). The next image must not rely on that work.
  start_again();
  return problem.empty() ? false : fail(std::move(problem));
}

bool GpuThreshold::make_labels(const GroupedImage& grouped, const Mask* mask, const ImageView& view,
                               LabelImage& labels, Steps* steps, const RowsThere* rows) {
  auto before = Clock::now();
  const auto step = [&](std::chrono::nanoseconds Steps::*member) {
    if (steps == nullptr) return;
    glFinish();
    const auto now = Clock::now();
    steps->*member = now - before;
    before = now;
  };
  std::uint8_t* memory = pass_->image_memory(grouped);
  if (memory == nullptr) return fail("the GPU provided no memory for the image");
  copy_rows(view, used_row_bytes(view, labels), grouped, memory, rows);
  if (!pass_->upload(grouped)) return fail("the upload of the image failed");
  step(&Steps::upload);
  if (steps != nullptr && timer_) timer_->begin();
  pass_->run(grouped);
  if (steps != nullptr && timer_) timer_->end();
  step(&Steps::shader);
  const std::uint8_t* found = pass_->labels(grouped);
  if (found == nullptr) return fail("the GPU provided no labels");
  copy_labels(mask, found, grouped.label_row_bytes(), labels);
  if (!pass_->release_labels()) return fail("the read-back of the labels failed");
  step(&Steps::read_back);
  if (steps != nullptr && timer_) steps->shader = timer_->elapsed(steps->shader);
  return true;
}

}  // namespace sslv
