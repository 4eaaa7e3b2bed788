#include "engine_client/cli/io/screen.h"

namespace sweepstake::cli {
namespace {

constexpr char kDefaultColour[] = "\x1b[39m";
constexpr char kEnterAlternateScreen[] = "\x1b[?1049h\x1b[?25l";  // and hide the cursor
constexpr char kLeaveAlternateScreen[] = "\x1b[?25h\x1b[?1049l";
constexpr char kHome[] = "\x1b[H";
constexpr char kClearRestOfLine[] = "\x1b[K";
constexpr char kClearRestOfScreen[] = "\x1b[J";

std::string ColourSequence(Colour colour) {
  return colour == 0 ? kDefaultColour : "\x1b[38;5;" + std::to_string(colour) + "m";
}

bool ContinuesCharacter(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

bool IsControl(char byte) { return static_cast<unsigned char>(byte) < 0x20 || byte == 0x7F; }

}  // namespace

ScreenGrid::ScreenGrid(ScreenSize size) : size_(size), cells_(size.columns * size.rows) {}

void ScreenGrid::Put(size_t row, size_t column, std::string_view text, Colour colour) {
  if (row >= size_.rows) return;
  for (size_t at = 0; at < text.size() && column < size_.columns; ++column) {
    size_t end = at + 1;
    while (end < text.size() && ContinuesCharacter(text[end])) ++end;
    Cell& cell = cells_[row * size_.columns + column];
    cell.character = IsControl(text[at]) ? "?" : text.substr(at, end - at);
    cell.colour = colour;
    at = end;
  }
}

std::string ScreenGrid::Text(bool has_colours) const {
  std::string text;
  Colour colour = 0;
  for (size_t row = 0; row < size_.rows; ++row) {
    if (row > 0) text += '\n';
    size_t blank_count = 0;
    for (size_t column = 0; column < size_.columns; ++column) {
      const Cell& cell = cells_[row * size_.columns + column];
      if (cell.character == " ") {
        ++blank_count;
        continue;
      }
      text.append(blank_count, ' ');
      blank_count = 0;
      if (has_colours && cell.colour != colour) text += ColourSequence(colour = cell.colour);
      text += cell.character;
    }
  }
  if (colour != 0) text += kDefaultColour;
  return text;
}

void FullScreen::Enter() { out_ << kEnterAlternateScreen << std::flush; }

void FullScreen::Leave() { out_ << kLeaveAlternateScreen << std::flush; }

void FullScreen::Draw(std::string_view text) {
  std::string output = kHome;
  for (const char byte : text) {
    if (byte == '\n') output += kClearRestOfLine;
    output += byte;
  }
  out_ << output << kClearRestOfLine << kClearRestOfScreen << std::flush;
}

}  // namespace sweepstake::cli
