#include "engine_client/broad_phase/proxies/proxy_kind.h"

namespace sweepstake {

uint32_t ProxyKind::Add(const Aabb& box, const CollisionFilter& filter, uint64_t user,
                        uint8_t population) {
  EnsureRoomIn(population);
  const uint32_t place = table_.Add(box, filter, user);
  Enter(place, population);
  return place;
}

void ProxyKind::Remove(uint32_t place) {
  Leave(place);
  table_.Remove(place);
}

void ProxyKind::SetFilter(uint32_t place, const CollisionFilter& filter) {
  const uint8_t population = table_.population(place);
  table_.SetFilter(place, filter);
  all_[population].category |= filter.category;
  all_[population].mask |= filter.mask;
  resting_changed_ |= !MovesIn(population);
}

void ProxyKind::ChangePopulation(uint32_t place, uint8_t population) {
  EnsureRoomIn(population);
  Leave(place);
  Enter(place, population);
}

void ProxyKind::EnsureRoomIn(uint8_t population, size_t newcomers) {
  if (trees_[population] == nullptr) trees_[population] = std::make_unique<BoxTree>();
  trees_[population]->EnsureRoomFor(newcomers);
  if (id_bit_ == 0 && population != 0) table_.HideOthers();
}

void ProxyKind::Enter(uint32_t place, uint8_t population) {
  const CollisionFilter& filter = table_.filters()[place];
  CollisionFilter& all = all_[population];
  if (trees_[population]->count() == 0) all = {0, 0};
  all.category |= filter.category;
  all.mask |= filter.mask;
  table_.SetPopulation(place, population);
  trees_[population]->Add(place, table_.slots());
  NoteChange(population);
}

void ProxyKind::Leave(uint32_t place) {
  const uint8_t population = table_.population(place);
  trees_[population]->Remove(table_.slots()[place]);
  NoteChange(population);
}

void ProxyKind::ShiftOrigin(const float offset[3]) {
  for (uint32_t place = 0; place < table_.boxes().size(); ++place) {
    Aabb box = table_.boxes()[place];
    if (!IsValid(box)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      box.min[axis] -= offset[axis];
      box.max[axis] -= offset[axis];
    }
    SetBox(place, box);
  }
}

// Replaces the trees by empty ones and adds the members again. The next RefreshTrees sorts them.
void ProxyKind::Compact(size_t min_places) {
  std::array<std::unique_ptr<BoxTree>, kPopulations> trees;
  uint32_t changed = 0;
  for (uint32_t population = 0; population < kPopulations; ++population) {
    if (count(population) == 0) continue;
    trees[population] = std::make_unique<BoxTree>();
    trees[population]->EnsureRoomFor(count(population));
    changed |= 1U << population;
  }
  trees_ = std::move(trees);
  changed_ = changed;
  moved_ = 0;
  resting_changed_ = true;
  table_.Compact(min_places);
  for (uint32_t place = 0; place < table_.boxes().size(); ++place) {
    if (table_.generation(place) == 0) continue;
    trees_[table_.population(place)]->Add(place, table_.slots());
  }
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
