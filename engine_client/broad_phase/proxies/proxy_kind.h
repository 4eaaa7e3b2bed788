// The proxies of one kind, added as moving ones or as static ones, in populations.
//
// A population is the proxies that take part in the search in the same way: they move, sleep or are
// static, and, while they are not static, belong to the same group (populations.h). Each
// population has a tree of its own, in which queries find it and in which other populations are
// searched for. Population 0 is what the broad phase gets, of the proxies added as moving ones.
//
// Thread safety: const calls may run side by side. Owns its memory. Cost and memory: see
// proxy_table.h and box_tree.h; a population takes none until it has had a proxy. Errors:
// std::bad_alloc from Add and ChangePopulation, which then change nothing, and from RefreshTrees,
// after which the next one tries again.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "engine_client/broad_phase/proxies/box_tree.h"
#include "engine_client/broad_phase/proxies/populations.h"
#include "engine_client/broad_phase/proxies/proxy_table.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

class ProxyKind {
 public:
  // `id_bit` is set in the ids of all proxies of this kind; `notes_owners` as in ProxyTable.
  ProxyKind(uint32_t id_bit, bool notes_owners) : table_(notes_owners), id_bit_(id_bit) {}

  uint32_t id_bit() const { return id_bit_; }
  const ProxyTable& table() const { return table_; }
  // Returns null if the place is free.
  ProxyHandle HandleAt(uint32_t place) const {
    const uint32_t generation = table_.generation(place);
    return generation == 0 ? ProxyHandle{} : ProxyHandle{place | id_bit_, generation};
  }

  // Allocates what Add and ChangePopulation to this population need.
  // For so many that are to enter the population.
  void EnsureRoomIn(uint8_t population, size_t newcomers = 1);
  // Returns the place of the new proxy.
  uint32_t Add(const Aabb& box, const CollisionFilter& filter, uint64_t user, uint8_t population);
  void Remove(uint32_t place);
  void SetBox(uint32_t place, const Aabb& box) {
    const uint8_t population = table_.population(place);
    table_.SetBox(place, box);
    NoteChange(population);
    // Where one moves all are expected to.
    if (MovesIn(population)) {
      moved_ |= 1U << population;
    } else {
      trees_[population]->Move(table_.slots()[place]);
    }
  }
  void SetFilter(uint32_t place, const CollisionFilter& filter);
  void SetUser(uint32_t place, uint64_t user) { table_.SetUser(place, user); }
  void ChangePopulation(uint32_t place, uint8_t population);
  void MarkSeen() { table_.MarkSeen(); }

  size_t count(uint32_t population) const {
    return trees_[population] == nullptr ? 0 : trees_[population]->count();
  }
  // Returns the categories and masks that the population's proxies have had.
  const CollisionFilter& all(uint32_t population) const { return all_[population]; }

  // Must be called after changes and before the trees are used.
  void RefreshTrees(KdOrder& splitter);
  // Moves the origin of all coordinates. Invalid boxes stay as they are.
  void ShiftOrigin(const float offset[3]);
  // Frees what former proxies held; free places below `min_places` are kept. Changes nothing if
  // memory runs out.
  void Compact(size_t min_places);
  bool trees_are_fresh() const { return changed_ == 0; }
  // REQUIRES, here and below: count(population) > 0.
  const LeafTree& tree(uint32_t population) const { return trees_[population]->leaves(); }
  void NoteSearch(uint32_t population, uint64_t checks) { trees_[population]->NoteSearch(checks); }

  // Returns whether a box, a filter or the members of a population that does not move have changed
  // since MarkRestingSeen.
  bool any_resting_changed() const { return resting_changed_; }
  void MarkRestingSeen() { resting_changed_ = false; }

  // The fields of a snapshot (snapshot.h). FinishRestore must follow.
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive) {
    ProxyTable::Visit(self.table_, archive);
    for (auto& tree : self.trees_) {
      bool exists = tree != nullptr;
      archive.Value(exists);
      self.MatchTree(tree, exists);
      if (exists) BoxTree::Visit(*tree, archive);
    }
    archive.Value(self.all_);
    archive.Value(self.changed_);
    archive.Value(self.moved_);
    archive.Value(self.resting_changed_);
  }
  void FinishRestore();

  uint64_t refit_count() const { return refit_count_; }
  size_t native_bytes() const;

 private:
  // Makes or drops the tree as the snapshot has it.
  static void MatchTree(std::unique_ptr<BoxTree>& tree, bool exists) {
    if (exists != (tree != nullptr)) tree = exists ? std::make_unique<BoxTree>() : nullptr;
  }
  static void MatchTree(const std::unique_ptr<BoxTree>& /*saved*/, bool /*exists*/) {}
  void Enter(uint32_t place, uint8_t population);
  void Leave(uint32_t place);
  void NoteChange(uint8_t population) {
    changed_ |= 1U << population;
    resting_changed_ |= !MovesIn(population);
  }

  ProxyTable table_;
  std::array<std::unique_ptr<BoxTree>, kPopulations> trees_;
  std::array<CollisionFilter, kPopulations> all_{};
  uint32_t changed_ = 0;  // the populations whose trees are out of date, as bits
  uint32_t moved_ = 0;    // those of which any box may have changed
  bool resting_changed_ = false;
  uint32_t id_bit_;
  uint64_t refit_count_ = 0;
};

}  // namespace sweepstake
