#include "engine_client/cli/bench/bench_html_prose.h"

#include <algorithm>
#include <array>
#include <limits>

#include "engine_client/cli/bench/bench_html_words.h"
#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli {
namespace {

using html::Element;
using html::Markup;

Markup Paragraph(const Markup& text) { return Element("p", {}, text); }

Markup Term(const Markup& term, const Markup& meaning) {
  return Element("dt", {}, term) + Element("dd", {}, meaning);
}

std::string Joined(const std::vector<uint32_t>& values) {
  std::string text;
  for (const uint32_t value : values) {
    text += (text.empty() ? "" : ", ") + html::Grouped(value);
  }
  return text;
}

// The least and the largest of our best against the best peer.
struct Span {
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  size_t count = 0;
};

// With the fewest threads of the run. `published`: against peers that did not run.
Span OverallSpan(const BenchIndex& index, bool published) {
  Span span;
  for (const BenchRatio& ratio : index.report().ratios) {
    if (ratio.kind != RatioKind::kOverall || ratio.derived_through.empty() == published) continue;
    if (ratio.thread_count != index.thread_counts().front()) continue;
    span.least = std::min(span.least, ratio.value);
    span.most = std::max(span.most, ratio.value);
    ++span.count;
  }
  return span;
}

std::string Text(const Span& span) {
  return span.count == 1 ? Times(span.least)
                         : html::Significant(span.least, 3) + "–" + Times(span.most);
}

Markup Big(const std::string& figure, const std::string& sentence) {
  return Element("p", {{"class", "headline"}},
                 Element("b", {}, figure) + Element("span", {}, sentence));
}

Markup WithoutPeers(const BenchReport& report) {
  constexpr const char* kOurs = "so this page compares Sweepstake’s own backends only. ";
  if (report.options.peers) {
    return Paragraph(Markup("No peer could be compared in this run, ") + kOurs +
                     "Below it says which were left out, and why.");
  }
  return Paragraph(Markup("No peers took part in this run, ") + kOurs + "With " +
                   Element("code", {{"class", "word"}}, "--peers") +
                   " the same frames go through other libraries’ broad phases too.");
}

}  // namespace

html::Markup Introduction(const BenchReport& report) {
  return Element("p", {},
                 "A broad phase finds, in every frame of a game, all pairs of boxes that overlap. "
                 "Here several "
                 "of them found the same pairs of the same frames, one after the other on one "
                 "machine; this "
                 "page shows how long each took.") +
         Element("p", {{"class", "soft small"}},
                 "Measured " + report.machine.date_utc + " on " + report.machine.cpu +
                     " with Sweepstake " + report.machine.program + ".");
}

html::Markup Headline(const BenchIndex& index) {
  const Span measured = OverallSpan(index, false);
  if (measured.count == 0) {
    return WithoutPeers(index.report());
  }
  Markup headline = Big(Text(measured),
                        "the speed of the fastest peer: the best of Sweepstake’s backends "
                        "in each scene against the best of all other libraries that ran beside "
                        "it on the same frames.");
  if (const Span published = OverallSpan(index, true); published.count > 0) {
    headline += Element("p", {{"class", "soft"}},
                        Text(published) +
                            " the speed of the best library that did not run here, reckoned "
                            "through published ratios to one that did.");
  }
  return headline;
}

html::Markup Warnings(const BenchReport& report) {
  Markup wrong, left_out;
  for (const BenchRow& row : report.rows) {
    const std::string who =
        ContestantTitle(row.name, row.thread_count) + " in " + CellTitle(report, row.cell) + ": ";
    if (!row.difference.empty()) wrong += Element("li", {}, who + row.difference);
    if (!row.note.empty()) left_out += Element("li", {}, who + row.note);
  }
  for (const std::string& absent : report.machine.absent_peers) {
    left_out += Element("li", {}, absent);
  }
  Markup warnings;
  if (!wrong.empty()) {
    warnings += Paragraph(Element("span", {{"class", "verdict missed"}},
                                  "✗ Not all pairs were right. These times are not comparable:")) +
                Element("ul", {}, wrong);
  }
  if (!left_out.empty()) {
    warnings +=
        Element("details", {},
                Element("summary", {}, "Left out or cut short") + Element("ul", {}, left_out));
  }
  return warnings;
}

html::Markup MachineList(const BenchReport& report, const std::string& command_line) {
  const BenchMachine& machine = report.machine;
  Markup list = Term("Processor", machine.cpu) +
                Term("Hardware threads", std::to_string(machine.core_count)) +
                Term("System", machine.system) + Term("Compiler", machine.compiler) +
                Term("Vector instructions", machine.simd_target) +
                Term("Sweepstake", machine.program);
  for (const LibraryVersion& library : machine.libraries) {
    list += Term(library.name, library.version);
  }
  return Element("dl", {}, list) + Element("h3", {}, "Command line") +
         Element("pre", {}, Element("code", {}, command_line));
}

html::Markup Method(const BenchReport& report) {
  const BenchOptions& options = report.options;
  Markup items =
      Element(
          "li", {},
          "All contestants saw the same boxes in the same run. They took turns by blocks of up to "
          "20 frames, and another one began each time: what disturbed the machine for a moment "
          "disturbed all alike, yet each ran with the warm caches that it would have alone.") +
      Element("li", {},
              html::Grouped(options.warmup) + " frames to warm up, then " +
                  html::Grouped(options.frames) + " measured ones. Seed " +
                  std::to_string(options.seed) +
                  ": another run of the same command makes the same boxes.") +
      Element("li", {},
              "A frame’s time is that of taking all boxes and finding all overlapping pairs, "
              "exactly and once each; making the boxes is not in it.") +
      Element("li", {},
              "Threads: " + Joined(options.thread_counts) + ". Unless a name says so, one.");
  if (options.peers) {
    items += Element(
        "li", {},
        "Peers are other libraries as Debian packages them, called the fastest way that their "
        "interfaces offer. Their pairs were compared with ours. A peer that took more than " +
            html::Significant(options.peer_cap_s, 3) +
            " s of its own in a cell was cut short or left out there.");
  }
  return Element("ul", {}, items);
}

html::Markup Terms() {
  constexpr std::array<std::array<const char*, 2>, 12> kTerms{{
      {"Scene, objects", "what moves, and how many boxes there are"},
      {"Family",
       "algorithms that work alike: a backend is compared with the best peer of its own family, "
       "too"},
      {"Median",
       "half of the frames took less: the usual frame. The figure that all comparisons use unless "
       "they say otherwise"},
      {"Mean", "all time divided by the frames: rare slow frames are in it"},
      {"Min", "the fastest frame: what the code can do when nothing disturbs it"},
      {"p99", "99 of 100 frames took no longer: what a player notices as a stutter"},
      {"Pairs", "overlapping pairs per frame, mean"},
      {"AABB checks",
       "comparisons of two boxes per frame, mean; a lane of a vector comparison is one"},
      {"Bytes",
       "the most memory that the backend itself held in a measured frame; “with pairs” adds the "
       "buffer of the pairs"},
      {"Published",
       "peers that Debian has no package of did not run: their time is that of one that ran, times "
       "the quotient of their published times in the same scene"},
      {"Times faster", "the other’s time divided by ours, over the frames that both measured"},
      {"✓ met, ✗ missed", "whether the comparison reaches the project’s goal for it"},
  }};
  Markup list;
  for (const auto& [term, meaning] : kTerms) list += Term(term, meaning);
  return Element("dl", {{"class", "terms"}}, list);
}

}  // namespace sweepstake::cli
