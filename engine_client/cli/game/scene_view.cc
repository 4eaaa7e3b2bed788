#include "engine_client/cli/game/scene_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engine_client/cli/io/standing_cells.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

// The dashboard's colours (colours.css), in the order of BroadPhaseNames(). They are readable on a
// dark and on a light background.
constexpr std::array<Colour, 7> kArmColours = {0, 39, 178, 208, 36, 176, 69};
constexpr Colour kGray = 244;
constexpr Colour kWorldColour = 240;

constexpr size_t kTableColumns = 35;
constexpr size_t kMinCanvasColumns = 26;
constexpr size_t kBarColumns = 9;

Colour ColourOf(size_t arm) { return kArmColours[arm % kArmColours.size()]; }

// Dots in the cells of a canvas: each cell has 2 × 4 dots, as the braille characters.
class Canvas {
 public:
  explicit Canvas(ScreenSize size) : size_(size), cells_(size.columns * size.rows) {}

  double width() const { return 2 * static_cast<double>(size_.columns); }
  double height() const { return 4 * static_cast<double>(size_.rows); }

  // Sets the dot at this place, if it is inside. A dot of a higher layer colours its cell.
  void Dot(double x, double y, uint8_t layer) {
    if (!(x >= 0 && x < width() && y >= 0 && y < height())) return;
    constexpr uint8_t kBits[4][2] = {{0x01, 0x08}, {0x02, 0x10}, {0x04, 0x20}, {0x40, 0x80}};
    const auto column = static_cast<size_t>(x);
    const auto row = static_cast<size_t>(y);
    Cell& cell = cells_[row / 4 * size_.columns + column / 2];
    cell.dots |= kBits[row % 4][column % 2];
    cell.layer = std::max(cell.layer, layer);
  }

  void PutOn(ScreenGrid& grid, size_t first_row, std::span<const Colour> layer_colours) const {
    for (size_t at = 0; at < cells_.size(); ++at) {
      if (cells_[at].dots == 0) continue;
      // U+2800 plus the bits of the dots, in UTF-8.
      const char braille[] = {'\xE2', static_cast<char>(0xA0 | cells_[at].dots >> 6),
                              static_cast<char>(0x80 | (cells_[at].dots & 0x3F)), '\0'};
      grid.Put(first_row + at / size_.columns, at % size_.columns, braille,
               layer_colours[cells_[at].layer]);
    }
  }

 private:
  struct Cell {
    uint8_t dots = 0;
    uint8_t layer = 0;
  };

  ScreenSize size_;
  std::vector<Cell> cells_;
};

struct Point {
  double x = 0;
  double y = 0;
};

// The isometric projection, before scaling.
Point Project(double x, double y, double z) {
  constexpr double kCos30 = 0.8660254037844386;
  return {(x - z) * kCos30, (x + z) / 2 - y};
}

// Returns a corner: bits 0, 1 and 2 of the index choose the maximum on x, y and z.
Point Corner(const Aabb& box, unsigned index) {
  const auto coordinate = [&](unsigned axis) {
    return (index >> axis & 1U) != 0 ? box.max[axis] : box.min[axis];
  };
  return Project(coordinate(0), coordinate(1), coordinate(2));
}

// Draws boxes on a canvas, on which the world has the largest size that fits.
class Camera {
 public:
  Camera(Canvas& canvas, const Aabb& world) : canvas_(canvas) {
    Point low = Corner(world, 0);
    Point high = low;
    for (unsigned index = 1; index < 8; ++index) {
      const Point corner = Corner(world, index);
      low = {std::min(low.x, corner.x), std::min(low.y, corner.y)};
      high = {std::max(high.x, corner.x), std::max(high.y, corner.y)};
    }
    constexpr double kMinExtent = 1e-30;  // a world without size is drawn as a point
    scale_ = std::min((canvas.width() - 1) / std::max(high.x - low.x, kMinExtent),
                      (canvas.height() - 1) / std::max(high.y - low.y, kMinExtent));
    origin_ = {canvas.width() / 2 - scale_ * (low.x + high.x) / 2,
               canvas.height() / 2 - scale_ * (low.y + high.y) / 2};
  }

