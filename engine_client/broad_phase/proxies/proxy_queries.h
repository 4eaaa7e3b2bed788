// Queries over all populations of both kinds of proxies (proxy_kind.h).
//
// Thread safety: const; any number of queries may run at the same time. Borrows the kinds, whose
// trees must be up to date. Order of the results: as in proxy_set.h. Errors: std::bad_alloc if
// results go to a vector.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine_client/broad_phase/proxies/proxy_kind.h"
#include "engine_client/broad_phase/proxies/query_shapes.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

// The results of a query. They go to a vector, which grows, or to the caller's array. Results
// beyond the end of the array are only counted.
template <typename T>
class Found {
 public:
  explicit Found(std::vector<T>& vector) : vector_(&vector) { vector.clear(); }
  explicit Found(std::span<T> room) : room_(room) {}

  void Add(const T& item) {
    if (vector_ != nullptr) {
      vector_->push_back(item);
    } else if (count_ < room_.size()) {
      room_[count_] = item;
    }
    ++count_;
  }
  size_t count() const { return count_; }
  std::span<T> items() { return vector_ != nullptr ? std::span(*vector_) : Taken(); }

 private:
  std::span<T> Taken() { return room_.first(count_ < room_.size() ? count_ : room_.size()); }

  std::vector<T>* vector_ = nullptr;
  std::span<T> room_;
  size_t count_ = 0;
};

class ProxyQueries {
 public:
  ProxyQueries(const ProxyKind& moving, const ProxyKind& resting)
      : moving_(moving), resting_(resting) {}

  void FindInBox(const Aabb& box, const CollisionFilter& filter, Found<ProxyHandle>& found) const;
  // REQUIRES: all values are finite.
  void FindInSphere(const Sphere& sphere, const CollisionFilter& filter,
                    Found<ProxyHandle>& found) const;
  // REQUIRES, here and below: IsFinite(slabs).
  void FindHits(const Slabs& slabs, const CollisionFilter& filter, Found<RayHit>& hits) const;
  // Returns a hit with a null handle if nothing is hit.
  RayHit FindNearestHit(const Slabs& slabs, const CollisionFilter& filter) const;

 private:
  const ProxyKind& moving_;
  const ProxyKind& resting_;
};

}  // namespace sweepstake
