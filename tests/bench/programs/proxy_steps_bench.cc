// Measures a complete step of a game's broad phase as ratios that `judge.py proxies` compares with
// goals.toml. 10,000 boxes of suite-b move, all pairs are found, and 10,000 rays are cast for their
// nearest hit. Each arm with a ProxySet is compared with Bullet's tree and Embree in the same run.
// Prints one JSON document; `--quick` makes everything small.
//
// The contestants take turns frame by frame in a rotating order. They are compared by their fastest
// frames, because other programs can only slow a frame down. In each frame all arms must find the
// same pairs and hits. Embree must find equally many pairs, and Bullet, whose boxes are larger, at
// least as many. Their numbers of hits may differ by one in a thousand. Otherwise the run fails.
// Embree uses one thread. Rays end after 20 units.
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "engine_client/scene/random.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/proxy_set.h"
#include "sweepstake/scene.h"

namespace sweepstake {
namespace {

constexpr float kRayLength = 20;

// One side of the comparison.
class Contestant {
 public:
  explicit Contestant(std::string name) : name_(std::move(name)) {}
  virtual ~Contestant() = default;
  // Moves the boxes, finds all pairs and casts all rays.
  virtual void Step(std::span<const Aabb> boxes, std::span<const Ray> rays) = 0;

  void TimeStep(std::span<const Aabb> boxes, std::span<const Ray> rays) {
    hit_count = 0;
    const auto start = std::chrono::steady_clock::now();
    Step(boxes, rays);
    const std::chrono::duration<double, std::milli> taken =
        std::chrono::steady_clock::now() - start;
    fastest_ms = std::min(fastest_ms, taken.count());
  }

  const std::string& name() const { return name_; }
  double fastest_ms = std::numeric_limits<double>::infinity();
  size_t pair_count = 0;
  size_t hit_count = 0;

 private:
  std::string name_;
};

class Arm final : public Contestant {
 public:
  Arm(std::string name, std::span<const Aabb> boxes)
      : Contestant(name), backend_(std::move(*MakeBroadPhase(name))), handles_(boxes.size()) {
    const ProxyOptions options;
    proxies_.AddMany(boxes, std::span(&options, 1), handles_);
    backend_->Build(proxies_.moving_boxes());
  }

  void Step(std::span<const Aabb> boxes, std::span<const Ray> rays) override {
    proxies_.Move(handles_, boxes);
    backend_->Update(proxies_.moving_boxes());
    pairs_.Clear();
    backend_->FindPairs(pairs_);
    pair_count = proxies_.Resolve(pairs_.pairs()).size();
    proxies_.PrepareQueries();
    hits_.resize(rays.size());
    if (!std::as_const(proxies_).CastRays(rays, {}, hits_).ok()) return;
    for (const RayHit& hit : hits_) hit_count += hit.proxy.is_null() ? 0 : 1;
  }

