// Tables of the bench's page whose columns are its cells: scenes, and below them object counts.
// Pure functions, safe from any thread.
#pragma once

#include <string>
#include <vector>

#include "engine_client/cli/bench/bench_html_index.h"
#include "engine_client/cli/html/table.h"

namespace sweepstake::cli {

// The two lines above the columns.
std::vector<std::vector<html::TableCell>> CellHead(const BenchIndex& index,
                                                   const std::string& corner);

// Draws a line before the first cell of each scene. REQUIRES: `row` ends with a column per cell.
void SeparateScenes(const BenchIndex& index, std::vector<html::TableCell>& row);

// What stands where nothing was measured.
html::TableCell NoValue();

}  // namespace sweepstake::cli
