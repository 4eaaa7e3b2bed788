#include "engine_client/cli/experiment/experiment_html_prose.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine_client/cli/experiment/experiment_html_words.h"
#include "engine_client/cli/experiment/paper_tables.h"
#include "engine_client/cli/io/numbers.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

using html::Element;
using html::Markup;

// An arm this much slower than the fastest is as good as equal: the verdict's tie.
constexpr double kTieRatio = 1.03;

// The clock's regret of an undisturbed run is this near to the one at the trace's costs.
constexpr double kDisturbedRegret = 0.1;

Markup Item(const Markup& content) { return Element("li", {}, content); }

std::string Of(size_t count, size_t all) {
  return std::to_string(count) + " of " + std::to_string(all);
}

std::string Counted(size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

// The mean over the cells; absent where nothing was replayed.
std::optional<double> MeanRegret(const ExperimentReport& report, const std::string& policy) {
  std::vector<double> regrets;
  for (const CellTruth& truth : report.truths) {
    for (const ReplayedPlayer& player : truth.players) {
      if (player.name == policy) regrets.push_back(player.regret);
    }
  }
  if (regrets.empty()) return std::nullopt;
  return Mean(regrets);
}

Markup Partial(const ExperimentReport& report) {
  if (report.complete()) return {};
  return Paragraph(Element("span", {{"class", "verdict missed"}},
                           "✗ Partial: " + Of(report.records.size(), report.plan.runs.size()) +
                               " planned runs are in. ") +
                   "All figures are of those alone.");
}

Markup Headline(const ExperimentReport& report) {
  const std::string own = OwnPolicyName("default");
  const auto ours = MeanRegret(report, own);
  const auto papers = MeanRegret(report, "paper");
  if (!ours) return {};
  std::string sentence =
      "of frame time is what " + PolicyTitle("default") +
      " loses to the best fixed algorithm, on average over " +
      std::to_string(report.truths.size()) +
      " scenes, start and exploration included. Nobody knows beforehand which algorithm that is; "
      "below 0 means faster than any single one.";
  if (papers && own != "paper") {
    sentence += " The paper’s policy loses " + PercentText(*papers) + ".";
  }
  return Element("p", {{"class", "headline"}},
                 Element("b", {}, PercentText(*ours)) + Element("span", {}, sentence));
}

// How many cells of a policy chose truly well.
Markup TrulyFastest(const ExperimentReport& report, const std::string& policy) {
  size_t fastest = 0, tied = 0, all = 0;
  for (const CellSummary& cell : report.cells) {
    const CellTruth* truth = report.TruthOf(cell.cell);
    if (cell.policy != policy || truth == nullptr) continue;
    ++all;
    for (const ArmCost& arm : truth->ranking) {
      if (arm.arm != cell.dominance.front().first) continue;
      if (arm.ratio == 1) ++fastest;
      if (arm.ratio > 1 && arm.ratio <= kTieRatio) ++tied;
    }
  }
  if (all == 0) return {};
  std::string text = "With the policy " + PolicyTitle(policy) +
                     " the algorithm that was active longest is truly the fastest in " +
                     Of(fastest, all) + " scenes";
  if (tied > 0) text += ", and within 3 % of it in " + std::to_string(tied) + " more";
  return Item(text + ".");
}

Markup SameAsPaper(const ExperimentReport& report) {
  size_t same = 0, all = 0;
  for (const CellSummary& cell : report.cells) {
    const PaperCell* paper = FindPaperCell(cell.cell.scene, cell.cell.object_count);
    if (cell.policy != "paper" || paper == nullptr) continue;
    ++all;
    if (cell.dominance.front().first == paper->dominant) ++same;
  }
  if (all == 0) return {};
  return Item("The same algorithm as in the paper’s Table 3 dominates in " + Of(same, all) +
              " of its scenes. It need not: the seven algorithms here are other code than the "
              "paper’s, each faster "
              "or slower by another factor, and so is the machine.");
}

Markup Agreed(const ExperimentReport& report) {
  size_t regret = 0, share = 0, disturbed = 0, all = 0;
  for (const CellTruth& truth : report.truths) {
    for (const Agreement& each : truth.agreements) {
      ++all;
      regret += each.regret_agrees() ? 1 : 0;
      share += each.share_agrees() ? 1 : 0;
      disturbed += std::abs(each.measured_regret - each.regret) > kDisturbedRegret ? 1 : 0;
    }
  }
  if (all == 0) return {};
  std::string text = "Live against replay: the live regret lies in replay’s 95 % interval in " +
                     Of(regret, all) + " comparisons, the active share in " + Of(share, all) + ".";
  if (disturbed > 0) {
    text += " In " + std::to_string(disturbed) +
            " of them the clock’s regret is more than 10 points off the one at the trace’s costs: "
            "something else used the machine while the game ran, which no replay knows of.";
  }
  return Item(text);
}

Markup SelectorCost(const ExperimentReport& report) {
  double frames_ns = 0, selector_ns = 0, rebuild_ns = 0;
  for (const RunRecord& record : report.records) {
    const TimeShares& time = record.time;
    frames_ns += static_cast<double>(time.scene_step_ns + time.detection_ns + time.rebuild_ns +
                                     time.copying_ns + time.around_ns + time.frame_end_ns);
    selector_ns += static_cast<double>(time.decision_ns);
    rebuild_ns += static_cast<double>(time.rebuild_ns);
  }
  if (frames_ns == 0) return {};
  return Item("The selector itself took " + html::Significant(100 * selector_ns / frames_ns, 2) +
              " % of the time (on a thread of its own), building structures anew after switches " +
              html::Significant(100 * rebuild_ns / frames_ns, 2) + " %.");
}

// An arm measured twice shows what noise there was.
Markup Noise(const ExperimentReport& report) {
  std::string cells;
  for (const CellTruth& truth : report.truths) {
    if (std::abs(truth.control_ratio - 1) <= kTieRatio - 1) continue;
    cells += (cells.empty() ? "" : ", ") + CellName(truth.cell);
  }
  if (cells.empty()) return {};
  return Paragraph(Element("span", {{"class", "verdict missed"}}, "✗ The machine was disturbed. ") +
                   "One algorithm measured twice differs by more than 3 % in " + cells +
                   ": what is said of the truth there is not to be trusted.");
}

Markup Term(const Markup& term, const Markup& meaning) {
  return Element("dt", {}, term) + Element("dd", {}, meaning);
}

}  // namespace

