// The proxies of one kind, moving or static, and the tree in which queries find them.
//
// Thread safety: const calls may run side by side, and so may RefreshTree if nothing has changed
// since the last one. Owns its memory. Cost and memory: see proxy_table.h and box_tree.h. Errors:
// std::bad_alloc; the next RefreshTree then tries again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine_client/broad_phase/proxies/box_tree.h"
#include "engine_client/broad_phase/proxies/proxy_table.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

class ProxyKind {
 public:
  // `id_bit` is set in the ids of all proxies of this kind.
  explicit ProxyKind(uint32_t id_bit) : id_bit_(id_bit) {}

  ProxyTable& table() { return table_; }
  const ProxyTable& table() const { return table_; }
  // Returns null if the place is free.
  ProxyHandle HandleAt(uint32_t place) const {
    const uint32_t generation = table_.generation(place);
    return generation == 0 ? ProxyHandle{} : ProxyHandle{place | id_bit_, generation};
  }

  // Must be called after a change and before the queries below.
  void RefreshTree();

  const LeafTree::View& view() const { return tree_.view(); }
  void NoteSearch(uint64_t checks) { tree_.NoteSearch(checks); }
  // Appends the proxies whose boxes overlap `box`, in unspecified order.
  void QueryBox(const Aabb& box, const CollisionFilter& filter,
                std::vector<ProxyHandle>& out) const;
  // Appends the proxies whose boxes the ray hits, in unspecified order.
  void CastRay(const Ray& ray, const CollisionFilter& filter, std::vector<RayHit>& hits) const;
  // Returns the nearest hit among these proxies, as CastRayNearest of proxy_set.h defines it.
  RayHit CastRayNearest(const Ray& ray, const CollisionFilter& filter) const;

  uint64_t refit_count() const { return refit_count_; }
  size_t native_bytes() const { return table_.native_bytes() + tree_.native_bytes(); }

 private:
  ProxyTable table_;
  BoxTree tree_;
  uint32_t id_bit_;
  uint64_t refit_count_ = 0;
};

}  // namespace sweepstake
