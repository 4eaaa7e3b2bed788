#include "sweepstake/proxy_set.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "engine_client/broad_phase/common/pair_limit.h"
#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/proxies/proxy_set_impl.h"

namespace sweepstake {
namespace {

// The number of Resolves, about four seconds of a game, after which memory that they did not need
// is freed. If it were freed at once, a game whose number of proxies changes from frame to frame
// would allocate in each frame.
constexpr uint32_t kResolvesPerFreeing = 256;
// Room for this number of pairs is not freed.
constexpr size_t kFewPairs = 4096;

// Writes the pairs that pass their filters to `out`, as ids instead of rows. Returns their number.
size_t KeepPassing(std::span<const OverlapPair> pairs, const ProxyTable& table, OverlapPair* out) {
  const CollisionFilter* const filters = table.filters().data();
  size_t count = 0;
  if (table.ids_are_rows()) {
    for (const OverlapPair pair : pairs) {
      out[count] = pair;
      count += static_cast<size_t>(Passes(filters[pair.a], filters[pair.b]));
    }
    return count;
  }
  const bool all_pass = table.all_pass();
  for (const OverlapPair pair : pairs) {
    out[count] = Ascending({table.id(pair.a), table.id(pair.b)});
    count += static_cast<size_t>(all_pass || Passes(filters[pair.a], filters[pair.b]));
  }
  return count;
}

bool IsSame(const Aabb& a, const Aabb& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

std::span<const OverlapPair> ProxySet::Impl::Resolve(std::span<const OverlapPair> moving_pairs,
                                                     uint64_t max_pairs) {
  const Zone zone(kZoneResolveProxies);
  events_.Clear();  // if memory or max_pairs ends the call below, no old events remain
  if (++resolve_count_ == kResolvesPerFreeing) FreeUnused();
  const ProxyTable& moving = moving_.table();
  pairs_.Clear();
  PairLimit limit(nullptr, max_pairs == 0 ? std::numeric_limits<uint64_t>::max() : max_pairs);
  pairs_exceeded_ = limit.WantsStop(0, moving_pairs.size());
  if (pairs_exceeded_) return {};
  const bool any_joins = joins_.Plan();
  if (moving.all_pass() && moving.ids_are_rows() && !any_joins && !wants_sorted()) {
    return moving_pairs;
  }
  next_.Clear();
  AppendMoving(moving_pairs);
  if (any_joins) joins_.FindPairs(splitter_, limit, next_);
  pairs_exceeded_ = limit.is_exceeded();
  if (pairs_exceeded_) return {};
  if (wants_sorted()) sorter_.Sort(next_.pairs());
  if (options_.pair_events) {
    events_.Update(next_.pairs(), options_.event_margin);
    moving_.MarkSeen();
    resting_.MarkSeen();
  }
  std::swap(pairs_, next_);
  peak_pair_count_ = std::max(peak_pair_count_, pairs_.size());
  return pairs_.pairs();
}

void ProxySet::Impl::AppendMoving(std::span<const OverlapPair> moving_pairs) {
  const ProxyTable& moving = moving_.table();
  if (moving.all_pass() && moving.ids_are_rows()) return Append(moving_pairs, next_);
  OverlapPair* const end = next_.EnsureRoom(moving_pairs.size());
  next_.Advance(KeepPassing(moving_pairs, moving, end));
}

// Frees memory that was not needed since the previous call. The next change frees that of the rows:
// until then the caller may use the boxes.
void ProxySet::Impl::FreeUnused() {
  resolve_count_ = 0;
  const size_t room =
      std::max(pairs_.capacity_bytes(), next_.capacity_bytes()) / sizeof(OverlapPair);
  is_oversized_ |= room > std::max(kFewPairs, 3 * peak_pair_count_);
  is_oversized_ |= moving_.FreeUnused();
  is_oversized_ |= resting_.FreeUnused();
  may_shrink_rows_ = true;
  peak_pair_count_ = pairs_.size();
  if (!is_oversized_) return;
  events_.FreeUnused();
  joins_.FreeUnused();
  pairs_ = PairBuffer();
  next_ = PairBuffer();
  splitter_ = {};
  sorter_ = {};
  is_oversized_ = false;
}

// Must be called at the beginning of a change.
void ProxySet::Impl::ShrinkRows() {
  if (!may_shrink_rows_) return;
  moving_.ShrinkRows();
  resting_.ShrinkRows();
  may_shrink_rows_ = false;
}

ProxyHandle ProxySet::Impl::Add(const Aabb& box, const ProxyOptions& options) {
  ProxyKind& kind = options.is_static ? resting_ : moving_;
  const uint32_t group = options.is_static ? 0 : groups_.GroupFor(options.filter);
  const uint8_t population = options.is_static ? kStaticPopulation : static_cast<uint8_t>(group);
  const Aabb copy = box;  // the caller's may be one of the set, which moves with the table
  ShrinkRows();
  const uint32_t row = kind.Add(copy, options.filter, options.user, population);
  groups_.Join(group, options.filter);
  return kind.table().handle(row);
}

void ProxySet::Impl::Remove(ProxyKind& kind, uint32_t row) {
  ShrinkRows();
  groups_.Leave(GroupOf(kind.table().population(row)));
  kind.Remove(row);
}

// Sets the box and wakes a sleeping proxy. A box with the same bytes as before changes nothing.
void ProxySet::Impl::Move(ProxyKind& kind, uint32_t row, const Aabb& box) {
  if (IsSame(kind.table().boxes()[row], box)) return;
  const uint8_t population = kind.table().population(row);
  if (!SleepsIn(population)) return kind.SetBox(row, box);
  const Aabb copy = box;  // the caller's may be one of the set, which a change of rows moves
  row = kind.ChangePopulation(row, static_cast<uint8_t>(population - kSleepingPopulation));
  kind.SetBox(row, copy);
}

// Allocates the memory that is needed to wake the sleeping proxies among `handles` whose boxes
// change. If this fails, no proxy has moved yet. Returns false if a handle has no proxy.
bool ProxySet::Impl::PrepareMove(std::span<const ProxyHandle> handles,
                                 std::span<const Aabb> boxes) {
  std::array<std::array<size_t, kSleepingPopulation>, 2> waking{};  // counts by kind and group
  for (size_t k = 0; k < handles.size(); ++k) {
    const ProxyTable& table = TableOf(handles[k].index);
    const uint32_t row = table.Find(handles[k]);
    if (row == ProxyTable::kNoRow) return false;
    const uint8_t population = table.population(row);
    if (!SleepsIn(population) || IsSame(table.boxes()[row], boxes[k])) continue;
    ++waking[table.id_bit() != 0 ? 1 : 0][population - kSleepingPopulation];
  }
  for (uint8_t group = 0; group < kSleepingPopulation; ++group) {
    if (waking[0][group] > 0) moving_.EnsureRoomIn(group, waking[0][group]);
    if (waking[1][group] > 0) resting_.EnsureRoomIn(group, waking[1][group]);
  }
  return true;
}

void ProxySet::Impl::SetFilter(ProxyKind& kind, uint32_t row, const CollisionFilter& filter) {
  const uint8_t population = kind.table().population(row);
  if (IsStaticIn(population)) return kind.SetFilter(row, filter);
  const uint32_t group = groups_.GroupFor(filter);
  const auto next = static_cast<uint8_t>(population - GroupOf(population) + group);
  kind.EnsureRoomIn(next);
  kind.SetFilter(row, filter);
  groups_.Leave(GroupOf(population));
  groups_.Join(group, filter);
  if (next != population) kind.ChangePopulation(row, next);
}

void ProxySet::Impl::SetStatic(ProxyKind& kind, uint32_t row, bool is_static) {
  const uint8_t population = kind.table().population(row);
  if (IsStaticIn(population) == is_static) return;
  const CollisionFilter filter = kind.table().filters()[row];
  const uint32_t group = is_static ? 0 : groups_.GroupFor(filter);
  kind.ChangePopulation(row, is_static ? kStaticPopulation : static_cast<uint8_t>(group));
  groups_.Leave(GroupOf(population));
  groups_.Join(group, filter);
}

void ProxySet::Impl::SetSleeping(ProxyKind& kind, uint32_t row, bool is_sleeping) {
  const uint8_t population = kind.table().population(row);
  if (IsStaticIn(population) || SleepsIn(population) == is_sleeping) return;
  const uint32_t group = GroupOf(population);
  kind.ChangePopulation(row,
                        static_cast<uint8_t>(is_sleeping ? kSleepingPopulation + group : group));
}

size_t ProxySet::Impl::native_bytes() const {
  return moving_.native_bytes() + resting_.native_bytes() + splitter_.native_bytes() +
         pairs_.capacity_bytes() + next_.capacity_bytes() + joins_.native_bytes() +
         sorter_.native_bytes() + events_.native_bytes();
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
  return impl_->Change(handle, [&](ProxyKind& kind, uint32_t row) { impl_->Remove(kind, row); });
}

bool ProxySet::RemoveMany(std::span<const ProxyHandle> handles) {
  const FloatEnvironmentScope environment;
  if (!impl_->AllLive(handles)) return false;
  for (const ProxyHandle handle : handles) Remove(handle);
  return true;
}

bool ProxySet::Move(ProxyHandle handle, const Aabb& box) {
  const FloatEnvironmentScope environment;
  return impl_->Change(handle, [&](ProxyKind& kind, uint32_t row) { impl_->Move(kind, row, box); });
}

bool ProxySet::Move(std::span<const ProxyHandle> handles, std::span<const Aabb> boxes) {
  const FloatEnvironmentScope environment;
  assert(handles.size() == boxes.size());
  if (!impl_->PrepareMove(handles, boxes)) return false;
  for (size_t k = 0; k < handles.size(); ++k) {
    impl_->Move(impl_->KindOf(handles[k].index), impl_->Find(handles[k]), boxes[k]);
  }
  return true;
}

bool ProxySet::SetFilter(ProxyHandle handle, const CollisionFilter& filter) {
  const FloatEnvironmentScope environment;
  return impl_->Change(handle,
                       [&](ProxyKind& kind, uint32_t row) { impl_->SetFilter(kind, row, filter); });
}

bool ProxySet::SetUser(ProxyHandle handle, uint64_t user) {
  return impl_->Change(handle, [&](ProxyKind& kind, uint32_t row) { kind.SetUser(row, user); });
}

bool ProxySet::SetStatic(ProxyHandle handle, bool is_static) {
  const FloatEnvironmentScope environment;
  return impl_->Change(
      handle, [&](ProxyKind& kind, uint32_t row) { impl_->SetStatic(kind, row, is_static); });
}

bool ProxySet::SetSleeping(ProxyHandle handle, bool is_sleeping) {
  const FloatEnvironmentScope environment;
  return impl_->Change(
      handle, [&](ProxyKind& kind, uint32_t row) { impl_->SetSleeping(kind, row, is_sleeping); });
}

bool ProxySet::is_sleeping(ProxyHandle handle) const {
  const uint32_t row = impl_->Find(handle);
  return row != ProxyTable::kNoRow && SleepsIn(impl_->TableOf(handle.index).population(row));
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

bool ProxySet::is_alive(ProxyHandle handle) const { return impl_->Lives(handle); }

const Aabb* ProxySet::box(ProxyHandle handle) const {
  const uint32_t row = impl_->Find(handle);
  return row == ProxyTable::kNoRow ? nullptr : &impl_->TableOf(handle.index).boxes()[row];
}

std::optional<ProxyOptions> ProxySet::options(ProxyHandle handle) const {
  const uint32_t row = impl_->Find(handle);
  if (row == ProxyTable::kNoRow) return std::nullopt;
  const ProxyTable& table = impl_->TableOf(handle.index);
  return ProxyOptions{table.filters()[row], IsStaticIn(table.population(row)), table.user(row)};
}

ProxyHandle ProxySet::handle(uint32_t id) const {
  const ProxyTable& table = impl_->TableOf(id);
  const uint32_t row = table.RowOf(id);
  return row == ProxyTable::kNoRow ? ProxyHandle{} : table.handle(row);
}

size_t ProxySet::moving_count() const {
  return impl_->moving_.table().count() + impl_->resting_.table().count() - static_count();
}
size_t ProxySet::static_count() const {
  return impl_->moving_.count(kStaticPopulation) + impl_->resting_.count(kStaticPopulation);
}
std::span<const Aabb> ProxySet::moving_boxes() const { return impl_->moving_.searched_boxes(); }

std::span<const OverlapPair> ProxySet::Resolve(std::span<const OverlapPair> moving_pairs,
                                               uint64_t max_pairs) {
  const FloatEnvironmentScope environment;
  return impl_->Resolve(moving_pairs, max_pairs);
}
void ProxySet::SkipResolve() { impl_->SkipResolve(); }
bool ProxySet::pairs_exceeded() const { return impl_->pairs_exceeded(); }
std::span<const ProxyPair> ProxySet::added() const { return impl_->events_.added(); }
std::span<const ProxyPair> ProxySet::removed() const { return impl_->events_.removed(); }

void ProxySet::PrepareQueries() {
  const FloatEnvironmentScope environment;
  impl_->RefreshTrees();
}
uint64_t ProxySet::refit_count() const {
  return impl_->moving_.refit_count() + impl_->resting_.refit_count();
}
void ProxySet::FreeUnused() {
  impl_->events_.Clear();
  impl_->FreeUnused();
  impl_->ShrinkRows();
}
size_t ProxySet::native_bytes() const { return impl_->native_bytes(); }

}  // namespace sweepstake
