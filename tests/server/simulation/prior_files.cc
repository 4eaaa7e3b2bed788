#include "tests/server/simulation/prior_files.h"

#include <algorithm>
#include <map>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace sweepstake::simulation {
namespace {

using priors::PriorRecord;
// The key and the source of a record. A store keeps only the newest record for both together.
using Place = std::pair<priors::EvidenceKey, std::string>;

constexpr absl::string_view kSourcePrefix = "import-";

Place PlaceOf(const PriorRecord& record) { return {record.key, record.source_id}; }

}  // namespace

size_t PriorFiles::Choose() {
  if (files_.empty() || world_.Happens(0.6)) {
    Make();
    return files_.size() - 1;
  }
  return static_cast<size_t>(world_.Draw(0, static_cast<int64_t>(files_.size()) - 1));
}

// Makes a file. Its number, from 1, is the source_sequence of its records.
void PriorFiles::Make() {
  const uint64_t number = files_.size() + 1;
  std::vector<PriorRecord> records;
  for (const std::string& project : kProjects) {
    for (const char* scene : {"harbour", "forest"}) {
      for (const char* source : {"a", "b", "c"}) {
        if (!records.empty() && world_.Happens(0.6)) continue;
        PriorRecord record;
        record.key = {.project = project,
                      .scene = scene,
                      .measured_by = "",
                      .arm = world_.Happens(0.5) ? "Grid" : "SAP",
                      .backend_version = 1,
                      .machine_class = "",
                      .reward_version = 1,
                      .regime = number % 2 == 0 ? "13/-4/0" : ""};
        record.source_id = absl::StrCat(kSourcePrefix, source);
        record.source_sequence = number;
        record.evidence = {.alpha = static_cast<double>(number),
                           .beta = 1,
                           .window_count = number,
                           .bail_out_count = 0};
        record.is_imported = true;
        records.push_back(std::move(record));
      }
    }
  }
  files_.push_back(std::move(records));
  promised_.push_back(false);
}

void PriorFiles::Check(std::span<const PriorRecord> stored,
                       const std::function<void(const std::string&)>& complain) const {
  std::map<Place, uint64_t> sequences;
  std::vector<bool> applied = promised_;
  for (const PriorRecord& record : stored) {
    if (!absl::StartsWith(record.source_id, kSourcePrefix)) continue;
    const size_t file = record.source_sequence - 1;
    if (!sequences.emplace(PlaceOf(record), record.source_sequence).second)
      complain("a record of a file is stored twice");
    if (file >= files_.size() ||
        std::find(files_[file].begin(), files_[file].end(), record) == files_[file].end()) {
      complain("the store has a record that no file has");
    } else {
      applied[file] = true;
    }
  }
  for (size_t file = 0; file < files_.size(); ++file) {
    for (const PriorRecord& record : files_[file]) {
      if (applied[file] && sequences[PlaceOf(record)] < record.source_sequence)
        complain(absl::StrCat("file ", file + 1, " is stored in part or was lost"));
    }
  }
}

}  // namespace sweepstake::simulation
