// A backend with the executor it runs on, which can be taken away from it for a while.
//
// The frame path and the shadow lane have one each per arm and exchange them at a warm switch: what
// the lane runs works on its thread alone, what the frame path runs spreads over the engine's
// threads. Not thread-safe; owned by one thread at a time.
#pragma once

#include <functional>
#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

// Passes parts on to another executor, or runs them on the calling thread.
class DetachableExecutor final : public Executor {
 public:
  // `shared` is borrowed.
  explicit DetachableExecutor(Executor& shared) : shared_(shared) {}

  void Attach(bool attached) { attached_ = attached; }

  // The shared one's, attached or not: backends size their buffers by it.
  size_t thread_count() const noexcept override { return shared_.thread_count(); }
  void RunParts(size_t part_count, RunPart run_part, void* context) noexcept override {
    if (attached_) return shared_.RunParts(part_count, run_part, context);
    for (size_t part = 0; part < part_count; ++part) run_part(context, part);
  }

 private:
  Executor& shared_;
  bool attached_ = false;
};

struct ArmBackend {
  std::unique_ptr<DetachableExecutor> executor;  // null: none; outlives the backend
  std::unique_ptr<BroadPhase> backend;

  void Attach(bool attached) const {
    if (executor != nullptr) executor->Attach(attached);
  }
};

// Makes another backend of the arm with this index, detached. Throws std::bad_alloc.
using ArmBackendFactory = std::function<ArmBackend(uint32_t arm)>;

}  // namespace sweepstake
