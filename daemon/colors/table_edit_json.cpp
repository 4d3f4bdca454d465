// SPDX-License-Identifier: Apache-2.0
#include "base/params_json.h"
#include "colors/table_edit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

namespace sslv {
namespace {

constexpr int kMaxEditCells = 16;
constexpr std::size_t kMaxPixels = 100'000;

/// The keys of one edit. finish() refuses all keys that were not requested.
class Keys {
 public:
  Keys(const Json& json, const std::string& path, const LabelSet& labels)
      : json_(json), path_(path), labels_(labels) {
    if (!json.is_object()) refuse(path, json, "an object");
  }

  const Json* find(std::string_view key) {
    known_.push_back(std::string(key));
    const auto found = json_.find(key);
    return found == json_.end() ? nullptr : &*found;
  }
  const Json& get(std::string_view key) {
    const Json* found = find(key);
    if (found == nullptr) throw SettingsError(fmt::format("{}: is missing", at(key)));
    return *found;
  }
  std::string at(std::string_view key) const { return fmt::format("{}/{}", path_, key); }

  Label label(std::string_view key) { return label_of(get(key), key); }
  std::optional<Label> label_if_any(std::string_view key) {
    const Json* found = find(key);
    if (found == nullptr || found->is_null()) return std::nullopt;
    return label_of(*found, key);
  }
  Levels levels(std::string_view key) {
    const Json& json = get(key);
    if (!json.is_array() || json.size() != 3) refuse(at(key), json, "[y, u, v], each 0 .. 255");
    Levels out;
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = read_number<int>(json[i], fmt::format("{}/{}", at(key), i), 0, 255, "");
    return out;
  }
  int cells() {
    const Json* found = find("cells");
    return found == nullptr ? 1 : read_number<int>(*found, at("cells"), 1, kMaxEditCells, "cells");
  }
  bool flag(std::string_view key) {
    const Json* found = find(key);
    if (found != nullptr && !found->is_boolean()) refuse(at(key), *found, "true or false");
    return found != nullptr && found->get<bool>();
  }
  Shape shape() { return one_of("shape", Shape::kBall, {{"ball", Shape::kBall}, {"box", Shape::kBox}}); }
  Over over(Over otherwise) {
    return one_of("over", otherwise, {{"any", Over::kAny}, {"clear", Over::kClear}});
  }
  ColorCluster cluster();

  void finish() {
    for (const auto& item : json_.items()) {
      if (std::find(known_.begin(), known_.end(), item.key()) != known_.end()) continue;
      std::string names;
      for (const std::string& name : known_) names += (names.empty() ? "" : ", ") + name;
      throw SettingsError(fmt::format("{}: no such parameter; known: {}", at(shortened(item.key())), names));
    }
  }

 private:
  Label label_of(const Json& json, std::string_view key) const {
    const auto label = json.is_string() ? labels_.find(json.get<std::string>()) : std::nullopt;
    if (!label) refuse(at(key), json, "one of " + labels_.names());
    return *label;
  }
  template <class E>
  E one_of(std::string_view key, E otherwise, std::initializer_list<std::pair<const char*, E>> choices) {
    const Json* found = find(key);
    if (found == nullptr) return otherwise;
    std::string allowed = "one of";
    for (const auto& [name, value] : choices) {
      if (found->is_string() && found->get_ref<const std::string&>() == name) return value;
      allowed += fmt::format(" \"{}\"", name);
    }
    refuse(at(key), *found, allowed);
  }

