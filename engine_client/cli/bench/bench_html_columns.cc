#include "engine_client/cli/bench/bench_html_columns.h"

#include "engine_client/cli/bench/bench_html_words.h"
#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli {

std::vector<std::vector<html::TableCell>> CellHead(const BenchIndex& index,
                                                   const std::string& corner) {
  std::vector<html::TableCell> scenes{{html::Markup()}}, counts{{corner}};
  for (const SceneCells& scene : index.scenes()) {
    const BenchReport& report = index.report();
    scenes.push_back(
        {SceneTitle(report, report.cells[scene.cells.front()]), "first", scene.cells.size()});
    for (const size_t cell : scene.cells) {
      counts.push_back({html::Grouped(report.cells[cell].object_count),
                        cell == scene.cells.front() ? "first" : ""});
    }
  }
  return {scenes, counts};
}

void SeparateScenes(const BenchIndex& index, std::vector<html::TableCell>& row) {
  size_t column = row.size() - index.cells().size();
  for (const SceneCells& scene : index.scenes()) {
    row[column].css_class += row[column].css_class.empty() ? "first" : " first";
    column += scene.cells.size();
  }
}

html::TableCell NoValue() { return {"–", "none"}; }

}  // namespace sweepstake::cli
