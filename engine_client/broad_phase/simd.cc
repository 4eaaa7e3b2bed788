#include "sweepstake/simd.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "engine_client/text/names.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/simd.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

int64_t TargetOfKernels() { return HWY_TARGET; }

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sweepstake {
namespace {

HWY_EXPORT(TargetOfKernels);

struct Level {
  std::string_view name;
  int64_t targets;  // Highway's bits of the targets that this level covers
};

// For each processor architecture, the fastest level comes first.
constexpr std::array kLevels = {
    Level{"avx512", HWY_AVX3_DL | HWY_AVX3},
    Level{"avx2", HWY_AVX2},
    Level{"sse4", HWY_SSE4},
    Level{"sve2", HWY_SVE2_128 | HWY_SVE2},
    Level{"sve", HWY_SVE_256 | HWY_SVE},
    Level{"neon", HWY_NEON},
    Level{"scalar", HWY_EMU128 | HWY_SCALAR},
};

// The instruction sets that the machine has and that kernels are compiled for.
class Usable {
 public:
  Usable() {
    for (const Level& level : kLevels) {
      if ((targets_ & level.targets) == 0) continue;
      names_[count_] = level.name;
      ++count_;
    }
  }

  std::span<const std::string_view> names() const { return {names_.data(), count_}; }
  // Returns the usable targets except those better than the named level. In Highway's target bits,
  // a better target has a lower bit. This also excludes better targets that have no level here.
  int64_t NoBetterThan(std::string_view name) const {
    for (const Level& level : kLevels) {
      const int64_t named = targets_ & level.targets;
      if (level.name == name) return targets_ & ~((named & -named) - 1);
    }
    return targets_;
  }

 private:
  const int64_t targets_ = hwy::SupportedTargets() & int64_t{HWY_TARGETS};
  std::array<std::string_view, kLevels.size()> names_;
  size_t count_ = 0;
};

// The first call reads the targets. It must precede the first UseSimdTarget, which hides targets.
const Usable& UsableTargets() {
  static const Usable usable;
  return usable;
}

constexpr const char* kVariable = "SWEEPSTAKE_CLIENT_SIMD";

// True once the program has chosen an instruction set; the environment variable is then ignored.
std::atomic<bool> is_chosen{false};

Status ReadEnvironment() {
  const char* const name = std::getenv(kVariable);
  if (name == nullptr || *name == '\0' || is_chosen) return {};
  const Status status = UseSimdTarget(name);
  return status.ok() ? status
                     : Status(status.code(), std::string(kVariable) + ": " + status.message());
}

}  // namespace

std::span<const std::string_view> SimdTargets() { return UsableTargets().names(); }

std::string_view SimdTarget() {
  // An invalid environment variable is ignored here, since MakeBroadPhase reports it.
  (void)UseSimdTargetOfEnvironment();
  const int64_t target = HWY_DYNAMIC_DISPATCH(TargetOfKernels)();
  for (const Level& level : kLevels) {
    if ((target & level.targets) != 0) return level.name;
  }
  return "unknown";
}

Status UseSimdTarget(std::string_view name) {
  for (const std::string_view usable : SimdTargets()) {
    if (usable != name) continue;
    is_chosen = true;
    // hwy::SetSupportedTargetsForTest is used because DisableTargets of Highway 1.0 is undone by
    // the next query of the supported targets.
    hwy::SetSupportedTargetsForTest(UsableTargets().NoBetterThan(name));
    // Highway selects the compiled variant again at the next dispatched call. This call triggers
    // the selection now, so that no broad phase spends time on it.
    HWY_DYNAMIC_DISPATCH(TargetOfKernels)();
    return {};
  }
  return {StatusCode::kInvalidArgument,
          text::UnknownName("instruction set of this machine", name, SimdTargets())};
}

Status UseSimdTargetOfEnvironment() {
  static const Status status = ReadEnvironment();
  return status;
}

}  // namespace sweepstake
#endif  // HWY_ONCE
