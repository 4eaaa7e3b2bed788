#include "engine_client/scene/changing_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <string>
#include <vector>

#include "engine_client/scene/counter_random.h"
#include "engine_client/scene/generated_scene.h"
#include "engine_client/scene/portable_math.h"
#include "engine_client/scene/scene_options.h"

namespace sweepstake {
namespace {

enum class Motion {
  kJitter,    // every axis by up to ±reach
  kStir,      // one object in a hundred jitters, another one in each frame
  kScramble,  // one object in three jumps to any place
  kFlow,      // straight on, up to reach per axis, back from the walls
  kSwirl,     // round the vertical axis, each object at its own pace, up to reach radians
};

// How the objects behave for a while. `from` and `to`: what all distances from the middle of the
// world are multiplied with at the begin and at the end.
struct Regime {
  Motion motion;
  float reach = 0;
  uint32_t shown_divisor = 1;  // one object in so many is there
  bool churns = false;         // a 64th of the objects comes or goes in each frame
  float from = 1;
  float to = 1;
};

constexpr Regime kRest{Motion::kJitter, 0};
constexpr Regime kNearRest{Motion::kJitter, 0.001F};
constexpr Regime kDrift{Motion::kJitter, 0.1F};
constexpr Regime kScramble{Motion::kScramble};
constexpr Regime kFlow{Motion::kFlow, 0.12F};
constexpr Regime kSwirl{Motion::kSwirl, 0.03F};
constexpr Regime kStir{Motion::kStir, 0.1F};
constexpr Regime kChurn{.motion = Motion::kJitter, .reach = 0.1F, .churns = true};

constexpr float kCrowd = 0.6F;  // 4.6 objects per unit of volume
constexpr Regime kGather{.motion = Motion::kJitter, .reach = 0.05F, .to = kCrowd};
constexpr Regime kCamp{.motion = Motion::kJitter, .from = kCrowd, .to = kCrowd};
constexpr Regime kScatter{.motion = Motion::kJitter, .reach = 0.05F, .from = kCrowd};

constexpr uint32_t kFew = 60;  // 50 of 3,000
constexpr Regime kFewDrift{.motion = Motion::kJitter, .reach = 0.1F, .shown_divisor = kFew};

constexpr std::array kRestAndMotion{kNearRest, kDrift};
constexpr std::array kWaves{kFewDrift, kScramble, kNearRest};
constexpr std::array kStorms{kScramble, kDrift};
constexpr std::array kGatherAndScatter{kGather, kCamp, kScatter, kRest};
constexpr std::array kDayAndNight{kSwirl, kStir};
constexpr std::array kArrivals{kChurn, kRest, kFlow};

struct Kind {
  std::string_view name;
  uint32_t regime_frames;
  std::span<const Regime> regimes;
};

constexpr Kind kKinds[] = {
    {"rest-and-motion", 400, kRestAndMotion},
    {"waves", 400, kWaves},
    {"storms", 400, kStorms},
    {"gather-and-scatter", 300, kGatherAndScatter},
    {"day-and-night", 500, kDayAndNight},
    {"arrivals", 350, kArrivals},
};

constexpr auto kNames = [] {
  std::array<std::string_view, std::size(kKinds)> names;
  for (size_t i = 0; i < names.size(); ++i) names[i] = kKinds[i].name;
  return names;
}();

struct Body {
  float place[3];     // of the centre, before the world shrinks
  float half[3];      // extents
  float velocity[3];  // per frame, as a share of a regime's reach
  float sine;         // of the swirl's step
  float cosine;
};

class ChangingScene : public Scene {
 public:
  ChangingScene(const Kind& kind, uint32_t object_count, uint64_t seed, uint32_t regime_frames)
      : kind_(kind),
        regime_frames_(regime_frames == 0 ? kind.regime_frames : regime_frames),
        side_(static_cast<float>(portable::CubeRoot(object_count))),
        kicks_(seed, RandomStream::kKick),
        bodies_(object_count),
        boxes_(object_count) {
    Spawn(seed);
    shown_ = ShownCount();
    Show();
  }

  std::string_view name() const override { return kind_.name; }
  // The swirl turns corners out of the cube.
  Aabb world() const override {
    const float low = -0.25F * side_;
    const float high = 1.25F * side_;
    return {{low, low, low}, {high, high, high}};
  }
  uint64_t frame_index() const override { return frame_index_; }
  std::span<const Aabb> aabbs() const override { return std::span(boxes_).first(shown_); }

  void Step() override {
    ++frame_index_;
    shown_ = ShownCount();
    for (uint32_t i = 0; i < shown_; ++i) Move(i, bodies_[i]);
    Show();
  }

