// What the scene tests share: making scenes that must exist, and looking at boxes bit by bit.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

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
      for (const float x : box.min) AddWord(std::bit_cast<uint32_t>(x));
      for (const float x : box.max) AddWord(std::bit_cast<uint32_t>(x));
    }
  }

  uint64_t value() const { return hash_; }

 private:
  void AddWord(uint32_t word) {
    for (int shift = 0; shift < 32; shift += 8) {
      hash_ = (hash_ ^ ((word >> shift) & 0xFFU)) * 0x100000001B3U;
    }
  }

  uint64_t hash_ = 0xCBF29CE484222325U;
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
