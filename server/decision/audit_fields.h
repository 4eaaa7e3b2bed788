// The members of what the audit log holds, in the order of their declaration.
//
// Each function names every member, so that a new one does not compile until it is in the log.
#pragma once

#include <concepts>
#include <tuple>
#include <type_traits>

#include "server/decision/types.h"

namespace sweepstake::decision {

template <typename T, typename Value>
concept EitherConst = std::same_as<std::remove_const_t<T>, Value>;

template <EitherConst<Frame> T>
auto FieldsOf(T& frame) {
  auto& [frame_time_ns, detection_time_ns, check_count, native_bytes, object_count, arm, epoch,
         flags] = frame;
  return std::tie(frame_time_ns, detection_time_ns, check_count, native_bytes, object_count, arm,
                  epoch, flags);
}

template <EitherConst<ShadowSample> T>
auto FieldsOf(T& sample) {
  auto& [first_frame_index, detection_time_ns, build_time_ns, check_count, native_bytes, arm,
         object_count, frame_count, flags] = sample;
  return std::tie(first_frame_index, detection_time_ns, build_time_ns, check_count, native_bytes,
                  arm, object_count, frame_count, flags);
}

template <EitherConst<SceneDescriptor> T>
auto FieldsOf(T& scene) {
  auto& [object_count, density, size_spread, speed_mean, speed_spread, clustering, static_ratio] =
      scene;
  return std::tie(object_count, density, size_spread, speed_mean, speed_spread, clustering,
                  static_ratio);
}

}  // namespace sweepstake::decision
