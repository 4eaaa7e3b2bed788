// Gives ids to proxies and maps each id to the row of its proxy (proxy_table.h).
//
// A new proxy gets the lowest free id, so that ids stay close together. The ids are divided into
// pages of 1,024. FreeUnused frees the pages without a proxy.
//
// Not thread-safe; const calls may run at the same time. Owns its memory. Cost: O(1), LowestFree
// O(pages / 64), Assign O(rows + pages), FreeUnused O(pages). Memory: 4 bytes per id of a page with
// proxies, and 16 per page up to the highest id. Errors: std::bad_alloc from LowestFree and
// FreeUnused, which then change nothing, and from Assign.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/host/hook_points.h"

namespace sweepstake {

class ProxyIds {
 public:
  static constexpr uint32_t kMaxIds = 0x7fffffff;
  static constexpr uint32_t kPageIds = 1024;
  static constexpr uint32_t kNoId = ~0U;
  // The row of a free id.
  static constexpr uint32_t kNoRow = ~0U;

  // Returns the lowest free id and makes room for its row.
  uint32_t LowestFree();
  // Gives the free id to the proxy in this row. REQUIRES: `id` is the result of LowestFree.
  void Take(uint32_t id, uint32_t row);
  // Must be called when the proxy with this id has moved to another row.
  void SetRow(uint32_t id, uint32_t row) { PageOf(id).rows[id % kPageIds] = row; }
  void Free(uint32_t id);
  // Frees all ids and keeps the memory. Then gives the id ids[row] ^ id_bit to the proxy in each
  // row, unless ids[row] is kNoId. If memory runs out, only Assign may follow.
  void Assign(std::span<const uint32_t> ids, uint32_t id_bit);

  // Returns the row of the proxy that has this id, or kNoRow.
  uint32_t row(uint32_t id) const {
    const size_t page = id / kPageIds;
    if (page >= pages_.size() || pages_[page].data() == nullptr) return kNoRow;
    return pages_[page].data()->rows[id % kPageIds];
  }

  // Frees the pages in which no id has been in use since the previous call.
  void FreeUnused();
  size_t native_bytes() const;

 private:
  struct Page {
    std::array<uint32_t, kPageIds> rows;
    std::array<uint64_t, kPageIds / 64> free;  // the free ids, as bits
    uint32_t used_count;
    bool was_used;  // whether an id has been in use since the latest FreeUnused
  };

  Page& PageOf(uint32_t id) { return *pages_[id / kPageIds].data(); }
  void Count(size_t number);
  void EnsurePage(size_t page);
  void SetOpen(size_t page, bool is_open);
  size_t LowestOpenPage() const;

  HookedVector<AlignedBuffer<Page>> pages_;  // one page each, or none
  HookedVector<uint64_t> open_;              // the pages of pages_ with a free id, as bits
};

}  // namespace sweepstake
