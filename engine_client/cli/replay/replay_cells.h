// A list of scenes to replay, as tests/bench keeps two of: one for tuning, one only for the final
// figures.
//
// A line each of six words: scene, objects, frames, seed, pass (virtual time of one pass through
// the trace), category. Empty lines and what follows a # are left out. The trace of a cell is
// SCENE-OBJECTS-SEED.costs in one folder, as `sweepstake trace --out FOLDER` names it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <string>
#include <string_view>
#include <vector>

#include "sweepstake/status.h"

namespace sweepstake::cli {

enum class CellCategory {
  kStationary,  // one arm is the best all the time
  kChanging,    // which arm is the best changes, each time for twice the cooldown or longer
  kResonant,    // it changes more often than the cooldown lets a policy follow
};
std::string_view CategoryName(CellCategory category);

struct ReplayCell {
  std::string scene;
  uint32_t object_count = 0;
  uint32_t frame_count = 0;
  uint64_t seed = 0;
  uint64_t pass_ns = 0;
  CellCategory category = CellCategory::kStationary;

  // The file's name without folder and ".costs".
  std::string name() const;
};

// kInvalidArgument names the line and what is valid there.
Result<std::vector<ReplayCell>> ParseCells(std::istream& text);
// kNotFound: no such file.
Result<std::vector<ReplayCell>> ReadCells(const std::filesystem::path& path);

}  // namespace sweepstake::cli
