// Checks the options, makes the backends, and makes an AdaptiveBroadPhase from them.
#include "engine_client/adaptive/adaptive_factory.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "engine_client/adaptive/adaptive_impl.h"
#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/text/names.h"

namespace sweepstake {
namespace {

// The first arm of a game that names no arms. It is the cheapest arm more often than any other,
// with 300 objects as well as with 20,000 (tests/bench/worth.py).
constexpr char kInitialArm[] = "KDTree";

Status ValidateArms(std::span<const std::string> arms) {
  if (arms.empty() || arms.size() > BailOutGuard::kMaxArms) {
    return {StatusCode::kInvalidArgument,
            "arms holds " + std::to_string(arms.size()) + " names; give 1 to 32"};
  }
  for (size_t i = 0; i < arms.size(); ++i) {
    if (IndexOfArm(arms[i], arms) != i) {
      return {StatusCode::kInvalidArgument, "arm '" + arms[i] + "' is named twice"};
    }
  }
  return {};
}

Status ValidateOptions(const AdaptiveOptions& options) {
  if (options.bail_out_ns == 0) {
    return {StatusCode::kInvalidArgument,
            "bail_out_ns is 0; give the frame time in ns above which an arm is replaced"};
  }
  if (options.mode != Mode::kManual && options.mode != Mode::kAi) {
    return {StatusCode::kInvalidArgument, "mode is neither kManual (1) nor kAi (2)"};
  }
  const ShadowOptions& shadow = options.shadow;
  if (!(shadow.duty_ratio > 0 && shadow.duty_ratio <= 1)) {
    return {StatusCode::kInvalidArgument, "shadow.duty_ratio must be over 0 and at most 1"};
  }
  if (shadow.enabled > ShadowMode::kOn || shadow.visit_cap_ns == 0) {
    return {StatusCode::kInvalidArgument,
            "shadow.enabled must be kOff (0), kAuto (1) or kOn (2), and shadow.visit_cap_ns must "
            "be over 0"};
  }
  return {};
}

Result<ArmBackend> MakeArm(std::string_view arm, Executor* executor, uint64_t max_pairs) {
  ArmBackend made;
  if (executor != nullptr) made.executor = std::make_unique<DetachableExecutor>(*executor);
  auto backend = MakeBroadPhase(arm, {.executor = made.executor.get(), .max_pairs = max_pairs});
  if (!backend.ok()) return backend.status();
  made.backend = std::move(*backend);
  return made;
}

}  // namespace

std::optional<uint32_t> IndexOfArm(std::string_view name, std::span<const std::string> arms) {
  const auto found = std::find(arms.begin(), arms.end(), name);
  if (found == arms.end()) return std::nullopt;
  return static_cast<uint32_t>(found - arms.begin());
}

Status UnknownArm(std::string_view name, std::span<const std::string> arms) {
  const std::vector<std::string_view> valid(arms.begin(), arms.end());
  return {StatusCode::kNotFound, text::UnknownName("arm", name, valid)};
}

Result<std::unique_ptr<AdaptiveBroadPhase>> AdaptiveFactory::Make(const AdaptiveOptions& options,
                                                                  std::vector<ArmBackend> backends,
                                                                  const LaneParts& lane,
                                                                  FrameSink* sink, Clock& clock) {
  std::vector<std::string> arms;
  arms.reserve(backends.size());
  for (const ArmBackend& own : backends) arms.emplace_back(own.backend->name());
  if (Status status = ValidateArms(arms); !status.ok()) return status;
  if (Status status = ValidateOptions(options); !status.ok()) return status;
  std::optional<uint32_t> initial = 0;
  if (!options.initial_arm.empty()) initial = IndexOfArm(options.initial_arm, arms);
  if (!initial) return UnknownArm(options.initial_arm, arms);
  auto impl = std::make_unique<AdaptiveBroadPhase::Impl>(
      options, std::move(arms), std::move(backends), *initial, lane, sink, clock);
  if (Status status = impl->StartLane(); !status.ok()) return status;
  return std::unique_ptr<AdaptiveBroadPhase>(new AdaptiveBroadPhase(std::move(impl)));
}

Result<std::unique_ptr<AdaptiveBroadPhase>> AdaptiveFactory::Make(
    const AdaptiveOptions& options, std::vector<std::unique_ptr<BroadPhase>> backends,
    FrameSink* sink, Clock& clock) {
  std::vector<ArmBackend> owned;
  owned.reserve(backends.size());
  for (auto& backend : backends) owned.push_back({nullptr, std::move(backend)});
  return Make(options, std::move(owned), {}, sink, clock);
}

Result<std::unique_ptr<AdaptiveBroadPhase>> AdaptiveBroadPhase::Create(
    const AdaptiveOptions& options, FrameSink* sink, Clock& clock) {
  const FloatEnvironmentScope environment;
  if (options.arms.empty()) {
    AdaptiveOptions of_all = options;
    of_all.arms.assign(BroadPhaseNames().begin(), BroadPhaseNames().end());
    if (of_all.initial_arm.empty()) of_all.initial_arm = kInitialArm;
    return Create(of_all, sink, clock);
  }
  const std::vector<std::string>& arms = options.arms;
  if (Status status = ValidateArms(arms); !status.ok()) return status;
  std::vector<ArmBackend> backends;
  const std::vector<std::string> names(BroadPhaseNames().begin(), BroadPhaseNames().end());
  for (const std::string& arm : arms) {
    if (!IndexOfArm(arm, names)) return UnknownArm(arm, names);
    Result<ArmBackend> made = MakeArm(arm, options.executor, options.max_pairs);
    if (!made.ok()) return made.status();
    backends.push_back(std::move(*made));
  }
  const auto make = [arms, executor = options.executor,
                     max_pairs = options.max_pairs](uint32_t arm) {
    return std::move(*MakeArm(arms[arm], executor, max_pairs));
  };
  return AdaptiveFactory::Make(options, std::move(backends), {make}, sink, clock);
}

}  // namespace sweepstake
