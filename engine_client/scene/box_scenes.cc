#include "engine_client/scene/box_scenes.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

#include "engine_client/math/portable_math.h"

namespace sweepstake {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kMaxFloat = std::numeric_limits<float>::max();

// The box to spawn or move: its index, the number of boxes, and the frame.
struct Slot {
  size_t index;
  size_t count;
  uint64_t frame;

  float WorldSide() const { return static_cast<float>(math::CubeRoot(static_cast<double>(count))); }
};

struct BoxKind {
  std::string_view name;
  Aabb (*spawn)(SequentialRandom& random, const Slot& slot);
  void (*step)(SequentialRandom& random, const Slot& slot, Aabb& box);
};

// Shifts a box along an axis. Rounding is monotonic, so min <= max still holds afterwards.
void Shift(Aabb& box, int axis, float distance) {
  box.min[axis] += distance;
  box.max[axis] += distance;
}

void Jitter(SequentialRandom& random, float distance, Aabb& box) {
  for (int axis = 0; axis < 3; ++axis) Shift(box, axis, random.Between(-distance, distance));
}

// On a random axis, moves the box by −`distance`, 0 or +`distance`. The draws are separate
// statements, because compilers evaluate function arguments in different orders.
void ShiftByOneOfThree(SequentialRandom& random, float distance, Aabb& box) {
  const float direction = static_cast<float>(random.Below(3)) - 1.0F;
  const auto axis = static_cast<int>(random.Below(3));
  Shift(box, axis, distance * direction);
}

float HalfExtent(SequentialRandom& random) {
  return static_cast<float>(0.145 * math::Pow(5.0, random.Unit()));
}

Aabb Around(const float (&center)[3], const float (&half)[3]) {
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = center[axis] - half[axis];
    box.max[axis] = center[axis] + half[axis];
  }
  return box;
}

Aabb SpawnScattered(SequentialRandom& random, const Slot& slot) {
  float center[3];
  float half[3];
  for (int axis = 0; axis < 3; ++axis) {
    center[axis] = random.Between(0, slot.WorldSide());
    half[axis] = HalfExtent(random);
  }
  return Around(center, half);
}

void StepBrownian(SequentialRandom& random, const Slot&, Aabb& box) { Jitter(random, 0.1F, box); }
void StepNearlyResting(SequentialRandom& random, const Slot&, Aabb& box) {
  Jitter(random, 0.001F, box);
}

// Moves the box with a probability of 1/100.
void StepFewMoving(SequentialRandom& random, const Slot&, Aabb& box) {
  if (random.Below(100) == 0) Jitter(random, 0.1F, box);
}

// Lets the box fall onto a floor at y = 0 that all boxes share.
void StepFalling(SequentialRandom& random, const Slot& slot, Aabb& box) {
  const float fall = 0.01F * static_cast<float>(slot.frame);
  Shift(box, 1, -std::min(fall, std::max(box.min[1], 0.0F)));
  Shift(box, 0, random.Between(-0.02F, 0.02F));
}

Aabb SpawnCoincident(SequentialRandom&, const Slot&) { return {{1, 2, 3}, {2, 3, 4}}; }
void StepCoincident(SequentialRandom&, const Slot& slot, Aabb& box) {
  Shift(box, static_cast<int>(slot.frame % 3), 0.25F);
}

// Spawns unit cubes in cells three units apart, so that there is a gap between any two cubes.
Aabb SpawnDisjoint(SequentialRandom& random, const Slot& slot) {
  const auto side = static_cast<size_t>(slot.WorldSide()) + 1;
  const size_t cell[3] = {slot.index % side, slot.index / side % side, slot.index / side / side};
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = 3.0F * static_cast<float>(cell[axis]) + random.Unit();
    box.max[axis] = box.min[axis] + 1.0F;
  }
  return box;
}
void StepDisjoint(SequentialRandom& random, const Slot& slot, Aabb& box) {
  box = SpawnDisjoint(random, slot);
}

// Spawns boxes with integer coordinates, so that faces, edges and corners meet exactly.
Aabb SpawnTouching(SequentialRandom& random, const Slot& slot) {
  Aabb box;
  for (float& low : box.min) low = std::floor(random.Between(0, 2 * slot.WorldSide()));
  for (int axis = 0; axis < 3; ++axis) box.max[axis] = box.min[axis] + 1;
  return box;
}
void StepTouching(SequentialRandom& random, const Slot&, Aabb& box) {
  ShiftByOneOfThree(random, 1.0F, box);
}

