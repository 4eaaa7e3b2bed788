#include "sweepstake/proxy_set.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/proxies/proxy_kind.h"
#include "engine_client/broad_phase/proxies/proxy_table.h"
#include "engine_client/broad_phase/proxies/ray_slabs.h"
#include "engine_client/broad_phase/proxies/tree_walk.h"
#include "sweepstake/pair_buffer.h"
#include "sweepstake/pair_sorter.h"

namespace sweepstake {
namespace {

// A part with fewer leaves of moving proxies takes less time than waking a thread.
constexpr size_t kMinLeavesPerPart = 32;

uint32_t PlaceOf(uint32_t id) { return id & ~kStaticProxyBit; }

// Copies the pairs that pass their filters to `out`, which may be the memory of `pairs`; returns
// their number.
size_t KeepPassing(std::span<const OverlapPair> pairs, const CollisionFilter* filters_a,
                   const CollisionFilter* filters_b, OverlapPair* out) {
  size_t count = 0;
  for (const OverlapPair pair : pairs) {
    out[count] = pair;
    count += static_cast<size_t>(Passes(filters_a[pair.a], filters_b[PlaceOf(pair.b)]));
  }
  return count;
}

Status CheckRay(const Ray& ray) {
  if (!IsFinite(ray)) {
    return {StatusCode::kInvalidArgument,
            "the ray's origin, direction and max_distance must be finite"};
  }
  if (ray.max_distance < 0) {
    return {StatusCode::kInvalidArgument, "the ray's max_distance must not be negative"};
  }
  return {};
}

}  // namespace

class ProxySet::Impl {
 public:
  explicit Impl(const ProxySetOptions& options) : options_(options) {}

  ProxyKind& KindOf(uint32_t id) { return (id & kStaticProxyBit) != 0 ? resting_ : moving_; }
  // Returns null for a handle without a proxy.
  ProxyKind* Find(ProxyHandle handle) {
    ProxyKind& kind = KindOf(handle.index);
    return kind.table().Holds(PlaceOf(handle.index), handle.generation) ? &kind : nullptr;
  }

  std::span<const OverlapPair> Resolve(std::span<const OverlapPair> moving_pairs);
  void RefreshTrees() {
    moving_.RefreshTree();
    resting_.RefreshTree();
  }
  void QueryBox(const Aabb& box, const CollisionFilter& filter, std::vector<ProxyHandle>& out);
  void CastRay(const Ray& ray, const CollisionFilter& filter, std::vector<RayHit>& hits);
  RayHit CastRayNearest(const Ray& ray, const CollisionFilter& filter);
  size_t native_bytes() const;

  ProxyKind moving_{0};
  ProxyKind resting_{kStaticProxyBit};
  PairEvents events_;

 private:
  bool AnyMeetsStatic() const {
    return resting_.table().count() > 0 && moving_.table().count() > 0;
  }
  bool all_pass() const { return moving_.table().all_pass() && resting_.table().all_pass(); }
  bool wants_sorted() const { return options_.sorted_pairs || options_.pair_events; }
  void AppendMoving(std::span<const OverlapPair> moving_pairs);
  void AppendStatic();

