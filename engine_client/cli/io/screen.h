// Draws text with colours on a whole terminal screen.
#pragma once

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

// A colour of the terminal's 256-colour palette; 0: the terminal's own text colour.
using Colour = uint8_t;

// Characters with colours in rows and columns. Everything outside is cut off. Not thread-safe.
class ScreenGrid {
 public:
  explicit ScreenGrid(ScreenSize size);

  // Writes `text` (UTF-8, one column per character) from this place to the right. A control
  // character becomes '?', so that a file's name cannot control the terminal.
  void Put(size_t row, size_t column, std::string_view text, Colour colour = 0);
  // Returns the rows, separated by line breaks, without spaces at their ends. Without colours, the
  // text contains no escape sequences.
  std::string Text(bool has_colours) const;

 private:
  struct Cell {
    std::string character = " ";
    Colour colour = 0;
  };

  ScreenSize size_;
  std::vector<Cell> cells_;
};

// Takes the whole screen of a terminal and hides the cursor. Restores both, with the previous
// content of the screen, at the end of its life. The stream is borrowed. Not thread-safe.
class FullScreen {
 public:
  explicit FullScreen(std::ostream& out) : out_(out) { Enter(); }
  ~FullScreen() { Leave(); }
  FullScreen(const FullScreen&) = delete;
  FullScreen& operator=(const FullScreen&) = delete;

  // Replaces the content by `text`, the result of ScreenGrid::Text. Waits while the terminal does
  // not accept output.
  void Draw(std::string_view text);
  // Restores the terminal until Enter.
  void Leave();
  void Enter();

 private:
  std::ostream& out_;
};

}  // namespace sweepstake::cli
