#include "engine_client/cli/experiment/experiment_html.h"

#include <utility>

#include "engine_client/cli/experiment/experiment_html_cells.h"
#include "engine_client/cli/experiment/experiment_html_prose.h"
#include "engine_client/cli/experiment/experiment_html_runs.h"
#include "engine_client/cli/experiment/experiment_html_truth.h"
#include "engine_client/cli/experiment/experiment_html_words.h"
#include "engine_client/cli/html/page.h"

namespace sweepstake::cli {

using html::Markup;

std::string ExperimentHtml(const ExperimentReport& report, const std::string& json) {
  html::Page page{"Sweepstake experiment", ExperimentLead(report), {}};
  // A part that found nothing is left out with its explanation.
  const auto add = [&](const char* id, const char* heading, const char* explanation, Markup body) {
    if (body.empty()) return;
    if (*explanation != '\0') body = Paragraph(explanation) + body;
    page.sections.push_back({id, heading, std::move(body)});
  };
  add("summary", "Summary", "", ExperimentSummary(report));
  if (!report.cells.empty()) {
    add("dominant", "Who won where",
        "Each cell names the algorithm that was active longest, and in how many of the runs. The "
        "small line compares it with the truth.",
        DominanceGrid(report));
    add("tables", "Tables 3 and 4 of the paper",
        "The paper’s tables with this experiment’s figures; the paper’s own stand beside or below. "
        "Many switches and an active share below half mean that the policy could not make up its "
        "mind, or that it did not matter.",
        PaperTables(report));
  }
  add("ranking-section", "How fast each algorithm truly is", "", TrueRanking(report));
  add("regret", "What each policy loses",
      "Left is better; the axis is logarithmic, and what loses 0.01 % or less, or wins, stands at "
      "its left edge. “fixed:…” is an algorithm that always stays; the oracle knows everything and "
      "still pays for its switches.",
      RegretCharts(report));
  add("tests", "Is the difference real?", "", Comparisons(report));
  add("live-replay", "Live against replay",
      "Replay can only be trusted where it says what live runs show.", LiveAgainstReplay(report));
  if (!report.records.empty()) {
    add("switches", "Who was active when",
        "A lane per run. Faint: the exploration. Strokes below a lane: candidates that were held "
        "back by the cooldown or a safeguard. Crosses: bail-outs.",
        SwitchTimelines(report));
    add("shares", "Active shares", "", ActiveShares(report));
    add("posteriors", "Posteriors over time",
        "What the decider believed of each algorithm’s reward, a panel per run; the dominant one "
        "is thick and named.",
        PosteriorPanels(report));
    add("verdicts", "Verdicts", "", VerdictShares(report));
    add("time", "Where the time went",
        "The paper left open what its selector costs. Copying in hands boxes to the shadow lane, "
        "which measures the other algorithms on a thread of its own; rebuilds are what switches "
        "cost the frame thread.",
        TimeParts(report));
  }
  add("method", "How it was measured", "", ExperimentMethod(report));
  add("terms", "What the words mean", "", ExperimentTerms());
  add("manifest", "Machine, versions, commands", "", ExperimentManifestList(report));
  add("raw", "Summary rows", "", html::EmbedRows("experiment-json", json));
  return WritePage(page);
}

}  // namespace sweepstake::cli
