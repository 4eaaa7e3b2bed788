#include "tests/laboratory/peers/peer.h"

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

namespace sweepstake::cli {
namespace {

btVector3 Corner(const float (&corner)[3]) { return {corner[0], corner[1], corner[2]}; }

// Bullet's user pointer holds the id itself.
// NOLINTNEXTLINE(performance-no-int-to-ptr)
void* AsUserPointer(size_t id) { return reinterpret_cast<void*>(id); }

uint32_t IdOf(const btBroadphaseProxy& proxy) {
  return static_cast<uint32_t>(reinterpret_cast<size_t>(proxy.m_clientObject));
}

// Returns whether the exact boxes of two proxies overlap. Bullet reports pairs of padded or
// quantized boxes, but each proxy stores its exact box.
bool BoxesMeet(const btBroadphaseProxy& a, const btBroadphaseProxy& b) {
  return a.m_aabbMin.x() <= b.m_aabbMax.x() && b.m_aabbMin.x() <= a.m_aabbMax.x() &&
         a.m_aabbMin.y() <= b.m_aabbMax.y() && b.m_aabbMin.y() <= a.m_aabbMax.y() &&
         a.m_aabbMin.z() <= b.m_aabbMax.z() && b.m_aabbMin.z() <= a.m_aabbMax.z();
}

void AppendIfMeeting(const btBroadphaseProxy& a, const btBroadphaseProxy& b, PairBuffer& out) {
  if (BoxesMeet(a, b)) AppendPair(out, IdOf(a), IdOf(b));
}

// Collects the pairs of the tree in its deferred mode. That mode reports all pairs in every frame,
// so Bullet's usual hash table of pairs would only cost time.
class PairCollector final : public btNullPairCache {
 public:
  void CollectInto(PairBuffer& out) { out_ = &out; }

  btBroadphasePair* addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override {
    AppendIfMeeting(*a, *b, *out_);
    return nullptr;
  }

 private:
  PairBuffer* out_ = nullptr;
};

// The base of all Bullet peers: it creates, moves and destroys the proxies.
class BulletPeer : public Peer {
 public:
  explicit BulletPeer(std::string_view name) : Peer(name) {}

  void DoBuild(std::span<const Aabb> boxes) override {
    Discard();
    broadphase_ = MakeBroadphase(boxes);
    for (const Aabb& box : boxes) Add(box);
  }

  void DoUpdate(std::span<const Aabb> boxes) override {
    if (boxes.size() > max_proxies()) return DoBuild(boxes);
    while (proxies_.size() > boxes.size()) RemoveLast();
    for (size_t i = 0; i < proxies_.size(); ++i) {
      broadphase_->setAabb(proxies_[i], Corner(boxes[i].min), Corner(boxes[i].max), nullptr);
    }
    for (const Aabb& box : boxes.subspan(proxies_.size())) Add(box);
  }

  // Appends the pairs whose exact boxes overlap. Bullet's pair cache also contains outdated pairs
  // and pairs of padded boxes.
  void DoFindPairs(PairBuffer& out) override {
    broadphase_->calculateOverlappingPairs(nullptr);
    const btBroadphasePairArray& pairs =
        broadphase_->getOverlappingPairCache()->getOverlappingPairArray();
    for (int i = 0; i < pairs.size(); ++i) {
      AppendIfMeeting(*pairs[i].m_pProxy0, *pairs[i].m_pProxy1, out);
    }
  }

 protected:
  virtual std::unique_ptr<btBroadphaseInterface> MakeBroadphase(std::span<const Aabb> boxes) = 0;
  virtual size_t max_proxies() const { return UINT32_MAX; }

  btBroadphaseInterface* broadphase() { return broadphase_.get(); }

  // Drops the pairs before the proxies. Otherwise the removal of each proxy would search all
  // remaining pairs.
  void Discard() {
    if (broadphase_ == nullptr) return;
    broadphase_->getOverlappingPairCache()->getOverlappingPairArray().clear();
    if (owns_proxies()) {
      while (!proxies_.empty()) RemoveLast();
    }
    proxies_.clear();
    broadphase_.reset();
  }

  // Returns false if the broad phase allocates all proxies in one block.
  virtual bool owns_proxies() const { return true; }

