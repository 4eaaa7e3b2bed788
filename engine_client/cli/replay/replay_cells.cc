#include "engine_client/cli/replay/replay_cells.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>

#include "engine_client/cli/io/duration.h"

namespace sweepstake::cli {
namespace {

constexpr std::array<std::string_view, 3> kCategories = {"stationary", "changing", "resonant"};

Status Unfit(size_t line, const std::string& problem) {
  return {StatusCode::kInvalidArgument, "line " + std::to_string(line) + " " + problem};
}

template <typename Number>
bool ReadWhole(const std::string& word, Number& number) {
  const char* end = word.data() + word.size();
  const auto [rest, error] = std::from_chars(word.data(), end, number);
  return error == std::errc() && rest == end && number > 0;
}

std::vector<std::string> WordsOf(const std::string& line) {
  std::istringstream text(line.substr(0, line.find('#')));
  return {std::istream_iterator<std::string>(text), {}};
}

Result<ReplayCell> ParseCell(const std::vector<std::string>& words, size_t line) {
  if (words.size() != 6) {
    return Unfit(line, "has " + std::to_string(words.size()) +
                           " words; give scene, objects, frames, seed, pass and category");
  }
  ReplayCell cell;
  cell.scene = words[0];
  if (!ReadWhole(words[1], cell.object_count) || !ReadWhole(words[2], cell.frame_count) ||
      !ReadWhole(words[3], cell.seed)) {
    return Unfit(line, "needs whole numbers from 1 for objects, frames and seed");
  }
  const auto pass = ParseDuration(words[4]);
  if (!pass.ok()) return Unfit(line, "has a pass that is none: " + pass.status().message());
  cell.pass_ns = *pass;
  const auto category = std::find(kCategories.begin(), kCategories.end(), words[5]);
  if (category == kCategories.end()) {
    return Unfit(line, "has the category '" + words[5] + "'; use stationary, changing, resonant");
  }
  cell.category = static_cast<CellCategory>(category - kCategories.begin());
  return cell;
}

}  // namespace

std::string_view CategoryName(CellCategory category) {
  return kCategories[static_cast<size_t>(category)];
}

std::string ReplayCell::name() const {
  return std::filesystem::path(scene).stem().string() + "-" + std::to_string(object_count) + "-" +
         std::to_string(seed);
}

Result<std::vector<ReplayCell>> ParseCells(std::istream& text) {
  std::vector<ReplayCell> cells;
  std::string line;
  for (size_t number = 1; std::getline(text, line); ++number) {
    const std::vector<std::string> words = WordsOf(line);
    if (words.empty()) continue;
    const auto cell = ParseCell(words, number);
    if (!cell.ok()) return cell.status();
    cells.push_back(*cell);
  }
  if (cells.empty()) return Status(StatusCode::kInvalidArgument, "there is no scene in the list");
  return cells;
}

Result<std::vector<ReplayCell>> ReadCells(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) return Status(StatusCode::kNotFound, path.string() + " cannot be read");
  auto cells = ParseCells(file);
  if (cells.ok()) return cells;
  return Status(cells.status().code(), path.string() + ": " + cells.status().message());
}

}  // namespace sweepstake::cli