// Spawns points and lines on multiples of 0.5. So they coincide with one another, with faces of
// their neighbours, and with boxes of other kinds.
Aabb SpawnZeroSize(SequentialRandom& random, const Slot& slot) {
  Aabb box;
  for (float& low : box.min) low = 0.5F * std::floor(random.Between(0, 2 * slot.WorldSide()));
  std::copy(box.min, box.min + 3, box.max);
  if (random.Below(3) == 0) box.max[random.Below(3)] += 1;  // a line
  return box;
}
void StepZeroSize(SequentialRandom& random, const Slot&, Aabb& box) {
  ShiftByOneOfThree(random, 0.5F, box);
}

Aabb SpawnOneHuge(SequentialRandom& random, const Slot& slot) {
  if (slot.index != slot.count / 2) return SpawnScattered(random, slot);
  const float side = slot.WorldSide();
  return {{-side, -side, -side}, {0.75F * side, 2 * side, 2 * side}};
}

Aabb SpawnFar(SequentialRandom& random, const Slot&) {
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = 1e30F * (static_cast<float>(random.Below(5)) - 2.5F);
    box.max[axis] = box.min[axis] + (random.Below(2) == 0 ? 0.0F : 1e30F);
  }
  return box;
}
void StepFar(SequentialRandom& random, const Slot&, Aabb& box) {
  const int axis = static_cast<int>(random.Below(3));
  Shift(box, axis, box.min[axis] > 0 ? -5e29F : 5e29F);
}

Aabb SpawnFloatLimits(SequentialRandom& random, const Slot&) {
  constexpr float kDenormal = std::numeric_limits<float>::denorm_min();
  const std::array kValues = {-kMaxFloat,
                              -std::nextafter(kMaxFloat, 0.0F),
                              -1e30F,
                              -1.0F,
                              -kDenormal,
                              0.0F,
                              kDenormal,
                              1e-30F,
                              1.0F,
                              0.5F * kMaxFloat,
                              std::nextafter(kMaxFloat, 0.0F),
                              kMaxFloat};
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    const size_t low = random.Below(kValues.size());
    box.min[axis] = kValues[low];
    box.max[axis] = kValues[low + random.Below(kValues.size() - low)];
  }
  return box;
}
void StepFloatLimits(SequentialRandom& random, const Slot& slot, Aabb& box) {
  if (random.Below(4) == 0) box = SpawnFloatLimits(random, slot);
}

// Spawns boxes whose zero coordinates have a random sign, because faces at −0 must touch faces at
// +0.
Aabb SpawnSignedZeros(SequentialRandom& random, const Slot&) {
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    const size_t shape = random.Below(3);
    box.min[axis] = shape == 0 ? -1.0F : random.Below(2) == 0 ? -0.0F : 0.0F;
    box.max[axis] = shape == 1 ? 1.0F : random.Below(2) == 0 ? -0.0F : 0.0F;
  }
  return box;
}
void StepSignedZeros(SequentialRandom& random, const Slot& slot, Aabb& box) {
  box = SpawnSignedZeros(random, slot);
}

void StepTeleporting(SequentialRandom& random, const Slot& slot, Aabb& box) {
  if (random.Below(3) == 0) box = SpawnScattered(random, slot);
}

Aabb SpawnBroken(SequentialRandom& random, const Slot& slot) {
  Aabb box = SpawnScattered(random, slot);
  const size_t axis = random.Below(3);
  switch (random.Below(8)) {
    case 0:
      box.min[axis] = kNan;
      break;
    case 1:
      box.max[axis] = kNan;
      break;
    case 2:
      box.min[axis] = -kInfinity;
      break;
    case 3:
      box.max[axis] = kInfinity;
      break;
    case 4:
      std::swap(box.min[axis], box.max[axis]);
      break;
    case 5:
      box = {{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}};
      break;
    default:
      break;  // the box stays valid
  }
  return box;
}
void StepBroken(SequentialRandom& random, const Slot& slot, Aabb& box) {
  if (random.Below(2) == 0) box = SpawnBroken(random, slot);
}

Aabb SpawnLongThin(SequentialRandom& random, const Slot& slot) {
  Aabb box = SpawnScattered(random, slot);
  const size_t axis = random.Below(3);
  box.max[axis] = box.min[axis] + random.Between(0.5F, 1.0F) * slot.WorldSide();
  return box;
}

