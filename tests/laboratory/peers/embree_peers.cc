#include "tests/laboratory/peers/peer.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <atomic>

namespace sweepstake::cli {
namespace {

// The boxes of a frame and the pairs found in it. Embree calls back on all of its threads, so an
// atomic counter assigns each pair its slot.
struct Collision {
  std::span<const Aabb> boxes;
  std::vector<OverlapPair> slots;
  std::atomic<size_t> found{0};
};

void Bound(const RTCBoundsFunctionArguments* arguments) {
  const Aabb& box =
      static_cast<const Collision*>(arguments->geometryUserPtr)->boxes[arguments->primID];
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = box.min[0];
  bounds.lower_y = box.min[1];
  bounds.lower_z = box.min[2];
  bounds.upper_x = box.max[0];
  bounds.upper_y = box.max[1];
  bounds.upper_z = box.max[2];
}

// The callback for pairs of leaves. If a scene is tested against itself, Embree reports each pair
// in both orders.
void Collide(void* opaque, RTCCollision* collisions, unsigned int count) {
  auto& collision = *static_cast<Collision*>(opaque);
  OverlapPair pairs[64];
  for (unsigned begin = 0; begin < count; begin += 64) {
    size_t kept = 0;
    for (unsigned i = begin; i < std::min(count, begin + 64); ++i) {
      const uint32_t a = collisions[i].primID0;
      const uint32_t b = collisions[i].primID1;
      if (a < b && ValidBoxesOverlap(collision.boxes[a], collision.boxes[b])) {
        pairs[kept++] = {a, b};
      }
    }
    const size_t first = collision.found.fetch_add(kept, std::memory_order_relaxed);
    if (first + kept <= collision.slots.size()) {
      std::copy(pairs, pairs + kept, collision.slots.data() + first);
    }
  }
}

class EmbreePeer final : public Peer {
 public:
  EmbreePeer(std::string_view name, uint32_t thread_count, RTCBuildQuality quality)
      : Peer(name), quality_(quality) {
    device_ = rtcNewDevice(("threads=" + std::to_string(thread_count)).c_str());
    if (device_ == nullptr) throw std::bad_alloc();
  }
  ~EmbreePeer() override {
    Discard();
    rtcReleaseDevice(device_);
  }

  void DoBuild(std::span<const Aabb> boxes) override {
    Discard();
    count_ = boxes.size();
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
    geometry_ = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryBuildQuality(geometry_, quality_);
    rtcSetGeometryUserPrimitiveCount(geometry_, static_cast<unsigned>(boxes.size()));
    rtcSetGeometryUserData(geometry_, &collision_);
    rtcSetGeometryBoundsFunction(geometry_, Bound, nullptr);
    rtcAttachGeometry(scene_, geometry_);
    Commit(boxes);
  }

  void DoUpdate(std::span<const Aabb> boxes) override {
    if (boxes.size() != count_) return DoBuild(boxes);
    Commit(boxes);
  }

  void DoFindPairs(PairBuffer& out) override {
    if (count_ == 0) return;
    size_t found = CollideAll();
    if (found > collision_.slots.size()) {
      collision_.slots.resize(2 * found);
      found = CollideAll();
    }
    std::copy_n(collision_.slots.data(), found, out.EnsureRoom(found));
    out.Advance(found);
  }

 private:
  // Embree reads the boxes until FindPairs has ended, so the peer keeps a copy.
  void Commit(std::span<const Aabb> boxes) {
    boxes_.assign(boxes.begin(), boxes.end());
    collision_.boxes = boxes_;
    rtcCommitGeometry(geometry_);
    rtcCommitScene(scene_);
  }

  size_t CollideAll() {
    collision_.found = 0;
    rtcCollide(scene_, scene_, Collide, &collision_);
    return collision_.found;
  }

  void Discard() {
    if (scene_ == nullptr) return;
    rtcReleaseGeometry(geometry_);
    rtcReleaseScene(scene_);
    scene_ = nullptr;
  }

  RTCBuildQuality quality_;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  RTCGeometry geometry_ = nullptr;
  size_t count_ = 0;
  std::vector<Aabb> boxes_;
  Collision collision_;
};

template <RTCBuildQuality kQuality>
std::unique_ptr<Peer> Make(std::string_view name, uint32_t thread_count) {
  return std::make_unique<EmbreePeer>(name, thread_count, kQuality);
}

}  // namespace

void AddEmbreePeers(PeerLibrary& library) {
  library.version = RTC_VERSION_STRING;
  // Low build quality is the fastest if all boxes move. Refitting is faster for about 1,000 objects
  // or if few objects move, but slows down as the tree ages.
  library.kinds = {
      {"Embree", "KDTree", 10'000'000, true, Make<RTC_BUILD_QUALITY_LOW>},
      {"EmbreeRefit", "KDTree", 10'000'000, true, Make<RTC_BUILD_QUALITY_REFIT>},
  };
}

}  // namespace sweepstake::cli
