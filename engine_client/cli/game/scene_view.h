// Draws a running scene as text for a terminal: the boxes in the scene's world, the active arm, and
// each arm's probability of being the best. Pure functions.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "engine_client/cli/game/run_summary.h"
#include "engine_client/cli/io/screen.h"
#include "sweepstake/aabb.h"
#include "sweepstake/embedded_decider.h"

namespace sweepstake::cli {

// The content of one drawing. The spans are borrowed.
struct SceneView {
  std::string title;  // the first line
  Aabb world{};       // bounds of the motion; nothing is drawn in bounds that are not finite
  std::span<const Aabb> boxes;
  std::span<const OverlapPair> pairs;  // of these boxes
  std::span<const std::string> arms;
  std::span<const ArmBelief> beliefs;  // of these arms, in any order; empty: nothing is known
  size_t active_arm = 0;
  double detection_ms = 0;  // per frame
  double frames_per_s = 0;
  std::string message;  // the last line
};

// Returns the text of a screen of this size: title, status, the boxes, message. A wide screen also
// has a table of the arms to the right of the boxes. One column stays free for the cursor.
//
// The boxes are seen from above at an angle: x points to the lower right, z to the lower left, y
// upwards. They are drawn as wire frames if these fill at most a third of the space, otherwise as
// points. Boxes that touch another box have the active arm's colour. Invalid boxes are left out.
std::string SceneViewText(const SceneView& view, ScreenSize size, bool has_colours);

// Returns the arm's standing, or null if it is unknown.
const ArmStanding* StandingOf(std::span<const ArmBelief> beliefs, std::string_view arm);

// Returns, for example, "12.3 s: BruteForce → KDTree, because KDTree is the best with probability
// 0.93". `standing` is the new arm's, or null.
std::string SwitchSentence(const SwitchRow& row, const ArmStanding* standing);

}  // namespace sweepstake::cli
