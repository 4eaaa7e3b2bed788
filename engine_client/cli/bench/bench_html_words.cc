#include "engine_client/cli/bench/bench_html_words.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <utility>

#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli {
namespace {

using Word = std::pair<std::string_view, std::string_view>;

constexpr std::array<Word, 5> kFamilyTitles{{{"BruteForce", "Brute force"},
                                             {"SAP", "Sweep and prune (SAP)"},
                                             {"AxisSweep", "Incremental sweep (AxisSweep)"},
                                             {"DBVT", "Dynamic tree (DBVT)"},
                                             {"KDTree", "KD-tree"}}};

constexpr std::array<Word, 25> kSceneNotes{{
    {"suite-b",
     "Brownian motion: every box jitters about its place. Evenly filled space, few pairs."},
    {"suite-g",
     "Rotating gravity: all boxes fall together and pile up at the walls. Crowded, many pairs."},
    {"suite-h", "Hurricane: boxes circle an axis at different speeds."},
    {"brownian", "Boxes that jitter about their places."},
    {"rotating-gravity", "Boxes that fall towards a direction that turns."},
    {"hurricane", "Boxes that circle an axis."},
    {"free-fall", "Boxes that fall and rest."},
    {"nearly-resting",
     "Boxes that move by ±0.001 in a frame: what an incremental structure is for."},
    {"few-moving", "One box in a hundred moves in a frame."},
    {"beams", "Boxes ten to 160 times as long as they are thin."},
    {"long-thin", "Boxes half as long as the world, and longer."},
    {"clusters", "Moving clusters of boxes with empty space between them."},
    {"planar", "All boxes near one plane."},
    {"sizes-1-to-1000", "The largest box is a thousand times as large as the smallest."},
    {"all-coincident", "Every box overlaps every other."},
    {"teleporting", "Boxes that jump to other places."},
    {"spawning", "Boxes come and go."},
    {"count-changing", "Every frame has another number of boxes."},
    {"rest-and-motion", "Boxes that hardly move, then jitter, in turn."},
    {"waves", "Few boxes, then many that jump to other places, then many that hardly move."},
    {"storms", "Boxes that jump to other places, then jitter, in turn."},
    {"gather-and-scatter", "Boxes that gather, rest, scatter and rest."},
    {"day-and-night", "Boxes that circle an axis; then one in a hundred moves."},
    {"arrivals", "Boxes come and go; then all rest; then all fly straight on."},
    {"random-gravity", "Boxes that fall towards a direction that changes at random."},
}};

template <size_t kCount>
std::string Look(const std::array<Word, kCount>& words, std::string_view key,
                 std::string_view otherwise) {
  const auto found =
      std::find_if(words.begin(), words.end(), [&](const Word& word) { return word.first == key; });
  return std::string(found == words.end() ? otherwise : found->second);
}

std::string FileName(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

}  // namespace

std::string Milliseconds(double ms) { return html::Significant(ms, 3); }

std::string Times(double ratio) { return html::Significant(ratio, 3) + "×"; }

std::string FamilyTitle(const std::string& family) { return Look(kFamilyTitles, family, family); }

std::string SceneTitle(const BenchReport& report, const BenchCell& cell) {
  if (!cell.is_file) return cell.scene;
  const std::string name = FileName(cell.scene);
  const bool ambiguous =
      std::any_of(report.cells.begin(), report.cells.end(), [&](const BenchCell& other) {
        return other.scene != cell.scene && FileName(other.scene) == name;
      });
  return ambiguous ? cell.scene : name;
}

std::string SceneNote(const std::string& scene) { return Look(kSceneNotes, scene, ""); }

std::string CellTitle(const BenchReport& report, size_t cell) {
  const BenchCell& which = report.cells[cell];
  return SceneTitle(report, which) + ", " + html::Grouped(which.object_count) + " objects";
}

std::string ContestantTitle(const std::string& name, uint32_t thread_count) {
  return thread_count == 1 ? name : name + " (" + std::to_string(thread_count) + " threads)";
}

bool LargeIsGood(RatioKind kind) {
  return kind == RatioKind::kFamily || kind == RatioKind::kOverall || kind == RatioKind::kThreads;
}

html::Markup Verdict(const BenchRatio& ratio) {
  if (!ratio.goal) return {};
  // Memory is held against bytes, which `other` names.
  const std::string bound =
      ratio.kind == RatioKind::kMemory ? ratio.other : html::Compact(*ratio.goal) + "×";
  const std::string goal = (LargeIsGood(ratio.kind) ? " (≥ " : " (≤ ") + bound + ")";
  return html::Element("small", {{"class", ratio.met ? "verdict met" : "verdict missed"}},
                       (ratio.met ? "✓ met" : "✗ missed") + goal);
}

std::string VerdictClass(const BenchRatio& ratio) {
  if (!ratio.goal) return "";
  return ratio.met ? "met" : "missed";
}

}  // namespace sweepstake::cli
