#include "sweepstake/proxy_set.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>

#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/proxies/proxy_set_impl.h"

namespace sweepstake {
namespace {

// Copies the pairs that pass their filters to `out`; returns their number.
size_t KeepPassing(std::span<const OverlapPair> pairs, const CollisionFilter* filters,
                   OverlapPair* out) {
  size_t count = 0;
  for (const OverlapPair pair : pairs) {
    out[count] = pair;
    count += static_cast<size_t>(Passes(filters[pair.a], filters[pair.b]));
  }
  return count;
}

bool IsSame(const Aabb& a, const Aabb& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

std::span<const OverlapPair> ProxySet::Impl::Resolve(std::span<const OverlapPair> moving_pairs) {
  const Zone zone(kZoneResolveProxies);
  events_.Clear();  // if memory runs out below, no old events remain
  const bool any_joins = joins_.Plan();
  if (moving_.table().all_pass() && !any_joins && !wants_sorted()) return moving_pairs;
  next_.Clear();
  AppendMoving(moving_pairs);
  if (any_joins) joins_.FindPairs(splitter_, next_);
  if (wants_sorted()) sorter_.Sort(next_.pairs());
  if (options_.pair_events) {
    FindEvents();
    moving_.MarkSeen();
    resting_.MarkSeen();
  }
  std::swap(pairs_, next_);
  return pairs_.pairs();
}

void ProxySet::Impl::FindEvents() {
  const ProxyTable& moving = moving_.table();
  const ProxyTable& resting = resting_.table();
  if (options_.event_margin == 0) {
    return events_.Compare(pairs_.pairs(), next_.pairs(), moving, resting);
  }
  next_begun_.Clear();
  PairEvents::Hold(begun_.pairs(), next_.pairs(), options_.event_margin, moving, resting,
                   next_begun_);
  events_.Compare(begun_.pairs(), next_begun_.pairs(), moving, resting);
  std::swap(begun_, next_begun_);
}

void ProxySet::Impl::AppendMoving(std::span<const OverlapPair> moving_pairs) {
  if (moving_.table().all_pass()) return Append(moving_pairs, next_);
  OverlapPair* const end = next_.EnsureRoom(moving_pairs.size());
  next_.Advance(KeepPassing(moving_pairs, moving_.table().filters().data(), end));
}

ProxyHandle ProxySet::Impl::Add(const Aabb& box, const ProxyOptions& options) {
  ProxyKind& kind = options.is_static ? resting_ : moving_;
  const uint32_t group = options.is_static ? 0 : groups_.GroupFor(options.filter);
  const uint8_t population = options.is_static ? kStaticPopulation : static_cast<uint8_t>(group);
  const uint32_t place = kind.Add(box, options.filter, options.user, population);
  groups_.Join(group, options.filter);
  return kind.HandleAt(place);
}

void ProxySet::Impl::Remove(ProxyKind& kind, uint32_t place) {
  groups_.Leave(GroupOf(kind.table().population(place)));
  kind.Remove(place);
}

// Sets the box and wakes a sleeping proxy. A box with the same bytes as before changes nothing.
void ProxySet::Impl::Move(ProxyKind& kind, uint32_t place, const Aabb& box) {
  if (IsSame(kind.table().boxes()[place], box)) return;
  const uint8_t population = kind.table().population(place);
  if (SleepsIn(population)) {
    kind.ChangePopulation(place, static_cast<uint8_t>(population - kSleepingPopulation));
  }
  kind.SetBox(place, box);
}

// Allocates the memory that is needed to wake the sleeping proxies among `handles` whose boxes
// change. If this fails, no proxy has moved yet.
void ProxySet::Impl::EnsureRoomToWake(std::span<const ProxyHandle> handles,
                                      std::span<const Aabb> boxes) {
  std::array<std::array<size_t, kSleepingPopulation>, 2> waking{};  // counts by kind and group
  for (size_t k = 0; k < handles.size(); ++k) {
    const ProxyKind& kind = KindOf(handles[k].index);
    const uint32_t place = PlaceOf(handles[k].index);
    const uint8_t population = kind.table().population(place);
    if (!SleepsIn(population) || IsSame(kind.table().boxes()[place], boxes[k])) continue;
    ++waking[&kind == &resting_ ? 1 : 0][population - kSleepingPopulation];
  }
  for (uint8_t group = 0; group < kSleepingPopulation; ++group) {
    if (waking[0][group] > 0) moving_.EnsureRoomIn(group, waking[0][group]);
    if (waking[1][group] > 0) resting_.EnsureRoomIn(group, waking[1][group]);
  }
}

void ProxySet::Impl::SetFilter(ProxyKind& kind, uint32_t place, const CollisionFilter& filter) {
  const uint8_t population = kind.table().population(place);
  if (IsStaticIn(population)) return kind.SetFilter(place, filter);
  const uint32_t group = groups_.GroupFor(filter);
  const auto next = static_cast<uint8_t>(population - GroupOf(population) + group);
  kind.EnsureRoomIn(next);
  kind.SetFilter(place, filter);
  groups_.Leave(GroupOf(population));
  groups_.Join(group, filter);
  if (next != population) kind.ChangePopulation(place, next);
}

void ProxySet::Impl::SetStatic(ProxyKind& kind, uint32_t place, bool is_static) {
  const uint8_t population = kind.table().population(place);
  if (IsStaticIn(population) == is_static) return;
  const CollisionFilter& filter = kind.table().filters()[place];
  const uint32_t group = is_static ? 0 : groups_.GroupFor(filter);
  kind.ChangePopulation(place, is_static ? kStaticPopulation : static_cast<uint8_t>(group));
  groups_.Leave(GroupOf(population));
  groups_.Join(group, filter);
}

void ProxySet::Impl::SetSleeping(ProxyKind& kind, uint32_t place, bool is_sleeping) {
  const uint8_t population = kind.table().population(place);
  if (IsStaticIn(population) || SleepsIn(population) == is_sleeping) return;
  const uint32_t group = GroupOf(population);
  kind.ChangePopulation(place,
                        static_cast<uint8_t>(is_sleeping ? kSleepingPopulation + group : group));
}

// Frees unused memory. Keeps the places that occur in the latest pairs, since the next Resolve
// compares these pairs with the new ones.
void ProxySet::Impl::Compact() {
  size_t moving_places = 0;
  size_t static_places = 0;
  PairBuffer& latest = options_.event_margin == 0 ? pairs_ : begun_;
  if (!options_.pair_events) latest.Clear();
  for (const OverlapPair& pair : latest.pairs()) {
    for (const uint32_t id : {pair.a, pair.b}) {
      size_t& places = (id & kStaticProxyBit) != 0 ? static_places : moving_places;
      places = std::max(places, size_t{PlaceOf(id)} + 1);
    }
  }
  PairBuffer compact;
  Append(latest.pairs(), compact);
  moving_.Compact(moving_places);
  resting_.Compact(static_places);
  joins_.Compact();
  events_.Compact();
  pairs_ = PairBuffer();
  latest = std::move(compact);
  next_ = PairBuffer();
  next_begun_ = PairBuffer();
  splitter_ = {};
  sorter_ = {};
}

size_t ProxySet::Impl::native_bytes() const {
  return moving_.native_bytes() + resting_.native_bytes() + splitter_.native_bytes() +
         pairs_.capacity_bytes() + next_.capacity_bytes() + begun_.capacity_bytes() +
         next_begun_.capacity_bytes() + joins_.native_bytes() + sorter_.native_bytes() +
         events_.native_bytes();
}

ProxySet::ProxySet(const ProxySetOptions& options) : impl_(std::make_unique<Impl>(options)) {}
ProxySet::~ProxySet() = default;
ProxySet::ProxySet(ProxySet&&) noexcept = default;
ProxySet& ProxySet::operator=(ProxySet&&) noexcept = default;

ProxyHandle ProxySet::Add(const Aabb& box, const ProxyOptions& options) {
  const FloatEnvironmentScope environment;
  return impl_->Add(box, options);
}

void ProxySet::AddMany(std::span<const Aabb> boxes, std::span<const ProxyOptions> options,
                       std::span<ProxyHandle> handles) {
  const FloatEnvironmentScope environment;
  assert(boxes.size() == handles.size());
  assert(options.size() == 1 || options.size() == boxes.size());
  std::fill(handles.begin(), handles.end(), ProxyHandle{});
  for (size_t k = 0; k < boxes.size(); ++k) {
    handles[k] = impl_->Add(boxes[k], options[options.size() == 1 ? 0 : k]);
  }
}

bool ProxySet::Remove(ProxyHandle handle) {
  const FloatEnvironmentScope environment;
  return impl_->Change(handle,
                       [&](ProxyKind& kind, uint32_t place) { impl_->Remove(kind, place); });
}

bool ProxySet::RemoveMany(std::span<const ProxyHandle> handles) {
  const FloatEnvironmentScope environment;
  if (!impl_->AllLive(handles)) return false;
  for (const ProxyHandle handle : handles) Remove(handle);
  return true;
}

bool ProxySet::Move(ProxyHandle handle, const Aabb& box) {
  const FloatEnvironmentScope environment;
  return impl_->Change(handle,
                       [&](ProxyKind& kind, uint32_t place) { impl_->Move(kind, place, box); });
}

bool ProxySet::Move(std::span<const ProxyHandle> handles, std::span<const Aabb> boxes) {
  const FloatEnvironmentScope environment;
  assert(handles.size() == boxes.size());
  if (!impl_->AllLive(handles)) return false;
  impl_->EnsureRoomToWake(handles, boxes);
  for (size_t k = 0; k < handles.size(); ++k) {
    impl_->Move(impl_->KindOf(handles[k].index), PlaceOf(handles[k].index), boxes[k]);
  }
  return true;
}

bool ProxySet::SetFilter(ProxyHandle handle, const CollisionFilter& filter) {
  return impl_->Change(
      handle, [&](ProxyKind& kind, uint32_t place) { impl_->SetFilter(kind, place, filter); });
}

bool ProxySet::SetUser(ProxyHandle handle, uint64_t user) {
  return impl_->Change(handle, [&](ProxyKind& kind, uint32_t place) { kind.SetUser(place, user); });
}

bool ProxySet::SetStatic(ProxyHandle handle, bool is_static) {
  const FloatEnvironmentScope environment;
  return impl_->Change(
      handle, [&](ProxyKind& kind, uint32_t place) { impl_->SetStatic(kind, place, is_static); });
}

bool ProxySet::SetSleeping(ProxyHandle handle, bool is_sleeping) {
  const FloatEnvironmentScope environment;
  return impl_->Change(handle, [&](ProxyKind& kind, uint32_t place) {
    impl_->SetSleeping(kind, place, is_sleeping);
  });
}

bool ProxySet::is_sleeping(ProxyHandle handle) const {
  const ProxyKind* const kind = std::as_const(*impl_).Find(handle);
  return kind != nullptr && SleepsIn(kind->table().population(PlaceOf(handle.index)));
}

Status ProxySet::ShiftOrigin(const float offset[3]) {
  const FloatEnvironmentScope environment;
  if (!std::isfinite(offset[0]) || !std::isfinite(offset[1]) || !std::isfinite(offset[2])) {
    return {StatusCode::kInvalidArgument, "the offset must be finite"};
  }
  impl_->moving_.ShiftOrigin(offset);
  impl_->resting_.ShiftOrigin(offset);
  return {};
}

void ProxySet::Compact() {
  const FloatEnvironmentScope environment;
  impl_->Compact();
}

bool ProxySet::is_alive(ProxyHandle handle) const { return impl_->Find(handle) != nullptr; }

const Aabb* ProxySet::box(ProxyHandle handle) const {
  const ProxyKind* const kind = std::as_const(*impl_).Find(handle);
  return kind == nullptr ? nullptr : &kind->table().boxes()[PlaceOf(handle.index)];
}

std::optional<ProxyOptions> ProxySet::options(ProxyHandle handle) const {
  const ProxyKind* const kind = std::as_const(*impl_).Find(handle);
  if (kind == nullptr) return std::nullopt;
  const ProxyTable& table = kind->table();
  const uint32_t place = PlaceOf(handle.index);
  return ProxyOptions{table.filters()[place], IsStaticIn(table.population(place)),
                      table.user(place)};
}

ProxyHandle ProxySet::handle(uint32_t id) const {
  return std::as_const(*impl_).KindOf(id).HandleAt(PlaceOf(id));
}

size_t ProxySet::moving_count() const {
  return impl_->moving_.table().count() + impl_->resting_.table().count() - static_count();
}
size_t ProxySet::static_count() const {
  return impl_->moving_.count(kStaticPopulation) + impl_->resting_.count(kStaticPopulation);
}
std::span<const Aabb> ProxySet::moving_boxes() const {
  return impl_->moving_.table().shown_boxes();
}

std::span<const OverlapPair> ProxySet::Resolve(std::span<const OverlapPair> moving_pairs) {
  const FloatEnvironmentScope environment;
  return impl_->Resolve(moving_pairs);
}
std::span<const ProxyPair> ProxySet::added() const { return impl_->events_.added(); }
std::span<const ProxyPair> ProxySet::removed() const { return impl_->events_.removed(); }

void ProxySet::PrepareQueries() {
  const FloatEnvironmentScope environment;
  impl_->RefreshTrees();
}
uint64_t ProxySet::refit_count() const {
  return impl_->moving_.refit_count() + impl_->resting_.refit_count();
}
size_t ProxySet::native_bytes() const { return impl_->native_bytes(); }

}  // namespace sweepstake