// Spawns a beam. Its length does not depend on the object count, so neither does the number of
// pairs per object. In long-thin, lengths grow with the world.
Aabb SpawnBeam(SequentialRandom& random, const Slot& slot) {
  float center[3];
  float half[3];
  const size_t length_axis = random.Below(3);
  for (size_t axis = 0; axis < 3; ++axis) {
    center[axis] = random.Between(0, slot.WorldSide());
    half[axis] = axis == length_axis ? random.Between(2, 8) : random.Between(0.05F, 0.2F);
  }
  return Around(center, half);
}

// Spawns a box around one of seven centres. There are eight objects per unit of volume around each.
Aabb SpawnCluster(SequentialRandom& random, const Slot& slot) {
  SequentialRandom cluster(slot.index % 7);  // the same for all boxes of a cluster
  const float spread = 0.13F * slot.WorldSide();
  float center[3];
  float half[3];
  for (int axis = 0; axis < 3; ++axis) {
    center[axis] = cluster.Between(0, 5 * slot.WorldSide()) + random.Between(-spread, spread);
    half[axis] = HalfExtent(random);
  }
  return Around(center, half);
}
void StepCluster(SequentialRandom& random, const Slot& slot, Aabb& box) {
  // Every 8 frames, each cluster gets a new direction, in which all its boxes move.
  SequentialRandom cluster(slot.index % 7 + 1000 * (slot.frame / 8));
  for (int axis = 0; axis < 3; ++axis) Shift(box, axis, cluster.Between(-0.5F, 0.5F));
  Jitter(random, 0.05F, box);
}

// Spawns one object per unit of area.
Aabb SpawnPlanar(SequentialRandom& random, const Slot& slot) {
  const float side = std::sqrt(static_cast<float>(slot.count));
  const float center[3] = {random.Between(0, side), 0.5F, random.Between(0, side)};
  const float half[3] = {HalfExtent(random), 0.5F, HalfExtent(random)};
  return Around(center, half);
}
void StepPlanar(SequentialRandom& random, const Slot&, Aabb& box) {
  Shift(box, 0, random.Between(-0.1F, 0.1F));
  Shift(box, 2, random.Between(-0.1F, 0.1F));
}

Aabb SpawnMixedSizes(SequentialRandom& random, const Slot& slot) {
  float center[3];
  float half[3];
  const auto size = static_cast<float>(0.005 * math::Pow(1000.0, random.Unit()));
  for (int axis = 0; axis < 3; ++axis) {
    center[axis] = random.Between(0, 2 * slot.WorldSide());
    half[axis] = size * random.Between(0.5F, 1.0F);
  }
  return Around(center, half);
}

// Spawns a box in one of two crowds that are 10,000 units apart on each axis.
Aabb SpawnFarCrowd(SequentialRandom& random, const Slot& slot) {
  const auto side = static_cast<float>(math::CubeRoot(static_cast<double>(slot.count) / 2));
  const float crowd = slot.index % 2 == 0 ? 0.0F : 10'000.0F;
  float center[3];
  float half[3];
  for (int axis = 0; axis < 3; ++axis) {
    center[axis] = crowd + random.Between(0, side);
    half[axis] = HalfExtent(random);
  }
  return Around(center, half);
}

// Spawns a box on the diagonal. Its distance and its size grow exponentially with its index, up to
// 10^9 times those of the first box.
Aabb SpawnExponential(SequentialRandom& random, const Slot& slot) {
  const double fraction = static_cast<double>(slot.index) / static_cast<double>(slot.count);
  const auto distance = static_cast<float>(math::Pow(1e9, fraction));
  const float size = 20 * distance / static_cast<float>(slot.count);  // to the next box, about
  const float center[3] = {distance, distance, distance};
  float half[3];
  for (float& extent : half) extent = size * random.Between(0.3F, 1.0F);
  return Around(center, half);
}
void StepExponential(SequentialRandom& random, const Slot&, Aabb& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const float reach = 0.05F * (box.max[axis] - box.min[axis]);
    Shift(box, axis, random.Between(-reach, reach));
  }
}

