#include "sweepstake/simd.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "hwy/highway.h"
#include "server/decision/math/names.h"

namespace sweepstake {
namespace {

struct Level {
  std::string_view name;
  int64_t targets;  // Highway's
};

// The best of each architecture first.
constexpr std::array kLevels = {
    Level{"avx512", HWY_AVX3_DL | HWY_AVX3},
    Level{"avx2", HWY_AVX2},
    Level{"sse4", HWY_SSE4},
    Level{"sve2", HWY_SVE2_128 | HWY_SVE2},
    Level{"sve", HWY_SVE_256 | HWY_SVE},
    Level{"neon", HWY_NEON},
    Level{"scalar", HWY_EMU128 | HWY_SCALAR},
};

class Usable {
 public:
  Usable() {
    const int64_t usable = hwy::SupportedTargets() & int64_t{HWY_TARGETS};
    for (const Level& level : kLevels) {
      if ((usable & level.targets) == 0) continue;
      names_[count_] = level.name;
      ++count_;
    }
  }

  std::span<const std::string_view> names() const { return {names_.data(), count_}; }

 private:
  std::array<std::string_view, kLevels.size()> names_;
  size_t count_ = 0;
};

// Returns Highway's targets that are better than the level of this name.
int64_t BetterThan(std::string_view name) {
  int64_t better = 0;
  for (const Level& level : kLevels) {
    if (level.name == name) break;
    better |= level.targets;
  }
  return better;
}

constexpr const char* kVariable = "SWEEPSTAKE_CLIENT_SIMD";

// By the program, over which the environment does not go.
std::atomic<bool> is_chosen{false};

Status ReadEnvironment() {
  const char* const name = std::getenv(kVariable);
  if (name == nullptr || is_chosen) return {};
  const Status status = UseSimdTarget(name);
  return status.ok() ? status
                     : Status(status.code(), std::string(kVariable) + ": " + status.message());
}

}  // namespace

std::span<const std::string_view> SimdTargets() {
  // Read before any is disabled.
  static const Usable usable;
  return usable.names();
}

std::string_view SimdTarget() {
  // A wrong variable is told by who makes a broad phase.
  (void)UseSimdTargetOfEnvironment();
  const int64_t left = hwy::SupportedTargets() & int64_t{HWY_TARGETS};
  for (const Level& level : kLevels) {
    if ((left & level.targets) != 0) return level.name;
  }
  return "unknown";
}

Status UseSimdTarget(std::string_view name) {
  for (const std::string_view usable : SimdTargets()) {
    if (usable != name) continue;
    is_chosen = true;
    hwy::DisableTargets(BetterThan(name));
    return {};
  }
  return {StatusCode::kInvalidArgument,
          math::UnknownName("instruction set of this machine", name, SimdTargets())};
}

Status UseSimdTargetOfEnvironment() {
  static const Status status = ReadEnvironment();
  return status;
}

}  // namespace sweepstake