  // Returns about how many dots the wire frame has.
  double DotCount(const Aabb& box) const {
    double sides = 0;
    for (int axis = 0; axis < 3; ++axis)
      sides += static_cast<double>(box.max[axis]) - box.min[axis];
    return 3 * scale_ * sides;
  }

  void DrawCentre(const Aabb& box, uint8_t layer) {
    const Point low = Corner(box, 0);
    const Point high = Corner(box, 7);
    const Point centre = OnCanvas({(low.x + high.x) / 2, (low.y + high.y) / 2});
    canvas_.Dot(centre.x, centre.y, layer);
  }

  // Draws the edges except the three that meet in the corner `hidden`. Of a box larger than the
  // canvas, it draws the centre only, because a long line takes long.
  void DrawEdges(const Aabb& box, unsigned hidden, uint8_t layer) {
    if (DotCount(box) > 9 * (canvas_.width() + canvas_.height())) return DrawCentre(box, layer);
    for (unsigned corner = 0; corner < 8; ++corner) {
      for (unsigned bit = 1; bit < 8; bit <<= 1) {
        const unsigned end = corner | bit;
        if (end == corner || corner == hidden || end == hidden) continue;
        DrawLine(OnCanvas(Corner(box, corner)), OnCanvas(Corner(box, end)), layer);
      }
    }
  }

 private:
  Point OnCanvas(Point point) const {
    return {origin_.x + scale_ * point.x, origin_.y + scale_ * point.y};
  }

  void DrawLine(Point from, Point to, uint8_t layer) {
    const int steps =
        1 + static_cast<int>(std::max(std::abs(to.x - from.x), std::abs(to.y - from.y)));
    for (int step = 0; step <= steps; ++step) {
      const double share = static_cast<double>(step) / steps;
      canvas_.Dot(from.x + share * (to.x - from.x), from.y + share * (to.y - from.y), layer);
    }
  }

  Canvas& canvas_;
  double scale_ = 1;
  Point origin_;
};

// The layers of the canvas. A cell has the colour of its highest layer.
enum Layer : uint8_t { kWorld, kAlone, kTouching, kLayerCount };

std::vector<Layer> LayersOf(const SceneView& view) {
  std::vector<Layer> layers(view.boxes.size(), kAlone);
  for (const OverlapPair& pair : view.pairs) layers[pair.a] = layers[pair.b] = kTouching;
  return layers;
}

void PutBoxes(const SceneView& view, size_t first_row, ScreenSize size, ScreenGrid& grid) {
  if (size.rows == 0 || size.columns == 0 || !IsValid(view.world)) return;
  Canvas canvas(size);
  Camera camera(canvas, view.world);
  constexpr unsigned kFarCorner = 0;
  constexpr unsigned kNearCorner = 7;
  camera.DrawEdges(view.world, kNearCorner, kWorld);
  double dot_count = 0;
  for (const Aabb& box : view.boxes) dot_count += IsValid(box) ? camera.DotCount(box) : 0;
  const bool draws_edges = dot_count <= canvas.width() * canvas.height() / 3;
  const std::vector<Layer> layers = LayersOf(view);
  for (size_t i = 0; i < view.boxes.size(); ++i) {
    if (!IsValid(view.boxes[i])) continue;
    if (draws_edges) {
      camera.DrawEdges(view.boxes[i], kFarCorner, layers[i]);
    } else {
      camera.DrawCentre(view.boxes[i], layers[i]);
    }
  }
  const std::array<Colour, kLayerCount> colours = {kWorldColour, kGray, ColourOf(view.active_arm)};
  canvas.PutOn(grid, first_row, colours);
}