constexpr std::array kBoxKinds = {
    BoxKind{"brownian", SpawnScattered, StepBrownian},
    BoxKind{"nearly-resting", SpawnScattered, StepNearlyResting},
    BoxKind{"few-moving", SpawnScattered, StepFewMoving},
    BoxKind{"falling", SpawnScattered, StepFalling},
    BoxKind{"all-coincident", SpawnCoincident, StepCoincident},
    BoxKind{"all-disjoint", SpawnDisjoint, StepDisjoint},
    BoxKind{"touching-faces", SpawnTouching, StepTouching},
    BoxKind{"zero-size", SpawnZeroSize, StepZeroSize},
    BoxKind{"one-huge", SpawnOneHuge, StepBrownian},
    BoxKind{"coordinates-1e30", SpawnFar, StepFar},
    BoxKind{"float-limits", SpawnFloatLimits, StepFloatLimits},
    BoxKind{"signed-zeros", SpawnSignedZeros, StepSignedZeros},
    BoxKind{"teleporting", SpawnScattered, StepTeleporting},
    BoxKind{"broken-boxes", SpawnBroken, StepBroken},
    BoxKind{"long-thin", SpawnLongThin, StepBrownian},
    BoxKind{"beams", SpawnBeam, StepBrownian},
    BoxKind{"clusters", SpawnCluster, StepCluster},
    BoxKind{"planar", SpawnPlanar, StepPlanar},
    BoxKind{"sizes-1-to-1000", SpawnMixedSizes, StepBrownian},
    BoxKind{"far-crowds", SpawnFarCrowd, StepBrownian},
    BoxKind{"exponential-spacing", SpawnExponential, StepExponential},
};
// A mixture has the kinds before far-crowds only, because boxes far away would thin out the others.
constexpr size_t kMixedKinds = kBoxKinds.size() - 2;
constexpr std::string_view kMixture = "mixture";

size_t KindIndex(std::string_view name) {
  for (size_t i = 0; i < kBoxKinds.size(); ++i) {
    if (kBoxKinds[i].name == name) return i;
  }
  assert(false && "no kind of boxes has this name");
  return 0;
}

// A scene whose name differs from the kind of its boxes. `object_count`, if given, is the fixed
// number of objects.
struct Special {
  std::string_view name;
  std::string_view kind;
  std::optional<uint32_t> object_count;
};
constexpr std::string_view kCountChanging = "count-changing";
constexpr std::string_view kSpawning = "spawning";
constexpr Special kSpecials[] = {
    {"empty", "brownian", 0},       {"one", "brownian", 1},      {"two", "touching-faces", 2},
    {kCountChanging, kMixture, {}}, {kSpawning, "brownian", {}},
};

// Returns the number of objects in a frame. Over 32 frames it falls from `max` to half of it, over
// the next 32 it rises again, by `max`/64 per frame.
size_t SpawnedCount(size_t max, uint64_t frame) {
  const uint64_t phase = frame % 64;
  return max - max * (phase < 32 ? phase : 64 - phase) / 64;
}

class DegenerateScene : public Scene {
 public:
  DegenerateScene(std::string_view name, std::string_view kind, uint32_t object_count,
                  uint64_t seed)
      : name_(name), boxes_(kind, object_count, seed), counts_(seed), shown_(object_count) {}

  std::string_view name() const override { return name_; }
  Aabb world() const override { return {{-50, -50, -50}, {50, 50, 50}}; }
  uint64_t frame_index() const override { return frame_index_; }
  std::span<const Aabb> aabbs() const override { return boxes_.boxes().first(shown_); }
  size_t max_object_count() const override { return boxes_.boxes().size(); }
  void DoStep() override {
    ++frame_index_;
    boxes_.Step();
    if (name_ == kSpawning) shown_ = SpawnedCount(boxes_.boxes().size(), frame_index_);
    if (name_ == kCountChanging) {
      shown_ = frame_index_ % 7 == 3 ? 0 : counts_.Below(boxes_.boxes().size() + 1);
    }
  }

 private:
  std::string_view name_;
  BoxScene boxes_;
  SequentialRandom counts_;
  size_t shown_;
  uint64_t frame_index_ = 0;
};

}  // namespace

BoxScene::BoxScene(std::string_view kind, size_t count, uint64_t seed) : random_(seed) {
  for (size_t i = 0; i < count; ++i) {
    kinds_.push_back(kind == kMixture ? random_.Below(kMixedKinds) : KindIndex(kind));
    boxes_.push_back(kBoxKinds[kinds_[i]].spawn(random_, {i, count, 0}));
  }
}

void BoxScene::Step() {
  ++frame_;
  for (size_t i = 0; i < boxes_.size(); ++i) {
    kBoxKinds[kinds_[i]].step(random_, {i, boxes_.size(), frame_}, boxes_[i]);
  }
}

std::unique_ptr<Scene> MakeDegenerateScene(std::string_view name, uint32_t object_count,
                                           uint64_t seed) {
  std::string_view kind = name;
  for (const Special& special : kSpecials) {
    if (special.name != name) continue;
    kind = special.kind;
    object_count = special.object_count.value_or(object_count);
  }
  return std::make_unique<DegenerateScene>(name, kind, object_count, seed);
}

}  // namespace sweepstake
