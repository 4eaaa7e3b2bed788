#include "engine_client/scene/changing_scenes.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include "engine_client/math/portable_math.h"
#include "engine_client/scene/generated_scene.h"
#include "engine_client/scene/random.h"

namespace sweepstake {
namespace {

enum class Motion {
  kJitter,    // every axis moves by up to ±reach
  kMoveFew,   // in each frame, about one object in 100, drawn again, jitters
  kTeleport,  // in each frame, about one object in three jumps to a random place
  kFlow,      // each object moves straight on by up to reach per axis; walls reflect it
  kRotate,    // each object turns around the vertical axis at its own pace of up to reach radians
};

// What the objects do during a number of frames. Besides the motion, all distances from the middle
// of the world are multiplied by a factor, which changes linearly from `scale_begin` to
// `scale_end`.
struct Regime {
  Motion motion;
  float reach = 0;
  uint32_t shown_divisor = 1;  // only one in this many objects is shown
  bool count_changes = false;  // a 64th of the objects comes or goes in each frame
  float scale_begin = 1;
  float scale_end = 1;
};

constexpr Regime kRest{Motion::kJitter, 0};
constexpr Regime kNearRest{Motion::kJitter, 0.001F};
constexpr Regime kDrift{Motion::kJitter, 0.1F};
constexpr Regime kTeleport{Motion::kTeleport};
constexpr Regime kFlow{Motion::kFlow, 0.12F};
constexpr Regime kRotate{Motion::kRotate, 0.03F};
constexpr Regime kMoveFew{Motion::kMoveFew, 0.1F};
constexpr Regime kChangeCount{.motion = Motion::kJitter, .reach = 0.1F, .count_changes = true};

constexpr float kDenseScale = 0.6F;  // 4.6 objects per unit of volume
constexpr Regime kGather{.motion = Motion::kJitter, .reach = 0.05F, .scale_end = kDenseScale};
constexpr Regime kCamp{
    .motion = Motion::kJitter, .scale_begin = kDenseScale, .scale_end = kDenseScale};
constexpr Regime kScatter{.motion = Motion::kJitter, .reach = 0.05F, .scale_begin = kDenseScale};

constexpr uint32_t kFew = 60;  // as a shown_divisor: 50 of 3,000 objects are shown
constexpr Regime kFewDrift{.motion = Motion::kJitter, .reach = 0.1F, .shown_divisor = kFew};

constexpr std::array kRestAndMotion{kNearRest, kDrift};
constexpr std::array kWaves{kFewDrift, kTeleport, kNearRest};
constexpr std::array kStorms{kTeleport, kDrift};
constexpr std::array kGatherAndScatter{kGather, kCamp, kScatter, kRest};
constexpr std::array kDayAndNight{kRotate, kMoveFew};
constexpr std::array kArrivals{kChangeCount, kRest, kFlow};

struct ChangingKind {
  std::string_view name;
  uint32_t regime_frames;
  std::span<const Regime> regimes;
};

constexpr ChangingKind kChangingScenes[] = {
    {"rest-and-motion", 400, kRestAndMotion},
    {"waves", 400, kWaves},
    {"storms", 400, kStorms},
    {"gather-and-scatter", 300, kGatherAndScatter},
    {"day-and-night", 500, kDayAndNight},
    {"arrivals", 350, kArrivals},
};

struct Body {
  float place[3];     // the centre, before the world is scaled
  float half[3];      // the half extents
  float velocity[3];  // the motion per frame, as a fraction of the regime's reach
  float sine;         // the sine of the rotation per frame
  float cosine;       // the cosine of the rotation per frame
};

class ChangingScene : public Scene {
 public:
  ChangingScene(const ChangingKind& kind, uint32_t object_count, uint64_t seed,
                uint32_t regime_frames)
      : kind_(kind),
        regime_frames_(regime_frames == 0 ? kind.regime_frames : regime_frames),
        side_(static_cast<float>(math::CubeRoot(object_count))),
        kicks_(seed, SceneDraw::kKick),
        bodies_(object_count),
        boxes_(object_count) {
    Spawn(seed);
    shown_ = ShownCount();
    Show();
  }

  std::string_view name() const override { return kind_.name; }
  // The bounds are wider than the cube of the objects, because a rotation turns its corners
  // outwards.
  Aabb world() const override {
    const float low = -0.25F * side_;
    const float high = 1.25F * side_;
    return {{low, low, low}, {high, high, high}};
  }
  uint64_t frame_index() const override { return frame_index_; }
  std::span<const Aabb> aabbs() const override { return std::span(boxes_).first(shown_); }
  size_t max_object_count() const override { return boxes_.size(); }

  void DoStep() override {
    ++frame_index_;
    shown_ = ShownCount();
    for (uint32_t i = 0; i < shown_; ++i) Move(i, bodies_[i]);
    Show();
  }

