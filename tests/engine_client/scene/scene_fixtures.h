// Helpers of the scene tests: creating scenes that must exist, and hashing boxes bit by bit.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "engine_client/math/hash.h"
#include "sweepstake/scene.h"

namespace sweepstake {

inline std::unique_ptr<Scene> MustMakeScene(std::string_view name, const SceneOptions& options) {
  Result<std::unique_ptr<Scene>> scene = MakeScene(name, options);
  if (!scene.ok()) throw std::runtime_error(scene.status().message());
  return std::move(*scene);
}

inline SceneOptions WithCount(uint32_t object_count) {
  SceneOptions options;
  options.object_count = object_count;
  return options;
}

inline std::vector<Aabb> BoxesOf(const Scene& scene) {
  return {scene.aabbs().begin(), scene.aabbs().end()};
}

inline void StepTimes(Scene& scene, int count) {
  for (int i = 0; i < count; ++i) scene.Step();
}

// FNV-1a over the bit patterns, so that -0 and 0 differ.
class BitHash {
 public:
  void Add(std::span<const Aabb> boxes) {
    for (const Aabb& box : boxes) {
      for (const float x : box.min) Add(x);
      for (const float x : box.max) Add(x);
    }
  }

  uint64_t value() const { return hash_; }

 private:
  void Add(float value) { hash_ = math::Fnv1aOfWord(hash_, std::bit_cast<uint32_t>(value)); }

  uint64_t hash_ = math::kFnv1aStart;
};

inline uint64_t HashOfFrames(Scene& scene, int frame_count) {
  BitHash hash;
  hash.Add(scene.aabbs());
  for (int frame = 0; frame < frame_count; ++frame) {
    scene.Step();
    hash.Add(scene.aabbs());
  }
  return hash.value();
}

}  // namespace sweepstake
