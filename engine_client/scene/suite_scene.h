// "suite-b", "suite-g", "suite-h": the reference suite that all published figures use. Density 1
// (world side is the cube root of the object count), half extents log-uniform 0.145 to 0.725,
// positions in one corner-anchored cube.
//
// Everything but the object count is fixed, the seed included, so that a figure names its scene by
// letter and count. Draws come in order from one splitmix64 stream and all arithmetic is in float:
// changing the order of either changes every published pair count.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine_client/scene/generated_scene.h"
#include "engine_client/scene/sequential_random.h"

namespace sweepstake {

class SuiteScene : public GeneratedScene {
 protected:
  // `variant` is the scene's place in the suite (B 0, G 1, H 2); it enters the seed.
  SuiteScene(std::string_view name, uint64_t variant, uint32_t object_count);

  float side() const { return side_; }
  SequentialRandom& random() { return random_; }
  void SpawnSize(uint32_t object);
  void SpawnPosition(uint32_t object);

 private:
  float side_;
  SequentialRandom random_;
};

// B: each step moves each object by ±0.1 on each axis, reflected at the walls.
class SuiteBrownian final : public SuiteScene {
 public:
  explicit SuiteBrownian(uint32_t object_count);

 private:
  void Move() override;
};

// G: gravity turns every 35 frames; each object has its own floor in x and y, up to a quarter of
// the side in.
class SuiteGravity final : public SuiteScene {
 public:
  explicit SuiteGravity(uint32_t object_count);

 private:
  void Move() override;
  void MoveAxis(uint32_t object, int axis);

  std::vector<float> floor_;
  std::array<std::vector<float>, 3> velocity_;  // units per frame
};

// H: orbits around the middle, 0.44 radians per frame at the axis to 0.04 at the rim.
class SuiteHurricane final : public SuiteScene {
 public:
  explicit SuiteHurricane(uint32_t object_count);

 private:
  void Move() override;
  void PlaceOnOrbits();

  std::vector<float> radius_;
  std::vector<float> angle_;
  std::vector<float> phase_;
};

}  // namespace sweepstake