  ProxySetOptions options_;
  PairBuffer pairs_;  // the pairs of the latest Resolve
  PairBuffer next_;   // the pairs of the Resolve under way
  PairParts parts_;
  PairSorter sorter_;
};

std::span<const OverlapPair> ProxySet::Impl::Resolve(std::span<const OverlapPair> moving_pairs) {
  if (all_pass() && !AnyMeetsStatic() && !wants_sorted()) return moving_pairs;
  next_.Clear();
  AppendMoving(moving_pairs);
  if (AnyMeetsStatic()) AppendStatic();
  if (wants_sorted()) sorter_.Sort(next_.pairs());
  if (options_.pair_events) {
    events_.Compare(pairs_.pairs(), next_.pairs(), moving_.table(), resting_.table());
    moving_.table().MarkSeen();
    resting_.table().MarkSeen();
  }
  std::swap(pairs_, next_);
  return pairs_.pairs();
}

void ProxySet::Impl::AppendMoving(std::span<const OverlapPair> moving_pairs) {
  OverlapPair* const end = next_.EnsureRoom(moving_pairs.size());
  const CollisionFilter* const filters = moving_.table().filters().data();
  if (moving_.table().all_pass()) {
    std::copy(moving_pairs.begin(), moving_pairs.end(), end);
    next_.Advance(moving_pairs.size());
  } else {
    next_.Advance(KeepPassing(moving_pairs, filters, filters, end));
  }
}

void ProxySet::Impl::AppendStatic() {
  RefreshTrees();
  const size_t first = next_.size();
  const LeafTree::View& leaves = moving_.view();
  const size_t leaf_count = leaves.levels[1].count;
  const auto find = [&](size_t begin, size_t end, PairBuffer& out) {
    return FindPairsBetween(leaves, begin, end, resting_.view(), kStaticProxyBit, out);
  };
  moving_.NoteSearch(
      parts_.Run(options_.executor, leaf_count, kMinLeavesPerPart, LeafTree::kWidth, next_, find));
  if (all_pass()) return;
  const std::span<OverlapPair> found = next_.pairs().subspan(first);
  const size_t kept = KeepPassing(found, moving_.table().filters().data(),
                                  resting_.table().filters().data(), found.data());
  next_.Truncate(first + kept);
}

void ProxySet::Impl::QueryBox(const Aabb& box, const CollisionFilter& filter,
                              std::vector<ProxyHandle>& out) {
  RefreshTrees();
  out.clear();
  moving_.QueryBox(box, filter, out);
  resting_.QueryBox(box, filter, out);
  std::sort(out.begin(), out.end());
}

void ProxySet::Impl::CastRay(const Ray& ray, const CollisionFilter& filter,
                             std::vector<RayHit>& hits) {
  RefreshTrees();
  hits.clear();
  moving_.CastRay(ray, filter, hits);
  resting_.CastRay(ray, filter, hits);
  std::sort(hits.begin(), hits.end(), [](const RayHit& a, const RayHit& b) {
    return a.distance < b.distance || (a.distance == b.distance && a.proxy < b.proxy);
  });
}

RayHit ProxySet::Impl::CastRayNearest(const Ray& ray, const CollisionFilter& filter) {
  RefreshTrees();
  const RayHit moving = moving_.CastRayNearest(ray, filter);
  if (moving.proxy.is_null()) return resting_.CastRayNearest(ray, filter);
  Ray shorter = ray;
  shorter.max_distance = moving.distance;
  const RayHit resting = resting_.CastRayNearest(shorter, filter);
  // At equal distances the moving proxy is first, since its index is smaller.
  return resting.proxy.is_null() || resting.distance == moving.distance ? moving : resting;
}

size_t ProxySet::Impl::native_bytes() const {
  return moving_.native_bytes() + resting_.native_bytes() + pairs_.capacity_bytes() +
         next_.capacity_bytes() + parts_.native_bytes() + sorter_.native_bytes() +
         events_.native_bytes();
}

ProxySet::ProxySet(const ProxySetOptions& options) : impl_(std::make_unique<Impl>(options)) {}
ProxySet::~ProxySet() = default;
ProxySet::ProxySet(ProxySet&&) noexcept = default;
ProxySet& ProxySet::operator=(ProxySet&&) noexcept = default;

ProxyHandle ProxySet::Add(const Aabb& box, const ProxyOptions& options) {
  ProxyKind& kind = options.is_static ? impl_->resting_ : impl_->moving_;
  return kind.HandleAt(kind.table().Add(box, options.filter, options.user));
}

bool ProxySet::Remove(ProxyHandle handle) {
  ProxyKind* const kind = impl_->Find(handle);
  if (kind != nullptr) kind->table().Remove(PlaceOf(handle.index));
  return kind != nullptr;
}

bool ProxySet::Move(ProxyHandle handle, const Aabb& box) {
  ProxyKind* const kind = impl_->Find(handle);
  if (kind != nullptr) kind->table().SetBox(PlaceOf(handle.index), box);
  return kind != nullptr;
}

bool ProxySet::Move(std::span<const ProxyHandle> handles, std::span<const Aabb> boxes) {
  assert(handles.size() == boxes.size());
  const auto lives = [&](ProxyHandle handle) { return impl_->Find(handle) != nullptr; };
  if (!std::all_of(handles.begin(), handles.end(), lives)) return false;
  for (size_t k = 0; k < handles.size(); ++k) {
    impl_->KindOf(handles[k].index).table().SetBox(PlaceOf(handles[k].index), boxes[k]);
  }
  return true;
}

bool ProxySet::SetFilter(ProxyHandle handle, const CollisionFilter& filter) {
  ProxyKind* const kind = impl_->Find(handle);
  if (kind != nullptr) kind->table().SetFilter(PlaceOf(handle.index), filter);
  return kind != nullptr;
}

bool ProxySet::SetUser(ProxyHandle handle, uint64_t user) {
  ProxyKind* const kind = impl_->Find(handle);
  if (kind != nullptr) kind->table().SetUser(PlaceOf(handle.index), user);
  return kind != nullptr;
}

bool ProxySet::is_alive(ProxyHandle handle) const { return impl_->Find(handle) != nullptr; }

const Aabb* ProxySet::box(ProxyHandle handle) const {
  const ProxyKind* const kind = impl_->Find(handle);
  return kind == nullptr ? nullptr : &kind->table().boxes()[PlaceOf(handle.index)];
}

std::optional<ProxyOptions> ProxySet::options(ProxyHandle handle) const {
  const ProxyKind* const kind = impl_->Find(handle);
  if (kind == nullptr) return std::nullopt;
  const uint32_t place = PlaceOf(handle.index);
  return ProxyOptions{kind->table().filters()[place], kind == &impl_->resting_,
                      kind->table().user(place)};
}

ProxyHandle ProxySet::handle(uint32_t id) const { return impl_->KindOf(id).HandleAt(PlaceOf(id)); }

size_t ProxySet::moving_count() const { return impl_->moving_.table().count(); }
size_t ProxySet::static_count() const { return impl_->resting_.table().count(); }
std::span<const Aabb> ProxySet::moving_boxes() const { return impl_->moving_.table().boxes(); }

std::span<const OverlapPair> ProxySet::Resolve(std::span<const OverlapPair> moving_pairs) {
  return impl_->Resolve(moving_pairs);
}
std::span<const ProxyPair> ProxySet::added() const { return impl_->events_.added(); }
std::span<const ProxyPair> ProxySet::removed() const { return impl_->events_.removed(); }

void ProxySet::QueryBox(const Aabb& box, const CollisionFilter& filter,
                        std::vector<ProxyHandle>& out) {
  impl_->QueryBox(box, filter, out);
}

Status ProxySet::CastRay(const Ray& ray, const CollisionFilter& filter, std::vector<RayHit>& hits) {
  Status wrong = CheckRay(ray);
  if (wrong.ok()) impl_->CastRay(ray, filter, hits);
  return wrong;
}

Status ProxySet::CastRayNearest(const Ray& ray, const CollisionFilter& filter, RayHit& hit) {
  Status wrong = CheckRay(ray);
  if (wrong.ok()) hit = impl_->CastRayNearest(ray, filter);
  return wrong;
}

void ProxySet::PrepareQueries() { impl_->RefreshTrees(); }
bool ProxySet::queries_prepared() const {
  return !impl_->moving_.table().changed() && !impl_->resting_.table().changed();
}
uint64_t ProxySet::refit_count() const {
  return impl_->moving_.refit_count() + impl_->resting_.refit_count();
}
size_t ProxySet::native_bytes() const { return impl_->native_bytes(); }

}  // namespace sweepstake
