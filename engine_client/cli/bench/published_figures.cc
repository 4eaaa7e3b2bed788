#include "engine_client/cli/bench/published_figures.h"

#include <algorithm>
#include <array>

namespace sweepstake::cli {
namespace {

struct PublishedCell {
  std::string_view scene;
  uint32_t object_count;
};

constexpr std::array<PublishedCell, 11> kCells{{
    {"suite-b", 1'000},
    {"suite-b", 3'000},
    {"suite-b", 10'000},
    {"suite-b", 100'000},
    {"suite-b", 1'000'000},
    {"suite-g", 1'000},
    {"suite-g", 10'000},
    {"suite-g", 100'000},
    {"suite-h", 1'000},
    {"suite-h", 10'000},
    {"suite-h", 100'000},
}};

struct PublishedRow {
  std::string_view peer;
  std::array<double, kCells.size()> ms;  // 0: not measured
};

constexpr PublishedRow kRows[] = {
    {"PhysxAbp", {.084, .267, 1.00, 21.0, 861, .318, 5.50, 99, .108, 1.34, 27.3}},
    {"PhysxMbp", {.083, .296, 1.22, 40.8, 0, .343, 7.68, 249, .118, 1.74, 48.5}},
    {"PhysxSap", {.399, 1.89, 12.2, 0, 0, .500, 28.2, 0, .508, 28.5, 0}},
    {"BroadmarkBruteForce", {.147, 1.14, 11.7, 0, 0, .355, 15.0, 0, .152, 12.3, 0}},
    {"BroadmarkGrid", {.175, .532, 1.94, 22.7, 0, .457, 6.75, 56.7, .214, 2.52, 26.8}},
    {"BroadmarkSap", {.106, .424, 2.39, 77.7, 0, .254, 4.65, 94.6, .117, 2.49, 79.4}},
    {"BroadmarkTracy", {.716, 2.46, 9.48, 149, 0, 3.48, 72.6, 826, 1.48, 39.8, 1064}},
    {"BroadmarkKdTree", {.201, .720, 2.65, 32.1, 413, .318, 5.90, 67.8, .225, 3.34, 42.9}},
    {"JoltQuadtree", {.383, 1.25, 4.78, 92.2, 0, .864, 12.7, 213, .449, 5.96, 99.4}},
    {"Embree", {.297, .752, 2.50, 26.4, 419, .826, 9.03, 72.3, .335, 3.22, 31.6}},
    {"BulletDbvtDeferred", {.441, 1.54, 5.93, 182, 0, 1.25, 19.4, 412, .566, 8.14, 174}},
};

constexpr PublishedPeer kPeers[] = {
    {"PhysxAbp", ""},
    {"PhysxMbp", "Tracy"},
    {"PhysxSap", "AxisSweep"},
    {"BroadmarkBruteForce", "BruteForce"},
    {"BroadmarkGrid", "Grid"},
    {"BroadmarkSap", "SAP"},
    {"BroadmarkTracy", "Tracy"},
    {"BroadmarkKdTree", "KDTree"},
    {"JoltQuadtree", "DBVT"},
};

}  // namespace

std::span<const PublishedPeer> PublishedPeers() { return kPeers; }

std::optional<double> PublishedFigure(std::string_view peer, std::string_view scene,
                                      uint32_t object_count) {
  const auto row = std::find_if(std::begin(kRows), std::end(kRows),
                                [&](const PublishedRow& each) { return each.peer == peer; });
  if (row == std::end(kRows)) return std::nullopt;
  for (size_t i = 0; i < kCells.size(); ++i) {
    if (kCells[i].scene != scene || kCells[i].object_count != object_count) continue;
    return row->ms[i] > 0 ? std::optional(row->ms[i]) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace sweepstake::cli
