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

void ProxyIds::Insert(uint32_t id, uint32_t row) {
  EnsurePage(id / kPageIds);
  Take(id, row);
}

void ProxyIds::Free(uint32_t id) {
  Page& page = PageOf(id);
  page.rows[id % kPageIds] = kNoRow;
  page.free[id % kPageIds / 64] |= uint64_t{1} << id % 64;
  if (page.used_count-- == kPageIds) SetOpen(id / kPageIds, true);
}

void ProxyIds::Clear() {
  for (size_t page = 0; page < pages_.size(); ++page) {
    if (pages_[page].data() != nullptr) Empty(*pages_[page].data());
    SetOpen(page, true);
  }
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

void ProxyIds::Empty(Page& page) {
  page.rows.fill(kNoRow);
  page.free.fill(~uint64_t{0});
  page.used_count = 0;
  page.was_used = true;
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
  Empty(*pages_[page].data());
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
