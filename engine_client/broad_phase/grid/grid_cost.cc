#include "engine_client/broad_phase/grid/grid_cost.h"

#include <algorithm>
#include <bit>
#include <cstdlib>

namespace sweepstake {
namespace {

// The relative costs of a search: per box that searches a grid, per row of cells that it reads and
// per box that it is tested against. With half or twice each value, the time of a frame changes by
// at most 5 % in scenes of mixed sizes, with AVX-512, AVX2 and SSE4 (AMD Zen 4, `sweepstake-lab
// bench`).
constexpr double kSearchCost = 4;
constexpr double kRowCost = 3;
constexpr double kTestCost = 0.3;
// The assumed mean side of a group's boxes, as a fraction of their maximum side.
constexpr double kMeanSide = 0.6;

struct Group {
  GroupShape shape;
  GroupGrid grid;
  uint64_t classes = 0;
};

// A list of at most one group per class, without allocation.
class Groups {
 public:
  void Add(const Group& group) { groups_[size_++] = group; }
  void Remove(size_t index) {
    std::copy(begin() + index + 1, end(), begin() + index);
    --size_;
  }
  size_t size() const { return size_; }
  Group& operator[](size_t index) { return groups_[index]; }
  const Group& operator[](size_t index) const { return groups_[index]; }
  Group* begin() { return groups_.data(); }
  Group* end() { return groups_.data() + size_; }

 private:
  std::array<Group, ShapeClasses::kCount> groups_;
  size_t size_ = 0;
};

double Extent(const CornerBounds& bounds, int axis) {
  return std::max(1e-30, bounds.high[axis] - bounds.low[axis]);
}

// Returns the estimated cost if all boxes of `from` search the grid of `into`.
double SearchCost(const CornerBounds& bounds, const Group& from, const Group& into) {
  double rows = 1;
  double share = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double side = 1 / static_cast<double>(into.grid.scale[axis]);
    const double span = kMeanSide * from.shape.max_side[axis] + into.shape.max_side[axis];
    const double cells = std::min<double>(into.grid.cells[axis], span / side + 1);
    if (axis != into.grid.row_axis) rows *= cells;
    share *= std::min(1.0, cells * side / Extent(bounds, axis));
  }
  return from.shape.count * (kSearchCost + kRowCost * rows + kTestCost * share * into.shape.count);
}

double OwnCost(const CornerBounds& bounds, const Group& group) {
  return SearchCost(bounds, group, group) / 2;
}

double PairCost(const CornerBounds& bounds, const Group& a, const Group& b) {
  return std::min(SearchCost(bounds, a, b), SearchCost(bounds, b, a));
}

Group Joined(const CornerBounds& bounds, const Group& a, const Group& b) {
  Group both;
  both.shape = a.shape;
  both.shape.Add(b.shape);
  both.classes = a.classes | b.classes;
  both.grid = MakeGroupGrid(bounds, both.shape, MaxCellCount(both.shape.count));
  return both;
}

// Returns the estimated cost that joining two groups saves.
double Saving(const CornerBounds& bounds, const Groups& groups, size_t a, size_t b) {
  const Group both = Joined(bounds, groups[a], groups[b]);
  double before = OwnCost(bounds, groups[a]) + OwnCost(bounds, groups[b]) +
                  PairCost(bounds, groups[a], groups[b]);
  double after = OwnCost(bounds, both);
  for (size_t k = 0; k < groups.size(); ++k) {
    if (k == a || k == b) continue;
    before += PairCost(bounds, groups[a], groups[k]) + PairCost(bounds, groups[b], groups[k]);
    after += PairCost(bounds, both, groups[k]);
  }
  return before - after;
}

void Join(const CornerBounds& bounds, Groups& groups, size_t a, size_t b) {
  groups[a] = Joined(bounds, groups[a], groups[b]);
  groups.Remove(b);
}

// Returns how different two shape classes are: the difference of their size steps (0 to 3) on each
// axis, summed over the axes.
int Distance(uint32_t a, uint32_t b) {
  int distance = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int shift = ShapeClasses::kBitsPerAxis * axis;
    distance += std::abs(static_cast<int>(a >> shift & 3) - static_cast<int>(b >> shift & 3));
  }
  return distance;
}

uint32_t FirstClass(const Group& group) {
  return static_cast<uint32_t>(std::countr_zero(group.classes));
}

// Joins the smallest group with the most similar other group until at most kMaxGridGroups are left.
// JoinWhereItSaves would take too long for more groups, since it compares all pairs of groups.
void JoinSmallest(const CornerBounds& bounds, Groups& groups) {
  while (groups.size() > kMaxGridGroups) {
    const auto smallest = std::min_element(
        groups.begin(), groups.end(),
        [](const Group& a, const Group& b) { return a.shape.count < b.shape.count; });
    const auto from = static_cast<size_t>(smallest - groups.begin());
    size_t into = from == 0 ? 1 : 0;
    for (size_t k = 0; k < groups.size(); ++k) {
      if (k == from) continue;
      const uint32_t own = FirstClass(groups[from]);
      if (Distance(own, FirstClass(groups[k])) < Distance(own, FirstClass(groups[into]))) into = k;
    }
    Join(bounds, groups, std::min(from, into), std::max(from, into));
  }
}

void JoinWhereItSaves(const CornerBounds& bounds, Groups& groups) {
  while (groups.size() > 1) {
    double best_saving = 0;
    size_t best_a = 0;
    size_t best_b = 0;
    for (size_t a = 0; a < groups.size(); ++a) {
      for (size_t b = a + 1; b < groups.size(); ++b) {
        const double saving = Saving(bounds, groups, a, b);
        if (saving <= best_saving) continue;
        best_saving = saving;
        best_a = a;
        best_b = b;
      }
    }
    if (best_saving <= 0) return;
    Join(bounds, groups, best_a, best_b);
  }
}

}  // namespace

size_t ChooseGroups(const CornerBounds& bounds, const GridMeasure& measure, uint64_t known_classes,
                    uint32_t (&group_of_class)[ShapeClasses::kCount],
                    std::array<uint32_t, kMaxGridGroups>& searches) {
  Groups groups;
  for (uint32_t k = 0; k < ShapeClasses::kCount; ++k) {
    if ((known_classes >> k & 1) == 0) continue;
    Group group;
    group.shape.Add(measure.shapes[k]);
    group.classes = uint64_t{1} << k;
    group.grid = MakeGroupGrid(bounds, group.shape, MaxCellCount(group.shape.count));
    groups.Add(group);
  }
  JoinSmallest(bounds, groups);
  JoinWhereItSaves(bounds, groups);
  std::fill_n(group_of_class, ShapeClasses::kCount, 0U);
  searches.fill(0);
  for (uint32_t g = 0; g < groups.size(); ++g) {
    for (uint32_t k = 0; k < ShapeClasses::kCount; ++k) {
      if ((groups[g].classes >> k & 1) != 0) group_of_class[k] = g;
    }
    for (uint32_t h = g + 1; h < groups.size(); ++h) {
      const bool g_searches =
          SearchCost(bounds, groups[g], groups[h]) <= SearchCost(bounds, groups[h], groups[g]);
      searches[g_searches ? g : h] |= 1U << (g_searches ? h : g);
    }
  }
  return groups.size();
}

}  // namespace sweepstake
