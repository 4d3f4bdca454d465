// SPDX-License-Identifier: Apache-2.0
#pragma once

// The stamp of a stage library: versions and type layouts that must match the service's, because the two
// exchange objects in memory. It is stored in its own ELF section, so that it can be read without running the
// library's code.

#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"
#include "pipeline/layout.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sslv {

/// Increase this whenever something a stage may use changes its meaning but not its layout: the unit of a
/// member, two swapped members, a class with private members, the behaviour of a function.
/// tests/kit/stamp_test.cpp fails when a header has changed.
inline constexpr std::uint32_t kKitVersion = 2;

/// Name of the ELF section. kit/stages.h defines the exported symbols.
inline constexpr std::string_view kStampSection = "sslv_stamp";

/// A type whose objects are exchanged between service and library.
struct StampedType {
  std::array<char, 24> name{};  // padded with zeros
  std::uint32_t size = 0, alignment = 0;
  std::uint64_t layout = 0;
  bool operator==(const StampedType&) const = default;
};

/// Trivially copyable, so that it can be read from a file.
struct StageStamp {
  std::array<char, 16> magic{};
  std::uint32_t kit_version = 0, type_count = 0;
  std::array<char, 64> compiler{};  // processor, C++ library ABI, versions of the libraries used
  std::array<StampedType, 40> types{};
};

template <std::size_t kSize>
constexpr std::array<char, kSize> stamp_text(std::string_view text) {
  std::array<char, kSize> out{};
  std::copy_n(text.begin(), std::min(text.size(), kSize - 1), out.begin());
  return out;
}

#define SSLV_TEXT_OF(x) #x
#define SSLV_TEXT(x) SSLV_TEXT_OF(x)
#if defined __x86_64__
#define SSLV_PROCESSOR "x86-64"
#elif defined __aarch64__
#define SSLV_PROCESSOR "aarch64"
#else
#define SSLV_PROCESSOR "another processor"
#endif
#ifdef _GLIBCXX_USE_CXX11_ABI
#define SSLV_CXX_LIBRARY "libstdc++ abi " SSLV_TEXT(_GLIBCXX_USE_CXX11_ABI)
#else
#define SSLV_CXX_LIBRARY "another C++ library"
#endif

inline constexpr std::string_view kStampMagic = "ssl-visiond kit";
inline constexpr std::string_view kStampCompiler = SSLV_PROCESSOR
    ", " SSLV_CXX_LIBRARY
    ", Eigen " SSLV_TEXT(EIGEN_WORLD_VERSION) "." SSLV_TEXT(EIGEN_MAJOR_VERSION) ", json " SSLV_TEXT(
        NLOHMANN_JSON_VERSION_MAJOR) "." SSLV_TEXT(NLOHMANN_JSON_VERSION_MINOR);

/// The stamp of the program or library that this is compiled into. A template, so that it is compiled only
/// where it is used.
template <class = void>
constexpr StageStamp this_stamp() {
  StageStamp stamp;
  stamp.magic = stamp_text<16>(kStampMagic);
  stamp.kit_version = kKitVersion;
  stamp.compiler = stamp_text<64>(kStampCompiler);
  const auto add = [&stamp]<class T>(std::string_view name, std::type_identity<T>) {
    stamp.types[stamp.type_count++] = {stamp_text<24>(name), sizeof(T), alignof(T), layout_of<T>()};
  };
#define SSLV_ADD(Type) add(#Type, std::type_identity<Type>{})
  SSLV_ADD(FrameInfo);
  SSLV_ADD(Image);
  SSLV_ADD(LabelImage);
  SSLV_ADD(RunList);
  SSLV_ADD(RegionList);
  SSLV_ADD(RobotList);
  SSLV_ADD(BallList);
  SSLV_ADD(Frame);
  SSLV_ADD(Scene);
  SSLV_ADD(Lut);
  SSLV_ADD(Mask);
  SSLV_ADD(PatternTable);
  SSLV_ADD(CameraContext);
  SSLV_ADD(ArrivedSightings);
  SSLV_ADD(LeftOut);
  SSLV_ADD(ImageTime);
  SSLV_ADD(Observations);
  SSLV_ADD(CameraAgreement);
  SSLV_ADD(TrackedField);
  SSLV_ADD(FieldFrame);
  SSLV_ADD(FieldSize);
  SSLV_ADD(BallModel);
  SSLV_ADD(FieldClock);
  SSLV_ADD(OwnParts);
  SSLV_ADD(OwnPartUse);
  SSLV_ADD(StageNotes);
  SSLV_ADD(CameraFloor::Inputs);
  SSLV_ADD(FieldFloor::Inputs);
  SSLV_ADD(Step<CameraFloor>);
  SSLV_ADD(StageType);
  SSLV_ADD(FieldStageType);
  SSLV_ADD(Json);
#undef SSLV_ADD
  return stamp;
}

}  // namespace sslv