Markup ExperimentLead(const ExperimentReport& report) {
  return Paragraph(
             "A game must find, in every frame, all pairs of its objects whose boxes overlap. "
             "There are several algorithms for that, and which is the fastest depends on the "
             "scene. Sweepstake measures while the game runs and decides which one to use. This "
             "page shows how well it decided: it repeats the experiment of the paper that it is "
             "built on, and checks each decision against the truth.") +
         Element("p", {{"class", "soft small"}},
                 "Measured " + report.sittings.back().start_utc + " on " + report.machine.cpu +
                     " with Sweepstake " + report.machine.program + ".");
}

Markup ExperimentSummary(const ExperimentReport& report) {
  const ExperimentOptions& options = report.plan.options;
  const std::string scale = options.time_scale > 1
                                ? ", all intervals divided by " + html::Compact(options.time_scale)
                                : "";
  Markup items =
      Item(Of(report.records.size(), report.plan.runs.size()) +
           " planned live runs are in: " + Counted(report.plan.cells.size(), "cell", "cells") +
           " (a scene with a number of objects), " +
           Counted(options.policies.size(), "policy", "policies") + ", " +
           Counted(options.run_count, "run", "runs") + " of each, " + options.window +
           " after the exploration" + scale + ".");
  for (const std::string& policy : options.policies) items += TrulyFastest(report, policy);
  items += SameAsPaper(report) + Agreed(report) + SelectorCost(report);
  return Partial(report) + Noise(report) + Headline(report) + Element("ul", {}, items);
}

