#include "engine_client/broad_phase/proxies/proxy_kind.h"

namespace sweepstake {
namespace {

// If more than 1 in 32 of the first rows is a hole, holes are filled. With 1/32 more boxes, all
// invalid, even brute force makes only 1/16 more checks.
constexpr size_t kFirstRowsPerHole = 32;

}  // namespace

uint32_t ProxyKind::Add(const Aabb& box, const CollisionFilter& filter, uint64_t user,
                        uint8_t population) {
  EnsureRoomIn(population);
  const uint32_t id = table_.EnsureRoomForOne();
  const uint32_t row = TakeHole(IsFirst(population));
  table_.Fill(row, id, box, filter, user);
  Enter(row, population);
  return row;
}

void ProxyKind::Remove(uint32_t row) {
  Leave(row);
  table_.Empty(row);
  if (row >= first_row_count_) {
    Exchange(row, table_.row_count() - 1);
    table_.RemoveLastRow();
  }
  FillHoles();
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
  if (IsFirst(table_.population(row)) != IsFirst(population)) row = MoveToOtherPart(row);
  Leave(row);
  Enter(row, population);
  return row;
}

void ProxyKind::EnsureRoomIn(uint8_t population, size_t newcomers) {
  if (trees_[population] == nullptr) trees_[population] = std::make_unique<BoxTree>();
  trees_[population]->EnsureRoomFor(newcomers);
}

// Returns the row of a hole, one of the first rows or behind them. Makes one if there is none.
uint32_t ProxyKind::TakeHole(bool is_first) {
  if (is_first && table_.hole_count() > 0) return table_.LowestHole();
  const uint32_t last = table_.AppendHole();
  if (!is_first) return last;
  Exchange(first_row_count_, last);
  return first_row_count_++;
}

// Moves the last of the first rows to holes, and the last of the other rows to these, until there
// are few holes.
void ProxyKind::FillHoles() {
  while (table_.hole_count() * kFirstRowsPerHole > first_row_count_) {
    Exchange(table_.LowestHole(), --first_row_count_);
    Exchange(first_row_count_, table_.row_count() - 1);
    table_.RemoveLastRow();
  }
}

// Moves a proxy from the first rows to the others or back. Returns its new row.
uint32_t ProxyKind::MoveToOtherPart(uint32_t row) {
  if (row < first_row_count_) {
    const uint32_t id = table_.id(row);
    Exchange(row, --first_row_count_);
    FillHoles();
    return table_.RowOf(id);
  }
  if (table_.hole_count() == 0) {
    Exchange(row, first_row_count_);
    return first_row_count_++;
  }
  const uint32_t hole = table_.LowestHole();
  Exchange(row, hole);
  Exchange(row, table_.row_count() - 1);
  table_.RemoveLastRow();
  return hole;
}

// Exchanges the content of two rows.
void ProxyKind::Exchange(uint32_t a, uint32_t b) {
  if (a == b) return;
  table_.Swap(a, b);
  for (const uint32_t row : {a, b}) {
    if (!table_.is_hole(row)) trees_[table_.population(row)]->Rename(table_.slots()[row], row);
  }
}

// Adds a proxy to a population and its tree.
void ProxyKind::Enter(uint32_t row, uint8_t population) {
  const CollisionFilter& filter = table_.filters()[row];
  CollisionFilter& all = all_[population];
  if (trees_[population]->count() == 0) all = {0, 0};
  all.category |= filter.category;
  all.mask |= filter.mask;
  table_.SetPopulation(row, population);
  trees_[population]->Add(row, table_.slots());
  NoteChange(population);
}

// Removes a proxy from its population and its tree.
void ProxyKind::Leave(uint32_t row) {
  const uint8_t population = table_.population(row);
  trees_[population]->Remove(table_.slots()[row]);
  NoteChange(population);
}

void ProxyKind::ShiftOrigin(const float offset[3]) {
  for (uint32_t row = 0; row < table_.row_count(); ++row) {
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
    if (tree != nullptr) tree->FreeUnused(table_.slots());
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