 private:
  ProxySet proxies_;
  std::unique_ptr<BroadPhase> backend_;
  std::vector<ProxyHandle> handles_;
  std::vector<RayHit> hits_;
  PairBuffer pairs_;
};

// Returns the distance at which the ray enters the box, or infinity.
float EnterAt(const float* origin, const float* direction, const float* min, const float* max) {
  float enter = 0;
  float leave = kRayLength;
  for (int axis = 0; axis < 3; ++axis) {
    const float a = (min[axis] - origin[axis]) / direction[axis];
    const float b = (max[axis] - origin[axis]) / direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : std::numeric_limits<float>::infinity();
}

btVector3 Vector(const float* v) { return {v[0], v[1], v[2]}; }

// Finds the distance of the nearest hit. Bullet calls `process` for each box along the ray.
struct NearestOfBullet final : btBroadphaseRayCallback {
  const Ray* ray = nullptr;
  float nearest = std::numeric_limits<float>::infinity();

  explicit NearestOfBullet(const Ray& cast) : ray(&cast) {
    for (int axis = 0; axis < 3; ++axis) {
      m_rayDirectionInverse[axis] = 1 / cast.direction[axis];
      m_signs[axis] = cast.direction[axis] < 0 ? 1 : 0;
    }
    m_lambda_max = kRayLength;
  }
  bool process(const btBroadphaseProxy* proxy) override {
    nearest =
        std::min(nearest, EnterAt(ray->origin, ray->direction, proxy->m_aabbMin, proxy->m_aabbMax));
    return true;
  }
};

class Bullet final : public Contestant {
 public:
  explicit Bullet(std::span<const Aabb> boxes) : Contestant("Bullet") {
    for (const Aabb& box : boxes) {
      proxies_.push_back(
          tree_.createProxy(Vector(box.min), Vector(box.max), 0, nullptr, 1, -1, nullptr));
    }
  }
  ~Bullet() override {
    for (btBroadphaseProxy* proxy : proxies_) tree_.destroyProxy(proxy, nullptr);
  }

  void Step(std::span<const Aabb> boxes, std::span<const Ray> rays) override {
    for (size_t k = 0; k < boxes.size(); ++k) {
      tree_.setAabb(proxies_[k], Vector(boxes[k].min), Vector(boxes[k].max), nullptr);
    }
    tree_.calculateOverlappingPairs(nullptr);
    pair_count = static_cast<size_t>(tree_.getOverlappingPairCache()->getNumOverlappingPairs());
    for (const Ray& ray : rays) {
      NearestOfBullet callback(ray);
      const btVector3 from = Vector(ray.origin);
      tree_.rayTest(from, from + kRayLength * Vector(ray.direction), callback);
      hit_count += callback.nearest <= kRayLength ? 1 : 0;
    }
  }

 private:
  btDbvtBroadphase tree_;
  std::vector<btBroadphaseProxy*> proxies_;
};

void Bound(const RTCBoundsFunctionArguments* arguments) {
  const Aabb& box = static_cast<const Aabb*>(arguments->geometryUserPtr)[arguments->primID];
  *arguments->bounds_o = {box.min[0], box.min[1], box.min[2], 0,
                          box.max[0], box.max[1], box.max[2], 0};
}

void Intersect(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  auto* const hit = reinterpret_cast<RTCRayHit*>(arguments->rayhit);
  const Aabb& box = static_cast<const Aabb*>(arguments->geometryUserPtr)[arguments->primID];
  const float at = EnterAt(&hit->ray.org_x, &hit->ray.dir_x, box.min, box.max);
  if (at >= hit->ray.tfar) return;
  hit->ray.tfar = at;
  hit->hit.geomID = arguments->geomID;
  hit->hit.primID = arguments->primID;
}

class Embree final : public Contestant {
 public:
  explicit Embree(std::span<const Aabb> boxes)
      : Contestant("Embree"), boxes_(boxes.begin(), boxes.end()) {
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
    rtcSetGeometryBuildQuality(geometry_, RTC_BUILD_QUALITY_LOW);
    rtcSetGeometryUserPrimitiveCount(geometry_, static_cast<unsigned>(boxes_.size()));
    rtcSetGeometryUserData(geometry_, boxes_.data());
    rtcSetGeometryBoundsFunction(geometry_, Bound, nullptr);
    rtcSetGeometryIntersectFunction(geometry_, Intersect);
    rtcAttachGeometry(scene_, geometry_);
  }
  ~Embree() override {
    rtcReleaseGeometry(geometry_);
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  void Step(std::span<const Aabb> boxes, std::span<const Ray> rays) override {
    std::copy(boxes.begin(), boxes.end(), boxes_.begin());
    rtcCommitGeometry(geometry_);
    rtcCommitScene(scene_);
    pair_count = 0;
    rtcCollide(scene_, scene_, CountPairs, this);
    for (const Ray& ray : rays) Cast(ray);
  }

 private:
  // Embree reports pairs of leaves in both orders.
  static void CountPairs(void* self, RTCCollision* collisions, unsigned count) {
    auto& embree = *static_cast<Embree*>(self);
    for (unsigned k = 0; k < count; ++k) {
      const unsigned a = collisions[k].primID0;
      const unsigned b = collisions[k].primID1;
      embree.pair_count += a < b && Overlap(embree.boxes_[a], embree.boxes_[b]) ? 1 : 0;
    }
  }

  void Cast(const Ray& ray) {
    RTCRayHit hit{};
    std::copy_n(ray.origin, 3, &hit.ray.org_x);
    std::copy_n(ray.direction, 3, &hit.ray.dir_x);
    hit.ray.tfar = kRayLength;
    hit.ray.mask = ~0U;
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene_, &hit, nullptr);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &hit);
#endif
    hit_count += hit.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
  }

  std::vector<Aabb> boxes_;
  RTCDevice device_ = rtcNewDevice("threads=1");
  RTCScene scene_ = rtcNewScene(device_);
  RTCGeometry geometry_ = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
};

std::vector<Ray> AnyRays(size_t count, const std::vector<Aabb>& boxes) {
  SequentialRandom random(2);
  std::vector<Ray> rays(count);
  for (Ray& ray : rays) {
    const Aabb& from = boxes[random.Below(boxes.size())];
    for (int axis = 0; axis < 3; ++axis) {
      ray.origin[axis] = from.max[axis] + 0.01F;
      ray.direction[axis] = random.Symmetric() + 0.0001F;
    }
    ray.max_distance = kRayLength;
  }
  return rays;
}

// Indices in the list of contestants.
constexpr size_t kBullet = 0;
constexpr size_t kEmbree = 1;
constexpr size_t kFirstArm = 2;

void Print(const std::vector<std::unique_ptr<Contestant>>& contestants) {
  double slowest_arm = 0;
  std::printf("{\"command\": \"proxy_steps_bench\"");
  for (size_t k = 0; k < contestants.size(); ++k) {
    const Contestant& one = *contestants[k];
    if (k >= kFirstArm) slowest_arm = std::max(slowest_arm, one.fastest_ms);
    std::printf(",\n  \"%s_step_ms\": %.4f", one.name().c_str(), one.fastest_ms);
    std::fprintf(stderr, "%s: %zu pairs, %zu rays hit\n", one.name().c_str(), one.pair_count,
                 one.hit_count);
  }
  std::printf(",\n  \"slowest_arm_to_bullet_ratio\": %.4f",
              slowest_arm / contestants[kBullet]->fastest_ms);
  std::printf(",\n  \"slowest_arm_to_embree_ratio\": %.4f\n}\n",
              slowest_arm / contestants[kEmbree]->fastest_ms);
}

// Returns whether all contestants found as many pairs and hits as necessary. The peers' trees round
// differently along a ray, so their number of hits may differ by one in a thousand.
bool Agree(const std::vector<std::unique_ptr<Contestant>>& contestants) {
  const Contestant& arm = *contestants[kFirstArm];
  const size_t tolerated = arm.hit_count / 1000;
  for (size_t k = 0; k < contestants.size(); ++k) {
    const Contestant& one = *contestants[k];
    const bool pairs =
        k == kBullet ? one.pair_count >= arm.pair_count : one.pair_count == arm.pair_count;
    const bool hits = k >= kFirstArm ? one.hit_count == arm.hit_count
                                     : one.hit_count + tolerated >= arm.hit_count &&
                                           one.hit_count <= arm.hit_count + tolerated;
    if (pairs && hits) continue;
    std::fprintf(stderr, "%s finds %zu pairs and %zu hits, %s %zu and %zu\n", one.name().c_str(),
                 one.pair_count, one.hit_count, arm.name().c_str(), arm.pair_count, arm.hit_count);
    return false;
  }
  return true;
}

// Measures all contestants; returns whether their results agree.
bool Measure(uint32_t object_count, int frames) {
  SceneOptions options;
  options.object_count = object_count;
  const auto scene = std::move(*MakeScene("suite-b", options));
  std::vector<std::unique_ptr<Contestant>> contestants;
  contestants.push_back(std::make_unique<Bullet>(scene->aabbs()));
  contestants.push_back(std::make_unique<Embree>(scene->aabbs()));
  for (const std::string_view name : BroadPhaseNames()) {
    contestants.push_back(std::make_unique<Arm>(std::string(name), scene->aabbs()));
  }
  for (int frame = 0; frame < frames; ++frame) {
    scene->Step();
    const std::vector<Aabb> boxes(scene->aabbs().begin(), scene->aabbs().end());
    const std::vector<Ray> rays = AnyRays(object_count, boxes);
    for (size_t k = 0; k < contestants.size(); ++k) {
      contestants[(static_cast<size_t>(frame) + k) % contestants.size()]->TimeStep(boxes, rays);
    }
    if (!Agree(contestants)) return false;
  }
  Print(contestants);
  return true;
}

}  // namespace
}  // namespace sweepstake

int main(int argc, char** argv) {
  const bool quick = argc == 2 && std::strcmp(argv[1], "--quick") == 0;
  if (argc > 1 && !quick) {
    std::fprintf(stderr, "Usage: proxy_steps_bench [--quick]\n");
    return 2;
  }
  return sweepstake::Measure(quick ? 300 : 10'000, quick ? 3 : 40) ? 0 : 1;
}
