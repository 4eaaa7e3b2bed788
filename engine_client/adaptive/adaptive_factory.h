// Backends with detachable executors, and a factory that makes an AdaptiveBroadPhase from the
// caller's backends instead of the registry's (tests use scripted backends). Internal to this
// repository.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "engine_client/broad_phase/host/usable_cores.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake {

// Runs parts on another executor while attached to it, otherwise on the calling thread.
class DetachableExecutor final : public Executor {
 public:
  // Borrows `shared`, which must outlive this executor.
  explicit DetachableExecutor(Executor& shared) : shared_(shared) {}

  void Attach(bool attached) { attached_ = attached; }

  // Returns the count of the shared executor even while detached, because backends size their
  // buffers by it.
  size_t thread_count() const noexcept override { return shared_.thread_count(); }
  void RunParts(size_t part_count, RunPart run_part, void* context) noexcept override {
    if (attached_) return shared_.RunParts(part_count, run_part, context);
    for (size_t part = 0; part < part_count; ++part) run_part(context, part);
  }

 private:
  Executor& shared_;
  bool attached_ = false;
};

// A backend and its executor. The frame path and the shadow lane own one each per arm, and swap
// them at a warm switch. The lane's backend runs on the lane's thread alone, the frame path's on
// the engine's threads. Not thread-safe; owned by one thread at a time.
struct ArmBackend {
  std::unique_ptr<DetachableExecutor> executor;  // may be null; outlives the backend
  std::unique_ptr<BroadPhase> backend;

  void Attach(bool attached) const {
    if (executor != nullptr) executor->Attach(attached);
  }
};

// Makes another, detached backend of the arm with this index. Throws std::bad_alloc.
using ArmBackendFactory = std::function<ArmBackend(uint32_t arm)>;

// The parts of the shadow lane. Without `make` no lane is made, and no arm's memory is freed.
struct LaneParts {
  ArmBackendFactory make;  // makes the lane's backends, and new ones for freed arms
  // Returns how many cores the lane's thread and the engine's threads may use together.
  size_t (*usable_cores)() noexcept = UsableCores;
};

class AdaptiveFactory {
 public:
  // `backends` replace options.arms: their names are the arms. The errors are those of
  // AdaptiveBroadPhase::Create.
  static Result<std::unique_ptr<AdaptiveBroadPhase>> Make(const AdaptiveOptions& options,
                                                          std::vector<ArmBackend> backends,
                                                          const LaneParts& lane, FrameSink* sink,
                                                          Clock& clock);
  // Makes an AdaptiveBroadPhase of `backends` without a lane. The errors are those of
  // AdaptiveBroadPhase::Create.
  static Result<std::unique_ptr<AdaptiveBroadPhase>> Make(
      const AdaptiveOptions& options, std::vector<std::unique_ptr<BroadPhase>> backends,
      FrameSink* sink, Clock& clock);
};

}  // namespace sweepstake
