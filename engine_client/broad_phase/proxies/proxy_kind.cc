#include "engine_client/broad_phase/proxies/proxy_kind.h"

namespace sweepstake {

uint32_t ProxyKind::Add(const Aabb& box, const CollisionFilter& filter, uint64_t user,
                        uint8_t population) {
  EnsureRoomIn(population);
  table_.Add(box, filter, user);
  return Enter(static_cast<uint32_t>(table_.count() - 1), population);
}

void ProxyKind::Remove(uint32_t row) {
  Exchange(Leave(row), static_cast<uint32_t>(table_.count() - 1));
  table_.RemoveLast();
}

void ProxyKind::SetFilter(uint32_t row, const CollisionFilter& filter) {
  const uint8_t population = table_.population(row);
  table_.SetFilter(row, filter);
  all_[population].category |= filter.category;
  all_[population].mask |= filter.mask;
  resting_changed_ |= !MovesIn(population);
}

uint32_t ProxyKind::ChangePopulation(uint32_t row, uint8_t population) {
  EnsureRoomIn(population);
  return Enter(Leave(row), population);
}

void ProxyKind::EnsureRoomIn(uint8_t population, size_t newcomers) {
  if (trees_[population] == nullptr) trees_[population] = std::make_unique<BoxTree>();
  trees_[population]->EnsureRoomFor(newcomers);
}

// Adds a proxy that is in no tree to a population. Returns its new row.
uint32_t ProxyKind::Enter(uint32_t row, uint8_t population) {
  if (population == 0) {
    Exchange(row, searched_count_);
    row = searched_count_++;
  }
  const CollisionFilter& filter = table_.filters()[row];
  CollisionFilter& all = all_[population];
  if (trees_[population]->count() == 0) all = {0, 0};
  all.category |= filter.category;
  all.mask |= filter.mask;
  table_.SetPopulation(row, population);
  trees_[population]->Add(row, table_.slots());
  NoteChange(population);
  return row;
}

// Removes a proxy from its population and its tree. Returns its new row, behind population 0.
uint32_t ProxyKind::Leave(uint32_t row) {
  const uint8_t population = table_.population(row);
  trees_[population]->Remove(table_.slots()[row]);
  NoteChange(population);
  if (population != 0) return row;
  Exchange(row, --searched_count_);
  return searched_count_;
}

// Exchanges the rows of a proxy that is in no tree and another one.
void ProxyKind::Exchange(uint32_t row, uint32_t other) {
  if (row == other) return;
  table_.Swap(row, other);
  trees_[table_.population(row)]->Rename(table_.slots()[row], row);
}

void ProxyKind::ShiftOrigin(const float offset[3]) {
  for (uint32_t row = 0; row < table_.count(); ++row) {
    Aabb box = table_.boxes()[row];
    if (!IsValid(box)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      box.min[axis] -= offset[axis];
      box.max[axis] -= offset[axis];
    }
    SetBox(row, box);
  }
}

bool ProxyKind::FreeUnused() {
  for (const auto& tree : trees_) {
    if (tree != nullptr && tree->is_oversized()) tree->FreeUnused(table_.slots());
  }
  return table_.FreeUnused();
}

void ProxyKind::RefreshTrees(KdOrder& splitter) {
  for (uint32_t population = 0; population < kPopulations; ++population) {
    const uint32_t bit = 1U << population;
    if ((changed_ & bit) == 0) continue;
    trees_[population]->Update(table_.boxes(), (moved_ & bit) != 0, splitter, table_.slots());
    changed_ &= ~bit;
    moved_ &= ~bit;
    ++refit_count_;
  }
}

void ProxyKind::FinishRestore() {
  table_.FinishRestore();
  for (const auto& tree : trees_) {
    if (tree != nullptr) tree->Refit(table_.boxes());
  }
}

size_t ProxyKind::native_bytes() const {
  size_t bytes = table_.native_bytes();
  for (const auto& tree : trees_) bytes += tree == nullptr ? 0 : tree->native_bytes();
  return bytes;
}

}  // namespace sweepstake
