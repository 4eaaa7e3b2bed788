// A game on a world of ODE that uses Sweepstake as its broad phase.
#pragma once

#include <memory>
#include <utility>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/ode.h"
#include "tests/support/ode/ode_game.h"
#include "tests/support/one_arm.h"

namespace sweepstake::test_support {

class AdaptiveOdeGame {
 public:
  // REQUIRES: valid options.
  AdaptiveOdeGame(const AdaptiveOptions& search, const OdeGameOptions& game,
                  FrameSink* sink = nullptr)
      : search_(std::move(*AdaptiveBroadPhase::Create(search, sink))),
        game_(game),
        broad_phase_(*search_, game_.space(), search.executor) {}

  void Step() {
    constexpr uint64_t kFrameNs = 16'666'667;
    search_->BeginFrame();
    game_.Step([&](void* data, dNearCallback* callback) { broad_phase_.Collide(data, callback); });
    search_->EndFrame({.frame_time_ns = kFrameNs});
  }

  AdaptiveBroadPhase& search() { return *search_; }
  OdeBroadPhase& broad_phase() { return broad_phase_; }
  OdeGame& game() { return game_; }

 private:
  std::unique_ptr<AdaptiveBroadPhase> search_;
  OdeGame game_;
  OdeBroadPhase broad_phase_;
};

// A game that uses the collision detection of its own space.
class OwnOdeGame {
 public:
  explicit OwnOdeGame(const OdeGameOptions& options) : game_(options) {}

  void Step() {
    game_.Step(
        [&](void* data, dNearCallback* callback) { dSpaceCollide(game_.space(), data, callback); });
  }

  OdeGame& game() { return game_; }

 private:
  OdeGame game_;
};

}  // namespace sweepstake::test_support
