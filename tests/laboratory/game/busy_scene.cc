#include "tests/laboratory/game/busy_scene.h"

#include <chrono>
#include <utility>

namespace sweepstake::cli {

BusyScene::BusyScene(std::unique_ptr<Scene> scene, uint64_t work_ns)
    : scene_(std::move(scene)),
      work_ns_(work_ns),
      memory_(work_ns == 0 ? 0 : kWorkBytes / sizeof(uint64_t)) {}

void BusyScene::DoStep() {
  scene_->Step();
  if (work_ns_ == 0) return;
  // About a microsecond between two looks at the clock.
  constexpr size_t kWordsPerLook = 1024;
  const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(work_ns_);
  while (std::chrono::steady_clock::now() < end) {
    for (size_t i = 0; i < kWordsPerLook; ++i) memory_[(next_ + i) % memory_.size()] += next_ + i;
    next_ = (next_ + kWordsPerLook) % memory_.size();
  }
}

}  // namespace sweepstake::cli