// Returns a bar of `share` (0 to 1) of kBarColumns, in eighths of a column. NaN counts as 0.
std::string BlockBar(double share) {
  const double drawn = share > 0 ? std::min(share, 1.0) : 0;
  const auto eighths =
      static_cast<size_t>(std::lround(drawn * static_cast<double>(8 * kBarColumns)));
  std::string bar;
  for (size_t i = 0; i < eighths / 8; ++i) bar += "█";
  if (eighths % 8 != 0) bar += std::string("\xE2\x96") + static_cast<char>(0x90 - eighths % 8);
  return bar;
}

// Puts the arms, one per row: name, bar and number of P(best), cost ÷ the leader's cost.
void PutArms(const SceneView& view, size_t row, size_t column, ScreenGrid& grid) {
  grid.Put(row, column, "  arm        P(best)           cost", kGray);
  for (size_t arm = 0; arm < view.arms.size(); ++arm) {
    ++row;
    const Colour colour = ColourOf(arm);
    grid.Put(row, column, arm == view.active_arm ? "▶ " + view.arms[arm] : "  " + view.arms[arm],
             colour);
    const ArmStanding* standing = StandingOf(view.beliefs, view.arms[arm]);
    if (standing == nullptr) continue;
    grid.Put(row, column + 13, BlockBar(standing->best_probability), colour);
    grid.Put(row, column + 14 + kBarColumns, Fixed(standing->best_probability, 2), colour);
    if (standing->cost_ratio) {
      const std::string ratio = "×" + RatioText(standing->cost_ratio->median);
      grid.Put(row, column + kTableColumns - LetterCount(ratio), ratio, colour);
    }
  }
  ++row;
  grid.Put(++row, column, "cost: ratio to the leader's cost", kGray);
  grid.Put(++row, column, "coloured boxes touch another box", kGray);
}

std::string StatusText(const SceneView& view) {
  return view.arms[view.active_arm] + "  " + Fixed(view.detection_ms, 3) + " ms detection  " +
         std::to_string(view.pairs.size()) + (view.pairs.size() == 1 ? " pair  " : " pairs  ") +
         Fixed(view.frames_per_s, 0) + " frames/s";
}

std::string ReasonClause(const SwitchRow& row, const ArmStanding* standing) {
  if (row.trial_detection_time_ns > 0) return "the trial of " + row.from + " was too expensive";
  switch (row.reason) {
    case SwitchReason::kExploration:
      return "the policy measures " + row.to;
    case SwitchReason::kBailOut:
      return "a frame with " + row.from + " exceeded the bail-out limit";
    case SwitchReason::kManual:
      return "it was chosen manually";
    case SwitchReason::kPolicy:
      break;
  }
  if (standing == nullptr) return "the policy expects lower costs";
  return row.to + " is the best with probability " + Fixed(standing->best_probability, 2);
}

}  // namespace

std::string SceneViewText(const SceneView& view, ScreenSize size, bool has_colours) {
  const ScreenSize used = {std::max<size_t>(size.columns, 1) - 1, size.rows};
  ScreenGrid grid(used);
  grid.Put(0, 0, view.title);
  grid.Put(1, 0, StatusText(view), ColourOf(view.active_arm));
  const bool has_table = used.columns >= kTableColumns + kMinCanvasColumns;
  const ScreenSize canvas = {has_table ? used.columns - kTableColumns - 1 : used.columns,
                             std::max<size_t>(used.rows, 3) - 3};
  PutBoxes(view, 2, canvas, grid);
  if (has_table) PutArms(view, 3, canvas.columns + 1, grid);
  if (used.rows > 2) grid.Put(used.rows - 1, 0, view.message);
  return grid.Text(has_colours);
}

const ArmStanding* StandingOf(std::span<const ArmBelief> beliefs, std::string_view arm) {
  const auto belief = std::find_if(beliefs.begin(), beliefs.end(),
                                   [&](const ArmBelief& each) { return each.arm == arm; });
  return belief == beliefs.end() || !belief->standing ? nullptr : &*belief->standing;
}

std::string SwitchSentence(const SwitchRow& row, const ArmStanding* standing) {
  return Fixed(row.time_s, 1) + " s: " + row.from + " → " + row.to + ", because " +
         ReasonClause(row, standing);
}

}  // namespace sweepstake::cli
