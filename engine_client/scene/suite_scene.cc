#include "engine_client/scene/suite_scene.h"

#include <array>
#include <vector>

#include "engine_client/math/portable_math.h"
#include "engine_client/scene/generated_scene.h"
#include "engine_client/scene/random.h"

namespace sweepstake {
namespace {

constexpr float kMinHalfExtent = 0.145F;
constexpr float kLogOfSizeRatio = 1.6094379F;  // ln 5
constexpr float kFullTurn = 6.2831853F;

float SideOfDensityOne(uint32_t object_count) {
  return static_cast<float>(math::CubeRoot(object_count));
}

// Returns `x` reflected at the walls 0 and `side`.
float ReflectInside(float x, float side) {
  if (x < 0) x = -x;
  return x > side ? 2 * side - x : x;
}

// These functions compute in double and round once to float.
float SinF(float x) { return static_cast<float>(math::Sin(x)); }
float CosF(float x) { return static_cast<float>(math::Cos(x)); }
float ExpF(float x) { return static_cast<float>(math::Exp(x)); }
float PowF(float x, float y) { return static_cast<float>(math::Pow(x, y)); }

// The base class of the suite. All draws come in order from one splitmix64 stream, and all
// arithmetic is in float. A change of the order of draws or operations changes every published pair
// count.
class SuiteScene : public GeneratedScene {
 protected:
  // `variant` is the index of the scene in the suite (B 0, G 1, H 2). It is part of the seed.
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

// G: the direction of gravity changes every 35 frames. Each object has its own floor in x and in y,
// up to a quarter of the side from the wall.
class SuiteGravity final : public SuiteScene {
 public:
  explicit SuiteGravity(uint32_t object_count);

 private:
  void Move() override;
  void MoveAxis(uint32_t object, int axis);

  std::vector<float> floor_;
  std::array<std::vector<float>, 3> velocity_;  // motion in units per frame
};

// H: objects orbit the middle, by 0.44 radians per frame at the axis and 0.04 at the rim.
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

SuiteScene::SuiteScene(std::string_view name, uint64_t variant, uint32_t object_count)
    : GeneratedScene(name,
                     {{0, 0, 0},
                      {SideOfDensityOne(object_count), SideOfDensityOne(object_count),
                       SideOfDensityOne(object_count)}},
                     object_count),
      side_(SideOfDensityOne(object_count)),
      random_(0x1234ABCDU + variant * 1000003U + object_count) {}

void SuiteScene::SpawnSize(uint32_t object) {
  for (std::vector<float>& half_extent : bodies().half_extent) {
    half_extent[object] = kMinHalfExtent * ExpF(kLogOfSizeRatio * random_.Unit());
  }
}

void SuiteScene::SpawnPosition(uint32_t object) {
  for (std::vector<float>& centre : bodies().centre) centre[object] = side_ * random_.Unit();
}

SuiteBrownian::SuiteBrownian(uint32_t object_count) : SuiteScene("suite-b", 0, object_count) {
  for (uint32_t i = 0; i < object_count; ++i) {
    SpawnSize(i);
    SpawnPosition(i);
    // This draw is unused. Suite-g draws its floor here, and all scenes of the suite share the
    // order of their first draws.
    random().Unit();
  }
  ShowBodies();
}

void SuiteBrownian::Move() {
  for (uint32_t i = 0; i < object_count(); ++i) {
    for (std::vector<float>& centre : bodies().centre) {
      centre[i] = ReflectInside(centre[i] + 0.1F * random().Symmetric(), side());
    }
  }
}

SuiteGravity::SuiteGravity(uint32_t object_count)
    : SuiteScene("suite-g", 1, object_count), floor_(object_count) {
  for (std::vector<float>& axis : velocity_) axis.resize(object_count);
  for (uint32_t i = 0; i < object_count; ++i) {
    SpawnSize(i);
    SpawnPosition(i);
    floor_[i] = 0.25F * side() * random().Unit();
  }
  ShowBodies();
}

void SuiteGravity::Move() {
  constexpr float kDirections[4][2] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};
  const float* direction = kDirections[(frame_index() / 35) % 4];
  const float pull = 0.001F * side();
  for (uint32_t i = 0; i < object_count(); ++i) {
    velocity_[0][i] = (velocity_[0][i] + pull * direction[0]) * 0.98F;
    velocity_[1][i] = (velocity_[1][i] + pull * direction[1]) * 0.98F;
    velocity_[2][i] *= 0.98F;
    for (int axis = 0; axis < 3; ++axis) MoveAxis(i, axis);
  }
}

void SuiteGravity::MoveAxis(uint32_t object, int axis) {
  const float low = axis < 2 ? floor_[object] : 0.0F;
  const float high = side() - low;
  float& velocity = velocity_[axis][object];
  float x = bodies().centre[axis][object] + velocity;
  const bool hit_low = x < low && velocity < 0;
  const bool hit_high = x > high && velocity > 0;
  if (hit_low) x = low;
  if (hit_high) x = high;
  bodies().centre[axis][object] = x;
  if (!hit_low && !hit_high) return;
  velocity *= -0.3F;
  velocity_[(axis + 1) % 3][object] += 0.002F * side() * random().Symmetric();
  velocity_[(axis + 2) % 3][object] += 0.002F * side() * random().Symmetric();
}

SuiteHurricane::SuiteHurricane(uint32_t object_count)
    : SuiteScene("suite-h", 2, object_count),
      radius_(object_count),
      angle_(object_count),
      phase_(object_count) {
  for (uint32_t i = 0; i < object_count; ++i) {
    SpawnSize(i);
    radius_[i] = 0.5F * side() * PowF(random().Unit(), 0.75F);
    angle_[i] = kFullTurn * random().Unit();
    phase_[i] = kFullTurn * random().Unit();
    bodies().centre[1][i] = side() * random().Unit();
  }
  PlaceOnOrbits();
  ShowBodies();
}

void SuiteHurricane::Move() {
  const float rim = 0.5F * side();
  for (uint32_t i = 0; i < object_count(); ++i) {
    angle_[i] += 0.044F / (0.1F + radius_[i] / rim);
    if (angle_[i] > kFullTurn) angle_[i] -= kFullTurn;
    float& height = bodies().centre[1][i];
    height = ReflectInside(height + 0.02F * random().Symmetric(), side());
  }
  PlaceOnOrbits();
}

void SuiteHurricane::PlaceOnOrbits() {
  const float middle = 0.5F * side();
  const float swing = 0.1F * static_cast<float>(frame_index());
  for (uint32_t i = 0; i < object_count(); ++i) {
    const float radius = radius_[i] * (1.0F + 0.05F * SinF(swing + phase_[i]));
    bodies().centre[0][i] = middle + radius * CosF(angle_[i]);
    bodies().centre[2][i] = middle + radius * SinF(angle_[i]);
  }
}

}  // namespace

std::unique_ptr<Scene> MakeSuiteBrownian(uint32_t object_count) {
  return std::make_unique<SuiteBrownian>(object_count);
}

std::unique_ptr<Scene> MakeSuiteGravity(uint32_t object_count) {
  return std::make_unique<SuiteGravity>(object_count);
}

std::unique_ptr<Scene> MakeSuiteHurricane(uint32_t object_count) {
  return std::make_unique<SuiteHurricane>(object_count);
}

}  // namespace sweepstake