 private:
  // Frame 0 belongs to the first regime, and frame regime_frames is its last one.
  uint64_t RegimeIndex() const {
    return frame_index_ == 0 ? 0 : (frame_index_ - 1) / regime_frames_;
  }
  const Regime& RegimeNow() const { return kind_.regimes[RegimeIndex() % kind_.regimes.size()]; }
  uint64_t FrameInRegime() const { return frame_index_ - RegimeIndex() * regime_frames_; }

  size_t ShownCount() const {
    const size_t most = bodies_.size();
    const Regime& regime = RegimeNow();
    if (regime.churns) {
      const uint64_t phase = FrameInRegime() % 64;
      return most - most * (phase < 32 ? phase : 64 - phase) / 64;
    }
    return most == 0 ? 0 : std::max<size_t>(1, most / regime.shown_divisor);
  }

  void Spawn(uint64_t seed) {
    const CounterRandom size(seed, RandomStream::kSize);
    const CounterRandom place(seed, RandomStream::kPosition);
    const CounterRandom velocity(seed, RandomStream::kVelocity);
    for (uint32_t i = 0; i < bodies_.size(); ++i) {
      Body& body = bodies_[i];
      for (int axis = 0; axis < 3; ++axis) {
        body.half[axis] = static_cast<float>(0.145 * portable::Pow(5.0, size.Unit(i, axis)));
        body.place[axis] = side_ * place.Unit(i, axis);
        body.velocity[axis] = velocity.Symmetric(i, axis);
      }
      const double pace = 0.3 + 0.7 * velocity.Unit(i, 3);
      body.sine = static_cast<float>(portable::Sin(kSwirl.reach * pace));
      body.cosine = static_cast<float>(portable::Cos(kSwirl.reach * pace));
    }
  }

  void Move(uint32_t object, Body& body) const {
    const Regime& regime = RegimeNow();
    const uint64_t draw = frame_index_ * 4;
    switch (regime.motion) {
      case Motion::kJitter:
        if (regime.reach > 0) Jitter(object, regime.reach, body);
        break;
      case Motion::kStir:
        if (kicks_.Bits(object, draw + 3) % 100 == 0) Jitter(object, regime.reach, body);
        break;
      case Motion::kScramble:
        if (kicks_.Bits(object, draw + 3) % 3 != 0) break;
        for (int axis = 0; axis < 3; ++axis) {
          body.place[axis] = side_ * kicks_.Unit(object, draw + static_cast<uint64_t>(axis));
        }
        break;
      case Motion::kFlow:
        Flow(regime.reach, body);
        break;
      case Motion::kSwirl:
        Swirl(body);
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

  void Swirl(Body& body) const {
    const float x = body.place[0] - 0.5F * side_;
    const float z = body.place[2] - 0.5F * side_;
    body.place[0] = 0.5F * side_ + (x * body.cosine - z * body.sine);
    body.place[2] = 0.5F * side_ + (x * body.sine + z * body.cosine);
  }

  float ScaleNow() const {
    const Regime& regime = RegimeNow();
    const float way = static_cast<float>(FrameInRegime()) / static_cast<float>(regime_frames_);
    return regime.from + (regime.to - regime.from) * way;
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

  const Kind& kind_;
  const uint32_t regime_frames_;
  const float side_;
  const CounterRandom kicks_;
  std::vector<Body> bodies_;
  std::vector<Aabb> boxes_;
  size_t shown_ = 0;
  uint64_t frame_index_ = 0;
};

const Kind* Find(std::string_view name) {
  const auto* kind = std::find_if(std::begin(kKinds), std::end(kKinds),
                                  [&](const Kind& each) { return each.name == name; });
  return kind == std::end(kKinds) ? nullptr : kind;
}

Status UnknownName(std::string_view name) {
  std::string message = "no changing scene is called '" + std::string(name) + "'; choose one of ";
  for (const std::string_view each : kNames) {
    if (each != kNames.front()) message += ", ";
    message += each;
  }
  return {StatusCode::kNotFound, std::move(message)};
}

}  // namespace

std::span<const std::string_view> ChangingSceneNames() { return kNames; }

uint32_t RegimeFrames(std::string_view name) { return Find(name)->regime_frames; }

Result<std::unique_ptr<Scene>> MakeChangingScene(std::string_view name, uint32_t object_count,
                                                 uint64_t seed, uint32_t regime_frames) {
  const Kind* kind = Find(name);
  if (kind == nullptr) return UnknownName(name);
  if (Status status = ValidateObjectCount(object_count); !status.ok()) return status;
  try {
    return std::unique_ptr<Scene>(
        std::make_unique<ChangingScene>(*kind, object_count, seed, regime_frames));
  } catch (const std::bad_alloc&) {
    return Status(StatusCode::kResourceExhausted,
                  "not enough memory for the scene: choose a smaller object_count");
  }
}

}  // namespace sweepstake