 private:
  // Sets the exact box of the new proxy, since btAxisSweep3 sets it only when a proxy moves.
  void Add(const Aabb& box) {
    constexpr int kAnyShape = 0;
    btBroadphaseProxy* const proxy = broadphase_->createProxy(
        Corner(box.min), Corner(box.max), kAnyShape, AsUserPointer(proxies_.size()), 1, 1, nullptr);
    proxy->m_aabbMin = Corner(box.min);
    proxy->m_aabbMax = Corner(box.max);
    proxies_.push_back(proxy);
  }

  void RemoveLast() {
    broadphase_->destroyProxy(proxies_.back(), nullptr);
    proxies_.pop_back();
  }

  std::unique_ptr<btBroadphaseInterface> broadphase_;
  std::vector<btBroadphaseProxy*> proxies_;
};

// Bullet's tree as its world uses it: an object that leaves its padded box is tested against the
// tree at once, and a hash table keeps the pairs. An object at rest costs one comparison of its
// box.
class DbvtPeer final : public BulletPeer {
 public:
  using BulletPeer::BulletPeer;
  ~DbvtPeer() override { Discard(); }

 protected:
  std::unique_ptr<btBroadphaseInterface> MakeBroadphase(std::span<const Aabb>) override {
    return std::make_unique<btDbvtBroadphase>();
  }
};

// Bullet's tree in its deferred mode: it is tested against itself once per frame, which is faster
// if many objects move.
class DeferredDbvtPeer final : public BulletPeer {
 public:
  using BulletPeer::BulletPeer;
  ~DeferredDbvtPeer() override { Discard(); }

  void DoFindPairs(PairBuffer& out) override {
    collector_.CollectInto(out);
    broadphase()->calculateOverlappingPairs(nullptr);
  }

 protected:
  std::unique_ptr<btBroadphaseInterface> MakeBroadphase(std::span<const Aabb>) override {
    auto tree = std::make_unique<btDbvtBroadphase>(&collector_);
    tree->m_deferedcollide = true;
    return tree;
  }

 private:
  PairCollector collector_;
};

// Bullet's sweep along three sorted axes in quantized coordinates. `Sweep` owns the proxies.
template <typename Sweep, typename Handle, size_t kMaxHandles>
class AxisSweepPeer final : public BulletPeer {
 public:
  using BulletPeer::BulletPeer;
  ~AxisSweepPeer() override { Discard(); }

 protected:
  std::unique_ptr<btBroadphaseInterface> MakeBroadphase(std::span<const Aabb> boxes) override {
    const Aabb world = RoomyBounds(boxes);
    max_proxies_ = std::min(kMaxHandles, 2 * boxes.size() + 1024);
    constexpr bool kNoRayTree = true;
    return std::make_unique<Sweep>(Corner(world.min), Corner(world.max),
                                   static_cast<Handle>(max_proxies_), nullptr, kNoRayTree);
  }
  size_t max_proxies() const override { return max_proxies_; }
  bool owns_proxies() const override { return false; }

 private:
  size_t max_proxies_ = 0;
};

constexpr size_t kMax16BitHandles = 16'000;
using AxisSweep16Peer = AxisSweepPeer<btAxisSweep3, unsigned short, kMax16BitHandles>;
using AxisSweep32Peer = AxisSweepPeer<bt32BitAxisSweep3, unsigned int, 1'000'000>;

}  // namespace

void AddBulletPeers(PeerLibrary& library) {
  // The maximum object count. Building is quadratic, because each new object is moved to its place
  // along three axes.
  constexpr uint32_t kMaxInSweep = 30'000;
  library.version =
      std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
  library.kinds = {
      {"BulletAxisSweep3", "AxisSweep", kMax16BitHandles, false, MakePeer<AxisSweep16Peer>},
      {"Bullet32BitAxisSweep3", "AxisSweep", kMaxInSweep, false, MakePeer<AxisSweep32Peer>},
      {"BulletDbvt", "DBVT", 200'000, false, MakePeer<DbvtPeer>},
      {"BulletDbvtDeferred", "DBVT", 1'000'000, false, MakePeer<DeferredDbvtPeer>},
  };
}

}  // namespace sweepstake::cli
