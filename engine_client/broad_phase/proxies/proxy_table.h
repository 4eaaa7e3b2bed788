// Holds the proxies of one kind: all proxies added as moving, or all proxies added as static.
//
// Each proxy is in a row. It keeps its id until it is removed, but its row changes when Swap is
// called. A row without a proxy is a hole; ProxyKind fills holes, so that work and snapshots depend
// on the number of living proxies only.
//
// Not thread-safe. Owns its memory. Cost: O(1) per call unless its comment says otherwise. Memory:
// 53 bytes per row, a bit for each hole, and the memory of the ids (proxy_ids.h). Errors:
// std::bad_alloc from EnsureRoomForOne, FreeUnused and ShrinkRows, which then change nothing.
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

  // Makes room for a new proxy and its row. Returns the id for Fill.
  uint32_t EnsureRoomForOne();
  // Adds a hole as the last row. REQUIRES: EnsureRoomForOne.
  uint32_t AppendHole();
  // Removes the last row. REQUIRES: it is a hole.
  void RemoveLastRow();
  // Adds a proxy in a hole. REQUIRES: `id` is the result of EnsureRoomForOne.
  void Fill(uint32_t hole, uint32_t id, const Aabb& box, const CollisionFilter& filter,
            uint64_t user);
  // Removes the proxy in the row, which becomes a hole.
  void Empty(uint32_t row);
  // Exchanges the content of two rows, proxies or holes.
  void Swap(uint32_t a, uint32_t b);

  bool is_hole(uint32_t row) const { return generations_[row] == 0; }
  size_t hole_count() const { return hole_count_; }
  // REQUIRES: there is a hole. Cost: O(rows / 64).
  uint32_t LowestHole();
  uint32_t row_count() const { return static_cast<uint32_t>(boxes_.size()); }
  // Returns the number of proxies.
  size_t count() const { return boxes_.size() - hole_count_; }

  // Returns the row of the handle's proxy, or kNoRow if there is no such proxy.
  uint32_t Find(ProxyHandle handle) const {
    const uint32_t row = RowOf(handle.index);
    return row != kNoRow && generations_[row] == handle.generation ? row : kNoRow;
  }
  // Returns the row of the proxy that has this id, or kNoRow.
  uint32_t RowOf(uint32_t id) const {
    // Most proxies are in the row of their id. Looking there first saves a third of the time of a
    // move.
    const uint32_t likely_row = id ^ id_bit_;
    if (likely_row < ids_.size() && ids_[likely_row] == id) return likely_row;
    return row_of_.row(likely_row);
  }

  // Calls below with a row require that a proxy is there.

  uint32_t id(uint32_t row) const { return ids_[row]; }
  ProxyHandle handle(uint32_t row) const { return {ids_[row], generations_[row]}; }
  void SetBox(uint32_t row, const Aabb& box) { boxes_[row] = box; }
  void SetFilter(uint32_t row, const CollisionFilter& filter);
  void SetUser(uint32_t row, uint64_t user) { users_[row] = user; }
  uint64_t user(uint32_t row) const { return users_[row]; }
  void SetPopulation(uint32_t row, uint8_t population) { populations_[row] = population; }
  uint8_t population(uint32_t row) const { return populations_[row]; }

  // The columns, indexed by row. A hole has an invalid box and the default filter. The slot of a
  // proxy is its position in the tree of its population; the trees write the slots.
  std::span<uint32_t> slots() { return slots_; }
  std::span<const Aabb> boxes() const { return boxes_; }
  std::span<const CollisionFilter> filters() const { return filters_; }

  // Returns whether every proxy has the default filter.
  bool all_pass() const { return filtered_count_ == 0; }
  // Returns whether the id of every proxy, without its bit, is also its row.
  bool ids_are_rows() const { return displaced_count_ == 0; }
  // Returns whether a proxy has been removed since the latest MarkSeen.
  bool any_removed() const { return any_removed_; }
  void MarkSeen() { any_removed_ = false; }

  // Frees the ids' memory that was not needed since the previous call. Returns whether fewer than
  // half as many rows were needed as before that. ShrinkRows may then free their memory. Cost:
  // O(pages of ids).
  bool FreeUnused();
  // Frees the memory of rows that were not needed since the call of FreeUnused before the latest.
  // Invalidates the columns. Cost: O(proxies) if that is at least half of the rows.
  void ShrinkRows();

  // Passes the fields of a snapshot to `archive` (snapshot.h). FinishRestore must follow a restore.
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive) {
    archive.Array(self.boxes_);
    archive.Array(self.filters_);
    archive.Array(self.users_);
    archive.Array(self.ids_);
    archive.Array(self.generations_);
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
  static constexpr uint32_t kNoId = ProxyIds::kNoId;

  static size_t CapacityFor(size_t rows);

  size_t IsDisplaced(uint32_t row) const {
    return static_cast<size_t>(!is_hole(row) && (ids_[row] ^ id_bit_) != row);
  }
  void Reserve(size_t rows);
  void NoteHole(uint32_t row);
  void NoteFilled(uint32_t row);

  uint32_t id_bit_;
  ProxyIds row_of_;
  HookedVector<Aabb> boxes_;
  HookedVector<CollisionFilter> filters_;
  HookedVector<uint64_t> users_;
  HookedVector<uint32_t> ids_;          // with id_bit_; kNoId for a hole
  HookedVector<uint32_t> generations_;  // 0 for a hole
  HookedVector<uint32_t> slots_;
  HookedVector<uint8_t> populations_;
  HookedVector<uint64_t> holes_;  // the holes as bits, with room for all rows
  size_t hole_count_ = 0;
  size_t first_word_ = 0;  // the words of holes_ before this one are 0
  size_t filtered_count_ = 0;
  size_t displaced_count_ = 0;  // the number of rows that are not their proxy's id
  size_t peak_count_ = 0;       // the largest number of rows since the latest FreeUnused
  size_t needed_count_ = 0;     // the same of the time between the two latest FreeUnused
  uint32_t latest_generation_ = 0;
  bool any_removed_ = false;
};

}  // namespace sweepstake
