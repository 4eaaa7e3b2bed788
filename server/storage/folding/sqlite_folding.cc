#include "server/storage/folding/sqlite_folding.h"

#include <compare>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine_client/math/hash.h"

namespace sweepstake::storage {
namespace {

// Evidence of one month and one build is folded together.
struct FoldGroup {
  std::string month;  // empty if the evidence stays as it is
  std::string build;

  friend auto operator<=>(const FoldGroup&, const FoldGroup&) = default;
};
using FoldedSources = std::map<FoldGroup, int64_t>;  // their ids

// A row of evidence that a fold looks at.
struct FoldRow {
  FoldPlace place;
  FoldGroup group;
};

// Returns the rows, and of those that are to be folded their groups.
absl::StatusOr<std::vector<FoldRow>> NextToFold(PriorStatements& statements, const FoldPlace& after,
                                                uint64_t last_unix_s, uint32_t row_count) {
  std::vector<FoldRow> rows;
  absl::Status status = statements.next_evidence.ForEachRow(
      [&](const SqliteRow& row) {
        rows.push_back({{row.Integer(0), row.Integer(1)}, {row.Text(2), row.Text(3)}});
      },
      after.source, after.key, last_unix_s, row_count);
  if (!status.ok()) return status;
  return rows;
}

// Returns the id of the source that has the group's evidence. `known` is filled.
absl::StatusOr<int64_t> FoldedSource(PriorStatements& statements, const FoldGroup& group,
                                     FoldedSources& known) {
  int64_t& id = known[group];
  if (id != 0) return id;
  std::string name = "\nfolded " + group.month;
  if (!group.build.empty())
    absl::StrAppend(&name, " ", absl::Hex(math::Fnv1a(math::kFnv1aStart, group.build)));
  absl::Status status = statements.add_folded_source.ForEachRow(
      [&](const SqliteRow& row) { id = row.Integer(0); }, name, group.build);
  if (!status.ok()) return status;
  return id;
}

// Returns whether the row was folded.
absl::StatusOr<bool> FoldOne(PriorStatements& statements, const FoldRow& row,
                             FoldedSources& known) {
  if (row.group.month.empty()) return false;
  const auto target = FoldedSource(statements, row.group, known);
  if (!target.ok()) return target.status();
  int64_t folded_count = 0;
  const auto [source, key] = row.place;
  absl::Status status = statements.fold_evidence.ForEachRow(
      [&](const SqliteRow& folded) { folded_count = folded.Integer(0); }, key, source, *target);
  if (status.ok() && folded_count == 0) return false;
  if (status.ok()) status = statements.delete_folded.Run(key, source);
  // One row of the key takes the place of two.
  if (status.ok() && folded_count > 1)
    status = statements.add_to_sums.Run(key, 0.0, 0.0, uint64_t{0}, uint64_t{0}, int64_t{-1});
  if (!status.ok()) return status;
  return true;
}

}  // namespace

absl::StatusOr<FoldStep> FoldRows(PriorStatements& statements, const FoldPlace& after,
                                  uint64_t last_unix_s, uint32_t row_count) {
  const auto rows = NextToFold(statements, after, last_unix_s, row_count);
  if (!rows.ok()) return rows.status();
  FoldStep step{.next = after};
  step.last = rows->size() < row_count;
  int64_t last_source = after.source;  // was counted by the step before
  FoldedSources known;
  for (const FoldRow& row : *rows) {
    step.next = row.place;
    const auto folded = FoldOne(statements, row, known);
    if (!folded.ok()) return folded.status();
    if (!*folded) continue;
    ++step.record_count;
    if (std::exchange(last_source, row.place.source) != row.place.source) ++step.source_count;
  }
  return step;
}

}  // namespace sweepstake::storage
