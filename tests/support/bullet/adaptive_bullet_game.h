// A game on a dynamics world of Bullet that uses Sweepstake as its broad phase.
#pragma once

#include <memory>
#include <utility>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/bullet.h"
#include "tests/support/bullet/bullet_game.h"
#include "tests/support/one_arm.h"

namespace sweepstake::test_support {

class AdaptiveBulletGame {
 public:
  // REQUIRES: valid options. The broad phase also uses the executor of the search.
  AdaptiveBulletGame(const AdaptiveOptions& search, const BulletGameOptions& game,
                     FrameSink* sink = nullptr)
      : search_(std::move(*AdaptiveBroadPhase::Create(search, sink))),
        broad_phase_(*search_, search.executor),
        game_(broad_phase_, game) {}

  void Step() {
    constexpr uint64_t kFrameNs = 16'666'667;
    search_->BeginFrame();
    game_.Step();
    search_->EndFrame({.frame_time_ns = kFrameNs});
  }

  AdaptiveBroadPhase& search() { return *search_; }
  BulletBroadPhase& broad_phase() { return broad_phase_; }
  BulletGame& game() { return game_; }

 private:
  std::unique_ptr<AdaptiveBroadPhase> search_;
  BulletBroadPhase broad_phase_;
  BulletGame game_;
};

}  // namespace sweepstake::test_support