Markup ExperimentMethod(const ExperimentReport& report) {
  const ExperimentOptions& options = report.plan.options;
  Markup items =
      Item(
          "Each live run is a real game without pictures: the scene moves, the active algorithm "
          "finds all pairs, the frame’s cost goes to the decider, which switches as it sees fit. "
          "It starts knowing nothing. A policy that explores, as the paper’s, first tries every "
          "algorithm once, unobserved; that of AI Decides learns from its shadow lane instead.") +
      Item(
          "The runs of one cell have the same scene and differ in the decider’s seed and in the "
          "algorithm they begin with; those of two policies with the same number share both.") +
      Item(
          "Right after a run every algorithm ran alone on the same scene in turn: the clock’s "
          "regret compares with those.") +
      Item("The truth comes from a trace: every algorithm was timed on each of " +
           html::Grouped(options.trace_frame_count) +
           " frames of the same scene, in turn. “Same twice” is one algorithm "
           "measured a second time: what noise alone makes of a ratio.") +
      Item("Replay plays each policy " + std::to_string(options.replay_seed_count) +
           " times on the trace in virtual time, at 10 ms a frame, where the paper’s intervals "
           "mean what they say. Regret is frame time ÷ that of the best fixed algorithm, minus 1. "
           "Intervals are bootstrapped over the seeds.") +
      Item(
          "To compare live and replay, replay also ran under the live runs’ own conditions: their "
          "frame times, their other work, their time scale. It expects the mean of as many runs "
          "within 1.96 standard deviations of its games × √(1/runs + 1/games).");
  if (options.time_scale > 1) {
    items += Item(
        "With the time scale all of the decider’s intervals and the window are shorter "
        "by the same factor: as many decisions and switches as in full length, from "
        "shorter measurements.");
  }
  return Element("ul", {}, items);
}

Markup ExperimentTerms() {
  constexpr std::array<std::array<const char*, 2>, 12> kTerms{{
      {"Arm", "an algorithm that the decider may choose"},
      {"Policy",
       "how it chooses. “paper” is the paper’s Thompson sampling; AI Decides is what "
       "Sweepstake ships"},
      {"Cell", "a scene with a number of objects"},
      {"Exploration", "the first part of a run: every arm once, 2 s to warm up, 4 s measured"},
      {"Observation window", "what follows: 15 minutes in the paper"},
      {"Dominant", "active for the largest share of the observation window"},
      {"Posterior, μ, n",
       "what is believed of an arm’s reward, a Beta distribution: its mean, and "
       "how much evidence it rests on; μ* and n* are the dominant arm’s"},
      {"Held back", "the policy would have switched, but the cooldown or a safeguard forbade it"},
      {"Bail-out", "a switch because a frame took longer than 5 s"},
      {"Verdict",
       "stable: one arm is the best with a probability of 0.8 or more. Tie: several are "
       "as good as equal. Ambiguous: not known, and it matters. Degraded: even the best "
       "is too slow"},
      {"Regret", "frame time ÷ that of the best fixed arm, minus 1"},
      {"Headroom", "what one could win over the best fixed arm by always switching in time"},
  }};
  Markup list;
  for (const auto& [term, meaning] : kTerms) list += Term(term, meaning);
  return Element("dl", {{"class", "terms"}}, list);
}

Markup ExperimentManifestList(const ExperimentReport& report) {
  const ExperimentOptions& options = report.plan.options;
  Markup list = Term("Processor", report.machine.cpu) +
                Term("Hardware threads", std::to_string(report.machine.core_count)) +
                Term("System", report.machine.system) + Term("Compiler", report.machine.compiler) +
                Term("Vector instructions", report.machine.simd_target) +
                Term("Sweepstake", report.machine.program);
  for (const LibraryVersion& library : report.machine.libraries) {
    list += Term(library.name, library.version);
  }
  list += Term("Time scale", html::Compact(options.time_scale)) + Term("Window", options.window) +
          Term("Seed", std::to_string(options.seed));
  Markup sittings;
  for (const ExperimentSitting& sitting : report.sittings) {
    sittings += Element("pre", {}, Element("code", {}, sitting.command_line)) +
                Element("p", {{"class", "soft small"}},
                        "From " + sitting.start_utc + " to " +
                            (sitting.end_utc.empty() ? "an unknown end" : sitting.end_utc));
  }
  return Element("dl", {}, list) + Element("h3", {}, "Command lines") + sittings +
         Paragraph(Markup("All seeds and every parameter of the decider are in ") +
                   Element("code", {}, "manifest.json") +
                   " beside this page, the raw rows in its CSV files.");
}

}  // namespace sweepstake::cli
