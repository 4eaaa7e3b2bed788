// The proxies of one kind, divided into populations. A proxy's kind, moving or static, is the state
// in which it was added.
//
// The proxies of a population take part in the search in the same way: they move, sleep or are
// static. Unless static, they also belong to the same group (populations.h). Each population has a
// tree, which queries and searches for pairs with other populations use. The pairs within
// population 0 of the moving kind are found by the broad phase.
//
// The broad phase gets the first rows of the moving kind's table, in which only population 0 is. Up
// to 1 in 32 of these rows is a hole, which a new proxy fills. Without holes, a proxy that replaces
// another one would change two rows instead of one, and a broad phase that uses temporal coherence
// would do twice the work. More holes are filled with the last proxies. The other rows have no
// holes. All rows of the static kind are first rows.
//
// Thread safety: const calls may run at the same time. Owns its memory. Cost and memory: see
// proxy_table.h and box_tree.h; a population takes no memory until it has had a proxy. Errors:
// std::bad_alloc from Add, ChangePopulation, FreeUnused and ShrinkRows, which then change nothing,
// and from RefreshTrees, after which the next call tries again.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "engine_client/broad_phase/proxies/box_tree.h"
#include "engine_client/broad_phase/proxies/populations.h"
#include "engine_client/broad_phase/proxies/proxy_table.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

class ProxyKind {
 public:
  // `id_bit` is set in the ids of all proxies of this kind.
  explicit ProxyKind(uint32_t id_bit) : table_(id_bit) {}

  uint32_t id_bit() const { return table_.id_bit(); }
  const ProxyTable& table() const { return table_; }
  // Returns the boxes of population 0, and invalid boxes. REQUIRES: this is the moving kind.
  std::span<const Aabb> searched_boxes() const { return table_.boxes().first(first_row_count_); }

  // Allocates the memory that Add and ChangePopulation need for `newcomers` proxies to enter this
  // population.
  void EnsureRoomIn(uint8_t population, size_t newcomers = 1);
  // Adds a proxy and returns its row in the table.
  uint32_t Add(const Aabb& box, const CollisionFilter& filter, uint64_t user, uint8_t population);
  void Remove(uint32_t row);
  void SetBox(uint32_t row, const Aabb& box) {
    const uint8_t population = table_.population(row);
    table_.SetBox(row, box);
    NoteChange(population);
    // If one proxy of a moving population moves, all are expected to move. RefreshTrees then refits
    // the whole tree.
    if (MovesIn(population)) {
      moved_ |= 1U << population;
    } else {
      trees_[population]->Move(table_.slots()[row]);
    }
  }
  void SetFilter(uint32_t row, const CollisionFilter& filter);
  void SetUser(uint32_t row, uint64_t user) { table_.SetUser(row, user); }
  // Returns the proxy's new row.
  uint32_t ChangePopulation(uint32_t row, uint8_t population);
  void MarkSeen() { table_.MarkSeen(); }

  size_t count(uint32_t population) const {
    return trees_[population] == nullptr ? 0 : trees_[population]->count();
  }
  // Returns the union of the categories and masks of the population's present and past proxies.
  const CollisionFilter& all(uint32_t population) const { return all_[population]; }

  // Updates the trees. Must be called after changes and before the trees are used.
  void RefreshTrees(KdOrder& splitter);
  // Moves the origin of all coordinates. Invalid boxes stay unchanged.
  void ShiftOrigin(const float offset[3]);
  // Frees the memory that was not needed since the previous call, except that of the rows. Returns
  // whether fewer than half as many rows were needed as before that.
  bool FreeUnused();
  // Frees the memory of rows that were not needed (ProxyTable::ShrinkRows).
  void ShrinkRows() { table_.ShrinkRows(); }
  bool trees_are_fresh() const { return changed_ == 0; }
  // Returns the tree of a population. REQUIRES, here and in NoteSearch: count(population) > 0.
  const LeafTree& tree(uint32_t population) const { return trees_[population]->leaves(); }
  void NoteSearch(uint32_t population, uint64_t checks) { trees_[population]->NoteSearch(checks); }

  // Returns whether a sleeping or static population has changed since MarkRestingSeen: a box, a
  // filter or its members.
  bool any_resting_changed() const { return resting_changed_; }
  void MarkRestingSeen() { resting_changed_ = false; }

  // Passes the fields of a snapshot to `archive` (snapshot.h). FinishRestore must follow a restore.
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive) {
    ProxyTable::Visit(self.table_, archive);
    for (auto& tree : self.trees_) {
      bool exists = tree != nullptr;
      archive.Value(exists);
      self.MatchTree(tree, exists);
      if (exists) BoxTree::Visit(*tree, archive);
    }
    archive.Value(self.first_row_count_);
    archive.Value(self.all_);
    archive.Value(self.changed_);
    archive.Value(self.moved_);
    archive.Value(self.resting_changed_);
  }
  void FinishRestore();

  uint64_t refit_count() const { return refit_count_; }
  size_t native_bytes() const;

 private:
  // Creates an empty tree or deletes the present one, so that a tree exists if the snapshot
  // contains one.
  static void MatchTree(std::unique_ptr<BoxTree>& tree, bool exists) {
    if (exists != (tree != nullptr)) tree = exists ? std::make_unique<BoxTree>() : nullptr;
  }
  static void MatchTree(const std::unique_ptr<BoxTree>& /*saved*/, bool /*exists*/) {}
  // Returns whether the proxies of a population are in the first rows.
  bool IsFirst(uint8_t population) const { return id_bit() != 0 || population == 0; }
  uint32_t TakeHole(bool is_first);
  void FillHoles();
  uint32_t MoveToOtherPart(uint32_t row);
  void Exchange(uint32_t a, uint32_t b);
  void Enter(uint32_t row, uint8_t population);
  void Leave(uint32_t row);
  void NoteChange(uint8_t population) {
    changed_ |= 1U << population;
    resting_changed_ |= !MovesIn(population);
  }

  ProxyTable table_;
  uint32_t first_row_count_ = 0;
  std::array<std::unique_ptr<BoxTree>, kPopulations> trees_;
  std::array<CollisionFilter, kPopulations> all_{};
  uint32_t changed_ = 0;  // the populations whose trees are out of date, as bits
  uint32_t moved_ = 0;    // the populations in which any box may have changed
  bool resting_changed_ = false;
  uint64_t refit_count_ = 0;
};

}  // namespace sweepstake