 private:
  // Returns the index of the current regime. Frame 0 belongs to the first regime, and so do frames
  // 1 to regime_frames.
  uint64_t RegimeIndex() const {
    return frame_index_ == 0 ? 0 : (frame_index_ - 1) / regime_frames_;
  }
  const Regime& RegimeNow() const { return kind_.regimes[RegimeIndex() % kind_.regimes.size()]; }
  uint64_t FrameInRegime() const { return frame_index_ - RegimeIndex() * regime_frames_; }

  size_t ShownCount() const {
    const size_t max = bodies_.size();
    const Regime& regime = RegimeNow();
    if (regime.count_changes) {
      const uint64_t phase = FrameInRegime() % 64;
      return max - max * (phase < 32 ? phase : 64 - phase) / 64;
    }
    return max == 0 ? 0 : std::max<size_t>(1, max / regime.shown_divisor);
  }

  void Spawn(uint64_t seed) {
    const CounterRandom size(seed, SceneDraw::kSize);
    const CounterRandom place(seed, SceneDraw::kPosition);
    const CounterRandom velocity(seed, SceneDraw::kVelocity);
    for (uint32_t i = 0; i < bodies_.size(); ++i) {
      Body& body = bodies_[i];
      for (int axis = 0; axis < 3; ++axis) {
        body.half[axis] = static_cast<float>(0.145 * math::Pow(5.0, size.Unit(i, axis)));
        body.place[axis] = side_ * place.Unit(i, axis);
        body.velocity[axis] = velocity.Symmetric(i, axis);
      }
      const double pace = 0.3 + 0.7 * velocity.Unit(i, 3);
      body.sine = static_cast<float>(math::Sin(kRotate.reach * pace));
      body.cosine = static_cast<float>(math::Cos(kRotate.reach * pace));
    }
  }

  void Move(uint32_t object, Body& body) const {
    const Regime& regime = RegimeNow();
    const uint64_t draw = frame_index_ * 4;
    switch (regime.motion) {
      case Motion::kJitter:
        if (regime.reach > 0) Jitter(object, regime.reach, body);
        break;
      case Motion::kMoveFew:
        if (kicks_.Bits(object, draw + 3) % 100 == 0) Jitter(object, regime.reach, body);
        break;
      case Motion::kTeleport:
        if (kicks_.Bits(object, draw + 3) % 3 != 0) break;
        for (int axis = 0; axis < 3; ++axis) {
          body.place[axis] = side_ * kicks_.Unit(object, draw + static_cast<uint64_t>(axis));
        }
        break;
      case Motion::kFlow:
        Flow(regime.reach, body);
        break;
      case Motion::kRotate:
        Rotate(body);
        break;
    }
  }

  void Jitter(uint32_t object, float reach, Body& body) const {
    for (int axis = 0; axis < 3; ++axis) {
      const uint64_t draw = frame_index_ * 4 + static_cast<uint64_t>(axis);
      body.place[axis] =
          Reflect(body.place[axis] + reach * kicks_.Symmetric(object, draw), 0, side_);
    }
  }

  void Flow(float reach, Body& body) const {
    for (int axis = 0; axis < 3; ++axis) {
      const float next = body.place[axis] + reach * body.velocity[axis];
      if (next < 0 || next > side_) body.velocity[axis] = -body.velocity[axis];
      body.place[axis] = Reflect(next, 0, side_);
    }
  }

  void Rotate(Body& body) const {
    const float x = body.place[0] - 0.5F * side_;
    const float z = body.place[2] - 0.5F * side_;
    body.place[0] = 0.5F * side_ + (x * body.cosine - z * body.sine);
    body.place[2] = 0.5F * side_ + (x * body.sine + z * body.cosine);
  }

  float ScaleNow() const {
    const Regime& regime = RegimeNow();
    const float progress = static_cast<float>(FrameInRegime()) / static_cast<float>(regime_frames_);
    return regime.scale_begin + (regime.scale_end - regime.scale_begin) * progress;
  }

  void Show() {
    const float scale = ScaleNow();
    const float middle = 0.5F * side_;
    for (size_t i = 0; i < shown_; ++i) {
      const Body& body = bodies_[i];
      for (int axis = 0; axis < 3; ++axis) {
        const float centre = middle + (body.place[axis] - middle) * scale;
        boxes_[i].min[axis] = centre - body.half[axis];
        boxes_[i].max[axis] = centre + body.half[axis];
      }
    }
  }

  const ChangingKind& kind_;
  const uint32_t regime_frames_;
  const float side_;
  const CounterRandom kicks_;
  std::vector<Body> bodies_;
  std::vector<Aabb> boxes_;
  size_t shown_ = 0;
  uint64_t frame_index_ = 0;
};

const ChangingKind& Find(std::string_view name) {
  const auto* kind = std::find_if(std::begin(kChangingScenes), std::end(kChangingScenes),
                                  [&](const ChangingKind& each) { return each.name == name; });
  assert(kind != std::end(kChangingScenes));
  return *kind;
}

}  // namespace

std::unique_ptr<Scene> MakeChangingScene(std::string_view name, uint32_t object_count,
                                         uint64_t seed, uint32_t regime_frames) {
  return std::make_unique<ChangingScene>(Find(name), object_count, seed, regime_frames);
}

}  // namespace sweepstake
