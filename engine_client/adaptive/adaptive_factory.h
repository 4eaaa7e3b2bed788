// Makes an AdaptiveBroadPhase from given backends, not from the registry; tests pass scripted
// backends. Also defines ArmBackend: a backend whose executor can be detached. Internal to this
// repository.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "engine_client/broad_phase/host/usable_cores.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake {

// Runs parts on the shared executor while attached, otherwise on the calling thread.
class DetachableExecutor final : public Executor {
 public:
  // Borrows `shared`, which must outlive this executor.
  explicit DetachableExecutor(Executor& shared) : shared_(shared) {}

  void Attach(bool attached) { attached_ = attached; }

  // Returns the thread count of the shared executor even while detached, because backends choose
  // the size of their buffers by it.
  size_t thread_count() const noexcept override { return shared_.thread_count(); }
  void RunParts(size_t part_count, RunPart run_part, void* context) noexcept override {
    if (attached_) return shared_.RunParts(part_count, run_part, context);
    for (size_t part = 0; part < part_count; ++part) run_part(context, part);
  }

 private:
  Executor& shared_;
  bool attached_ = false;
};

// A backend and its executor. The frame path owns one per arm, and so does the shadow lane; a warm
// switch swaps these two. The lane's backend is detached: it runs on the lane's thread alone. The
// frame path's backend uses the engine's threads. Not thread-safe; owned by one thread at a time.
struct ArmBackend {
  std::unique_ptr<DetachableExecutor> executor;  // may be null; outlives the backend
  std::unique_ptr<BroadPhase> backend;

  void Attach(bool attached) const {
    if (executor != nullptr) executor->Attach(attached);
  }
};

// Makes another backend of the arm with this index, detached. Throws std::bad_alloc.
using ArmBackendFactory = std::function<ArmBackend(uint32_t arm)>;

// The functions that a shadow lane needs. If `make` is null, there is no lane, and the memory of
// inactive arms is never freed.
struct LaneParts {
  ArmBackendFactory make;  // makes the lane's backends, and new ones for freed arms
  // Returns how many cores the lane's thread and the engine's threads may use together.
  size_t (*usable_cores)() noexcept = UsableCores;
};

class AdaptiveFactory {
 public:
  // Makes an AdaptiveBroadPhase from `backends`. Their names replace options.arms. Returns the
  // errors of AdaptiveBroadPhase::Create.
  static Result<std::unique_ptr<AdaptiveBroadPhase>> Make(const AdaptiveOptions& options,
                                                          std::vector<ArmBackend> backends,
                                                          const LaneParts& lane, FrameSink* sink,
                                                          Clock& clock);
  // Does the same as the first Make, but without a shadow lane.
  static Result<std::unique_ptr<AdaptiveBroadPhase>> Make(
      const AdaptiveOptions& options, std::vector<std::unique_ptr<BroadPhase>> backends,
      FrameSink* sink, Clock& clock);
};

}  // namespace sweepstake
