// Holds the proxies of one kind: all proxies added as moving, or all proxies added as static.
//
// The proxies are in consecutive rows. A proxy keeps its id until it is removed, but its row
// changes when Swap is called, so that a removed proxy leaves no gap. Work and snapshots therefore
// depend on the number of living proxies only.
//
// Not thread-safe. Owns its memory. Cost: O(1) per call unless its comment says otherwise. Memory:
// 53 bytes per row, and that of the ids (proxy_ids.h). Errors: std::bad_alloc from Add and
// FreeUnused, which then change nothing.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/proxies/proxy_ids.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

// Returns the generation after `generation`. 0 belongs to the null handle and is left out.
constexpr uint32_t NextGeneration(uint32_t generation) {
  return generation == ~0U ? 1 : generation + 1;
}

class ProxyTable {
 public:
  static constexpr uint32_t kNoRow = ProxyIds::kNoRow;

  // `id_bit` is set in the ids of all handles.
  explicit ProxyTable(uint32_t id_bit) : id_bit_(id_bit) {}

  uint32_t id_bit() const { return id_bit_; }
  // Adds a proxy in a new row, the last one.
  void Add(const Aabb& box, const CollisionFilter& filter, uint64_t user);
  // Removes the proxy in the last row.
  void RemoveLast();

  // Returns the row of the handle's proxy, or kNoRow if there is no such proxy.
  uint32_t Find(ProxyHandle handle) const {
    const uint32_t row = ids_.row(handle.index ^ id_bit_);
    return row != kNoRow && handles_[row] == handle ? row : kNoRow;
  }
  // Returns the row of the proxy that has this id, or kNoRow.
  uint32_t RowOf(uint32_t id) const { return ids_.row(id ^ id_bit_); }
  ProxyHandle handle(uint32_t row) const { return handles_[row]; }
  // Returns the number of proxies. They are in the rows from 0 on.
  size_t count() const { return boxes_.size(); }

  // Exchanges the rows of two proxies.
  void Swap(uint32_t a, uint32_t b);
  void SetBox(uint32_t row, const Aabb& box) { boxes_[row] = box; }
  void SetFilter(uint32_t row, const CollisionFilter& filter);
  void SetUser(uint32_t row, uint64_t user) { users_[row] = user; }
  uint64_t user(uint32_t row) const { return users_[row]; }
  void SetPopulation(uint32_t row, uint8_t population) { populations_[row] = population; }
  uint8_t population(uint32_t row) const { return populations_[row]; }

  // The columns, indexed by row. The slot of a proxy is its position in the tree of its population;
  // the trees write the slots.
  std::span<uint32_t> slots() { return slots_; }
  std::span<const Aabb> boxes() const { return boxes_; }
  std::span<const CollisionFilter> filters() const { return filters_; }

  // Returns whether every proxy has the default filter.
  bool all_pass() const { return filtered_count_ == 0; }
  // Returns whether the id of every proxy, without its bit, is its row.
  bool ids_are_rows() const { return displaced_count_ == 0; }
  // Returns whether a proxy has been removed since the latest MarkSeen.
  bool any_removed() const { return any_removed_; }
  void MarkSeen() { any_removed_ = false; }

  // Frees the memory that was not needed since the previous call. Returns whether that was at least
  // half of the rows. Cost: O(proxies) if so, and O(pages of ids).
  bool FreeUnused();

  // Passes the fields of a snapshot to `archive` (snapshot.h). FinishRestore must follow a restore.
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive) {
    archive.Array(self.boxes_);
    archive.Array(self.filters_);
    archive.Array(self.users_);
    archive.Array(self.handles_);
    archive.Array(self.slots_);
    archive.Array(self.populations_);
    archive.Value(self.filtered_count_);
    archive.Value(self.displaced_count_);
    archive.Value(self.latest_generation_);
    archive.Value(self.any_removed_);
  }
  // Cost: O(proxies + pages of ids).
  void FinishRestore();

  size_t native_bytes() const;

 private:
  static size_t CapacityFor(size_t rows);

  bool IsDisplaced(uint32_t row) const { return (handles_[row].index ^ id_bit_) != row; }
  void Reserve(size_t rows);

  uint32_t id_bit_;
  ProxyIds ids_;
  HookedVector<Aabb> boxes_;
  HookedVector<CollisionFilter> filters_;
  HookedVector<uint64_t> users_;
  HookedVector<ProxyHandle> handles_;
  HookedVector<uint32_t> slots_;
  HookedVector<uint8_t> populations_;
  size_t filtered_count_ = 0;
  size_t displaced_count_ = 0;  // the number of rows that are not their proxy's id
  size_t peak_count_ = 0;       // the largest number of proxies since the latest FreeUnused
  uint32_t latest_generation_ = 0;
  bool any_removed_ = false;
};

}  // namespace sweepstake