  const Json& json_;
  const std::string& path_;
  const LabelSet& labels_;
  std::vector<std::string> known_;
};

/// {"pixels": [[y, u, v], ...]}, or {"mean": [y, u, v], "covariance": 3x3}.
ColorCluster Keys::cluster() {
  ColorCluster out;
  const Json* pixels = find("pixels");
  const Json* mean = find("mean");
  const Json* covariance = find("covariance");
  if ((pixels != nullptr) == (mean != nullptr && covariance != nullptr) ||
      (pixels != nullptr && (mean != nullptr || covariance != nullptr))) {
    throw SettingsError(path_ + ": expected pixels, or mean and covariance");
  }
  if (pixels != nullptr) {
    if (!pixels->is_array() || pixels->empty() || pixels->size() > kMaxPixels)
      refuse(at("pixels"), *pixels, fmt::format("1 .. {} colours [y, u, v]", kMaxPixels));
    for (std::size_t i = 0; i < pixels->size(); ++i) {
      const Json& pixel = (*pixels)[i];
      const std::string here = fmt::format("{}/{}", at("pixels"), i);
      if (!pixel.is_array() || pixel.size() != 3) refuse(here, pixel, "[y, u, v], each 0 .. 255");
      const auto level = [&](std::size_t k) {
        return static_cast<std::uint8_t>(
            read_number<int>(pixel[k], fmt::format("{}/{}", here, k), 0, 255, ""));
      };
      out.pixels.push_back({level(0), level(1), level(2)});
    }
    return out;
  }
  constexpr double kMaxVariance = 128 * 128;
  ColorCluster::Spread spread{};
  Eigen::Matrix3d matrix;
  if (!mean->is_array() || mean->size() != 3) refuse(at("mean"), *mean, "[y, u, v], each 0 .. 255");
  if (!covariance->is_array() || covariance->size() != 3)
    refuse(at("covariance"), *covariance, "3 x 3 numbers");
  for (std::size_t i = 0; i < 3; ++i) {
    spread.mean[i] = read_number<double>((*mean)[i], fmt::format("{}/{}", at("mean"), i), 0.0, 255.0, "");
    const std::string here = fmt::format("{}/{}", at("covariance"), i);
    const Json& row = (*covariance)[i];
    if (!row.is_array() || row.size() != 3) refuse(here, row, "3 numbers");
    for (std::size_t j = 0; j < 3; ++j) {
      spread.covariance[i][j] =
          read_number<double>(row[j], fmt::format("{}/{}", here, j), -kMaxVariance, kMaxVariance, "");
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = spread.covariance[i][j];
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix, Eigen::EigenvaluesOnly);
  if ((matrix - matrix.transpose()).cwiseAbs().maxCoeff() > 1e-6 * kMaxVariance ||
      solver.eigenvalues().minCoeff() < -1e-6 * kMaxVariance) {
    refuse(at("covariance"), *covariance, "a covariance: symmetric and positive semidefinite");
  }
  out.spread = spread;
  return out;
}

struct Op {
  std::string_view name;
  TableEdit (*read)(Keys&);
};

// Braces guarantee that members are read in this order.
constexpr Op kOps[] = {
    {"paint",
     [](Keys& keys) -> TableEdit {
       return PaintEdit{keys.label("label"), keys.levels("at"), keys.levels("radius"), keys.shape(),
                        keys.over(Over::kAny)};
     }},
    {"erase",
     [](Keys& keys) -> TableEdit {
       return EraseEdit{keys.levels("at"), keys.levels("radius"), keys.shape(), keys.label_if_any("label")};
     }},
    {"fill",
     [](Keys& keys) -> TableEdit {
       return FillEdit{keys.label("label"), keys.levels("at"), keys.flag("all_lumas")};
     }},
    {"grow",
     [](Keys& keys) -> TableEdit {
       return GrowEdit{keys.label("label"), keys.cells(), keys.over(Over::kClear)};
     }},
    {"shrink",
     [](Keys& keys) -> TableEdit {
       return ShrinkEdit{keys.label("label"), keys.cells()};
     }},
    {"smooth", [](Keys& keys) -> TableEdit { return SmoothEdit{keys.label("label")}; }},
    {"replace",
     [](Keys& keys) -> TableEdit {
       return ReplaceEdit{keys.label("from"), keys.label("to")};
     }},
    {"remove", [](Keys& keys) -> TableEdit { return RemoveEdit{keys.label("label")}; }},
    {"add_cluster",
     [](Keys& keys) -> TableEdit {
       return AddClusterEdit{keys.label("label"), keys.cluster(), keys.over(Over::kAny)};
     }},
    {"remove_cluster",
     [](Keys& keys) -> TableEdit {
       return RemoveClusterEdit{keys.label_if_any("label"), keys.cluster()};
     }},
};

}  // namespace

TableEdit read_table_edit(const Json& json, const std::string& path, const LabelSet& labels) {
  Keys keys(json, path, labels);
  const Json& name = keys.get("op");
  std::string allowed = "one of";
  for (const Op& op : kOps) {
    if (name.is_string() && name.get_ref<const std::string&>() == op.name) {
      TableEdit edit = op.read(keys);
      keys.finish();
      return edit;
    }
    allowed += fmt::format(" \"{}\"", op.name);
  }
  refuse(keys.at("op"), name, allowed);
}

}  // namespace sslv
