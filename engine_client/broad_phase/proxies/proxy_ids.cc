#include "engine_client/broad_phase/proxies/proxy_ids.h"

#include <algorithm>
#include <bit>

namespace sweepstake {

uint32_t ProxyIds::LowestFree() {
  const size_t page = LowestOpenPage();
  EnsurePage(page);
  const auto& free = pages_[page].data()->free;
  size_t word = 0;
  while (free[word] == 0) ++word;
  const size_t id = page * kPageIds + word * 64 + static_cast<size_t>(std::countr_zero(free[word]));
  if (id >= kMaxIds) OutOfMemory();
  return static_cast<uint32_t>(id);
}

void ProxyIds::Take(uint32_t id, uint32_t row) {
  Page& page = PageOf(id);
  page.rows[id % kPageIds] = row;
  page.free[id % kPageIds / 64] &= ~(uint64_t{1} << id % 64);
  page.was_used = true;
  if (++page.used_count == kPageIds) SetOpen(id / kPageIds, false);
}

void ProxyIds::Free(uint32_t id) {
  Page& page = PageOf(id);
  page.rows[id % kPageIds] = kNoRow;
  page.free[id % kPageIds / 64] |= uint64_t{1} << id % 64;
  if (page.used_count-- == kPageIds) SetOpen(id / kPageIds, true);
}

void ProxyIds::Assign(std::span<const uint32_t> ids, uint32_t id_bit) {
  for (AlignedBuffer<Page>& page : pages_) {
    if (page.data() != nullptr) page.data()->rows.fill(kNoRow);
  }
  for (uint32_t row = 0; row < ids.size(); ++row) {
    if (ids[row] == kNoId) continue;
    const uint32_t id = ids[row] ^ id_bit;
    EnsurePage(id / kPageIds);
    SetRow(id, row);
  }
  for (size_t page = 0; page < pages_.size(); ++page) Count(page);
}

void ProxyIds::FreeUnused() {
  for (AlignedBuffer<Page>& stored : pages_) {
    Page* const page = stored.data();
    if (page == nullptr) continue;
    if (!page->was_used) {
      stored = AlignedBuffer<Page>();
    } else {
      page->was_used = page->used_count > 0;
    }
  }
  while (!pages_.empty() && pages_.back().data() == nullptr) {
    SetOpen(pages_.size() - 1, false);
    pages_.pop_back();
  }
  if (pages_.capacity() <= std::max<size_t>(64, 4 * pages_.size())) return;
  pages_.shrink_to_fit();
  open_.resize((pages_.size() + 63) / 64);
  open_.shrink_to_fit();
}

// Computes which ids of the page are free.
void ProxyIds::Count(size_t number) {
  SetOpen(number, true);
  if (pages_[number].data() == nullptr) return;
  Page& page = *pages_[number].data();
  page.used_count = kPageIds;
  page.was_used = true;
  for (size_t word = 0; word < page.free.size(); ++word) {
    uint64_t free = 0;
    for (size_t bit = 0; bit < 64; ++bit) {
      free |= uint64_t{page.rows[word * 64 + bit] == kNoRow} << bit;
    }
    page.free[word] = free;
    page.used_count -= static_cast<uint32_t>(std::popcount(free));
  }
  if (page.used_count == kPageIds) SetOpen(number, false);
}

// If memory runs out, the page exists without memory, and the next call tries again.
void ProxyIds::EnsurePage(size_t page) {
  if (page >= pages_.size()) {
    open_.resize(std::max(open_.size(), page / 64 + 1));
    const size_t old_size = pages_.size();
    pages_.resize(page + 1);
    for (size_t k = old_size; k <= page; ++k) SetOpen(k, true);
  }
  if (pages_[page].data() != nullptr) return;
  pages_[page].EnsureDiscarding(1);
  pages_[page].data()->rows.fill(kNoRow);
  Count(page);
}

void ProxyIds::SetOpen(size_t page, bool is_open) {
  const uint64_t bit = uint64_t{1} << page % 64;
  open_[page / 64] = is_open ? open_[page / 64] | bit : open_[page / 64] & ~bit;
}

// Returns the number of pages if none has a free id.
size_t ProxyIds::LowestOpenPage() const {
  for (size_t word = 0; word < open_.size(); ++word) {
    if (open_[word] == 0) continue;
    return word * 64 + static_cast<size_t>(std::countr_zero(open_[word]));
  }
  return pages_.size();
}

size_t ProxyIds::native_bytes() const {
  size_t bytes =
      pages_.capacity() * sizeof(AlignedBuffer<Page>) + open_.capacity() * sizeof(uint64_t);
  for (const AlignedBuffer<Page>& page : pages_) bytes += page.capacity_bytes();
  return bytes;
}

}  // namespace sweepstake
