#include "tests/laboratory/experiment/paper_tables.h"

#include <algorithm>

namespace sweepstake::cli {
namespace {

constexpr std::array<PaperCell, 9> kCells{{
    {"brownian",
     1000,
     "AxisSweep 5/5",
     "Stable sweep-based preference.",
     "AxisSweep",
     5,
     {20.2, 0.8},
     {45.5, 6.3},
     {0.977, 0.007},
     {196.4, 27.5}},
    {"brownian",
     2000,
     "AxisSweep 5/5",
     "Stable sweep-based preference.",
     "AxisSweep",
     5,
     {12.2, 2.8},
     {67.8, 7.0},
     {0.967, 0.004},
     {295.8, 32.3}},
    {"brownian",
     3000,
     "KDTree 3/5; AxisSweep 2/5",
     "Transitional workload between sweeping and hierarchy.",
     "KDTree",
     3,
     {16.0, 2.1},
     {52.9, 6.9},
     {0.900, 0.023},
     {203.0, 35.5}},
    {"rotating-gravity",
     1000,
     "SAP 3/5; AxisSweep 2/5",
     "Ambiguous low-density cyclic workload.",
     "SAP",
     3,
     {20.0, 1.2},
     {42.3, 2.9},
     {0.905, 0.006},
     {179.0, 13.0}},
    {"rotating-gravity",
     2000,
     "AxisSweep 5/5",
     "Stable sweep-based preference under cyclic motion.",
     "AxisSweep",
     5,
     {9.8, 1.5},
     {60.4, 8.8},
     {0.807, 0.113},
     {164.4, 35.3}},
    {"rotating-gravity",
     3000,
     "KDTree 5/5",
     "Stable hierarchical preference under dense cyclic clustering.",
     "KDTree",
     5,
     {11.2, 1.5},
     {44.7, 9.2},
     {0.244, 0.008},
     {63.6, 16.3}},
    {"hurricane",
     1000,
     "AxisSweep 5/5",
     "Stable sweep-based preference.",
     "AxisSweep",
     5,
     {21.0, 0.0},
     {41.2, 2.2},
     {0.970, 0.006},
     {176.2, 9.0}},
    {"hurricane",
     2000,
     "AxisSweep 5/5",
     "Strong stable sweep-based preference.",
     "AxisSweep",
     5,
     {6.6, 1.7},
     {82.5, 3.9},
     {0.954, 0.004},
     {355.8, 21.3}},
    {"hurricane",
     3000,
     "KDTree 5/5",
     "Stable hierarchical preference at high density.",
     "KDTree",
     5,
     {8.8, 1.8},
     {72.0, 6.1},
     {0.831, 0.025},
     {245.0, 40.7}},
}};

}  // namespace

std::span<const PaperCell> PaperCells() { return kCells; }

const PaperCell* FindPaperCell(std::string_view scene, uint32_t object_count) {
  const auto cell = std::find_if(kCells.begin(), kCells.end(), [&](const PaperCell& each) {
    return each.scene == scene && each.object_count == object_count;
  });
  return cell == kCells.end() ? nullptr : &*cell;
}

}  // namespace sweepstake::cli
