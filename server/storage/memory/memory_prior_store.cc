#include "server/storage/memory/memory_prior_store.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/decider/pooling/source_choice.h"
#include "server/storage/record_limits.h"

namespace sweepstake::storage {
namespace {

using priors::AuditRow;
using priors::Evidence;
using priors::EvidenceKey;
using priors::PriorRecord;
using priors::SceneEvidence;
using priors::SceneFilter;
using priors::SceneKey;

SceneKey SceneOf(const EvidenceKey& key) {
  return {key.project, key.scene, key.machine_class, key.reward_version};
}

// Counts do not grow beyond what a store may have.
void Add(Evidence& sum, const Evidence& part) {
  sum += part;
  sum.window_count = std::min(sum.window_count, kMaxCount);
  sum.bail_out_count = std::min(sum.bail_out_count, kMaxCount);
}

}  // namespace

absl::Status MemoryPriorStore::Commit(std::span<const priors::SourceUpdate> updates) {
  absl::Status status = CheckUpdates(updates);
  if (status.ok()) status = CheckSums(updates);
  if (!status.ok()) return status;
  for (const auto& update : updates) Apply(update);
  return absl::OkStatus();
}

bool MemoryPriorStore::Applies(const priors::SourceUpdate& update) const {
  const auto found = sources_.find(update.progress.source_id);
  return found == sources_.end() ||
         (!found->second.revoked &&
          update.progress.commit_sequence > found->second.progress.commit_sequence);
}

absl::Status MemoryPriorStore::CheckSums(std::span<const priors::SourceUpdate> updates) const {
  std::map<std::pair<EvidenceKey, std::string>, Evidence> sums;
  for (const auto& update : updates) {
    const std::string& source_id = update.progress.source_id;
    if (!Applies(update)) continue;
    for (const auto& [key, evidence] : update.increments) {
      const auto [sum, is_new] = sums.try_emplace({key, source_id});
      const auto stored = evidence_.find(key);
      if (is_new && stored != evidence_.end()) {
        if (const auto entry = stored->second.find(source_id); entry != stored->second.end())
          sum->second = entry->second.evidence;
      }
      sum->second += evidence;
      if (!(sum->second.alpha < kMaxEvidence && sum->second.beta < kMaxEvidence))
        return absl::InvalidArgumentError("a source's alpha and beta must stay below 1e15");
    }
  }
  return absl::OkStatus();
}

MemoryPriorStore::Source& MemoryPriorStore::FindSource(const std::string& id) {
  Source& source = sources_[id];
  if (source.number == 0) source.number = sources_.size();
  return source;
}

std::vector<std::pair<std::string, MemoryPriorStore::Entry>> MemoryPriorStore::NewestFirst(
    const EntriesBySource& entries) const {
  std::vector<std::pair<std::string, Entry>> sorted(entries.begin(), entries.end());
  std::sort(sorted.begin(), sorted.end(), [&](const auto& a, const auto& b) {
    return sources_.at(a.first).number > sources_.at(b.first).number;
  });
  return sorted;
}

std::vector<std::pair<std::string, MemoryPriorStore::Entry>> MemoryPriorStore::Choose(
    const EntriesBySource& entries, size_t limit) const {
  const auto latest = NewestFirst(entries);
  std::vector<int64_t> tokens;
  for (const auto& [id, entry] : latest) tokens.push_back(sources_.at(id).origin.token_id);
  std::vector<std::pair<std::string, Entry>> chosen;
  for (const size_t i : decision::ChooseSources(tokens, limit)) chosen.push_back(latest[i]);
  return chosen;
}

void MemoryPriorStore::Apply(const priors::SourceUpdate& update) {
  if (!Applies(update)) return;
  Source& source = FindSource(update.progress.source_id);
  source.progress = update.progress;
  if (!source.is_session) {
    source.created_unix_s = update.unix_time_s;
    source.origin = update.origin;
  }
  source.last_seen_unix_s = update.unix_time_s;
  source.is_session = true;
  for (auto& [key, entries] : quarantine_) entries.erase(update.progress.source_id);
  for (const auto& increment : update.increments) {
    Entry& entry = evidence_[increment.key][update.progress.source_id];
    entry.sequence = update.progress.commit_sequence;
    entry.evidence += priors::InUnits(increment.evidence);
  }
  lost_audit_row_count_ += audit_.Append(update);
}

absl::StatusOr<std::vector<priors::SceneSource>> MemoryPriorStore::LoadSources(
    const SceneKey& scene) {
  std::map<std::pair<std::string, uint64_t>, priors::SceneSource> found;
  for (const auto& [key, entries] : evidence_) {
    SceneKey wanted = scene;
    wanted.machine_class = key.machine_class;
    if (SceneOf(key) != wanted) continue;
    for (const auto& [source_id, entry] :
         Choose(entries, key.machine_class == scene.machine_class ? priors::kSourcesOfScene
                                                                  : priors::kSourcesOfOtherClass)) {
      const Source& stored = sources_.at(source_id);
      priors::SceneSource& source = found[{key.machine_class, stored.number}];
      source.id = source_id;
      source.build = stored.origin.build;
      source.last_seen_unix_s = stored.last_seen_unix_s;
      source.evidence.key = wanted;
      source.evidence.source_count = 1;
      source.evidence.ArmOf(key.arm, key.backend_version).of(key.measured_by) = entry.evidence;
    }
  }
  std::vector<priors::SceneSource> sources;
  for (auto& [place, source] : found) sources.push_back(std::move(source));
  return sources;
}

absl::StatusOr<std::optional<priors::SourceState>> MemoryPriorStore::LoadSource(
    const std::string& source_id) {
  const auto found = sources_.find(source_id);
  if (found == sources_.end() || !found->second.is_session || found->second.revoked)
    return std::nullopt;
  priors::SourceState state{.progress = found->second.progress,
                            .evidence = {},
                            .audit_segment = audit_.LastSegment(source_id),
                            .created_unix_s = found->second.created_unix_s,
                            .last_seen_unix_s = found->second.last_seen_unix_s};
  for (const auto& [key, entries] : evidence_) {
    if (const auto entry = entries.find(source_id); entry != entries.end()) {
      state.evidence.push_back({key, entry->second.evidence});
    }
  }
  return state;
}

SceneEvidence MemoryPriorStore::Sum(const SceneKey& key) const {
  SceneEvidence result{.key = key, .arms = {}, .source_count = 0};
  std::set<std::string> sources;
  for (const auto& [evidence_key, entries] : evidence_) {
    if (SceneOf(evidence_key) != key) continue;
    SceneEvidence::Arm& arm = result.ArmOf(evidence_key.arm, evidence_key.backend_version);
    for (const auto& [source_id, entry] : entries) {
      Add(arm.of(evidence_key.measured_by), entry.evidence);
      sources.insert(source_id);
    }
    const auto latest = NewestFirst(entries);
    for (size_t i = 0; i < std::min<size_t>(latest.size(), priors::kSourcesOfAge); ++i)
      arm.last_seen_unix_s =
          std::max(arm.last_seen_unix_s, sources_.at(latest[i].first).last_seen_unix_s);
  }
  result.source_count = sources.size();
  return result;
}

absl::StatusOr<std::vector<SceneEvidence>> MemoryPriorStore::List(
    const SceneFilter& filter, const std::optional<SceneKey>& after, uint32_t limit) {
  std::set<SceneKey> keys;
  for (const auto& [key, entries] : evidence_) {
    if (filter.Matches(key.project, key.scene) && (!after || SceneOf(key) > *after))
      keys.insert(SceneOf(key));
  }
  std::vector<SceneEvidence> scenes;
  for (const SceneKey& key : keys) {
    if (scenes.size() == limit) break;
    scenes.push_back(Sum(key));
  }
  return scenes;
}

absl::StatusOr<std::optional<SceneEvidence>> MemoryPriorStore::LoadScene(const SceneKey& key) {
  SceneEvidence scene = Sum(key);
  if (scene.arms.empty()) return std::nullopt;
  return scene;
}

absl::StatusOr<priors::SceneCount> MemoryPriorStore::CountScenes(const std::string& project) {
  std::set<std::string> names;
  std::set<SceneKey> keys;
  for (const auto& [key, entries] : evidence_) {
    if (key.project != project) continue;
    names.insert(key.scene);
    keys.insert(SceneOf(key));
  }
  return priors::SceneCount{names.size(), keys.size()};
}

absl::StatusOr<uint64_t> MemoryPriorStore::CountProjects() {
  std::set<std::string> projects;
  for (const auto& [key, entries] : evidence_) projects.insert(key.project);
  return projects.size();
}

absl::StatusOr<priors::ExportPage> MemoryPriorStore::Export(const SceneFilter& filter,
                                                            const priors::ExportPlace& after,
                                                            uint32_t limit) {
  return ExportOf(evidence_, filter, after, limit);
}

absl::StatusOr<priors::ExportPage> MemoryPriorStore::ExportQuarantined(
    const SceneFilter& filter, const priors::ExportPlace& after, uint32_t limit) {
  priors::ExportPage page = ExportOf(quarantine_, filter, after, limit);
  for (PriorRecord& record : page.records) record.is_quarantined = true;
  return page;
}

priors::ExportPage MemoryPriorStore::ExportOf(const EntriesByKey& all, const SceneFilter& filter,
                                              const priors::ExportPlace& after,
                                              uint32_t limit) const {
  std::map<std::pair<EvidenceKey, uint64_t>, PriorRecord> records;
  for (const auto& [key, entries] : all) {
    if (!filter.Matches(key.project, key.scene)) continue;
    for (const auto& [source_id, entry] : entries) {
      const Source& source = sources_.at(source_id);
      const std::pair place(key, source.number);
      if (place > std::pair(after.key, after.source_number))
        records[place] = {key,
                          source_id,
                          entry.sequence,
                          entry.evidence,
                          source.origin.build,
                          source.last_seen_unix_s,
                          !source.is_session};
    }
  }
  priors::ExportPage page{.records = {}, .next = after};
  for (auto& [place, record] : records) {
    if (page.records.size() == limit) break;
    page.records.push_back(std::move(record));
    page.next = {place.first, place.second};
  }
  return page;
}

bool MemoryPriorStore::TakesImports(const PriorRecord& record) {
  const bool is_new = sources_.find(record.source_id) == sources_.end();
  Source& source = FindSource(record.source_id);
  if (is_new) {
    source.origin.build = record.build;
    source.last_seen_unix_s = record.last_seen_unix_s;
  }
  return !source.revoked && !source.is_session;
}

bool MemoryPriorStore::Take(const EvidenceKey& key, const std::string& source_id,
                            const Entry& entry) {
  Entry& counted = evidence_[key][source_id];
  const bool is_newer = entry.sequence > counted.sequence;
  if (is_newer) counted = entry;
  std::erase_if(quarantine_[key], [&](const auto& waiting) {
    return waiting.first == source_id && waiting.second.sequence <= entry.sequence;
  });
  return is_newer;
}

bool MemoryPriorStore::ImportOne(const PriorRecord& record) {
  return TakesImports(record) && Take(record.key, record.source_id,
                                      {record.source_sequence, priors::InUnits(record.evidence)});
}

bool MemoryPriorStore::QuarantineOne(const PriorRecord& record) {
  if (!TakesImports(record)) return false;
  const auto sequence_in = [&](const EntriesByKey& all) {
    const auto entries = all.find(record.key);
    if (entries == all.end()) return uint64_t{0};
    const auto entry = entries->second.find(record.source_id);
    return entry == entries->second.end() ? uint64_t{0} : entry->second.sequence;
  };
  if (record.source_sequence <= std::max(sequence_in(evidence_), sequence_in(quarantine_)))
    return false;
  quarantine_[record.key][record.source_id] = {record.source_sequence,
                                               priors::InUnits(record.evidence)};
  return true;
}

absl::StatusOr<priors::ImportResult> MemoryPriorStore::Import(
    std::span<const PriorRecord> records) {
  absl::Status status = CheckRecords(records);
  if (!status.ok()) return status;
  priors::ImportResult result;
  for (const PriorRecord& record : records) {
    ++(ImportOne(record) ? result.applied_count : result.unchanged_count);
  }
  return result;
}

absl::StatusOr<priors::ImportResult> MemoryPriorStore::Quarantine(
    std::span<const PriorRecord> records, uint64_t max_records) {
  absl::Status status = CheckRecords(records);
  if (!status.ok()) return status;
  auto sources = sources_;
  auto quarantine = quarantine_;
  priors::ImportResult result;
  for (const PriorRecord& record : records) {
    ++(QuarantineOne(record) ? result.applied_count : result.unchanged_count);
  }
  uint64_t count = 0;
  for (const auto& [key, entries] : quarantine_) count += entries.size();
  status = QuarantineBound(count, max_records);
  if (status.ok()) return result;
  sources_ = std::move(sources);
  quarantine_ = std::move(quarantine);
  return status;
}

absl::StatusOr<priors::PromoteResult> MemoryPriorStore::Promote(const priors::SourceFilter& filter,
                                                                const priors::Preview& preview) {
  if (preview) return Shown(preview, [&](auto& store) { return store.Promote(filter, false); });
  priors::PromoteResult result;
  std::set<std::string> sources;
  std::set<SceneKey> scenes;
  for (auto& [key, waiting] : quarantine_) {
    if (!filter.project.empty() && filter.project != key.project) continue;
    for (const auto& [source_id, entry] : EntriesBySource(waiting)) {
      if (!Matches(source_id, filter)) continue;
      sources.insert(source_id);
      scenes.insert(SceneOf(key));
      ++result.record_count;
      result.window_count += entry.evidence.window_count;
      Take(key, source_id, entry);
    }
  }
  result.source_count = sources.size();
  result.scene_count = scenes.size();
  return result;
}

bool MemoryPriorStore::HasEvidence(const std::string& source_id, const std::string& project) const {
  const auto is_evidence = [&](const auto& entries) {
    return entries.first.project == project && entries.second.contains(source_id);
  };
  return std::any_of(evidence_.begin(), evidence_.end(), is_evidence) ||
         std::any_of(quarantine_.begin(), quarantine_.end(), is_evidence);
}

bool MemoryPriorStore::Matches(const std::string& source_id,
                               const priors::SourceFilter& filter) const {
  const Source& source = sources_.at(source_id);
  return source_id != decision::kAdminSession && (filter.id.empty() || filter.id == source_id) &&
         (filter.build.empty() || filter.build == source.origin.build) &&
         (filter.token_id == 0 || filter.token_id == source.origin.token_id) &&
         source.created_unix_s >= filter.from_unix_s &&
         source.created_unix_s <= filter.until_unix_s &&
         (filter.project.empty() || HasEvidence(source_id, filter.project));
}

absl::StatusOr<priors::RevokeResult> MemoryPriorStore::Revoke(const priors::SourceFilter& filter,
                                                              const priors::Preview& preview) {
  if (preview) return Shown(preview, [&](auto& store) { return store.Revoke(filter, false); });
  std::set<std::string> matching;
  for (const auto& [id, source] : sources_) {
    if (!source.revoked && Matches(id, filter)) matching.insert(id);
  }
  priors::RevokeResult result{.source_count = matching.size()};
  for (EntriesByKey* all : {&evidence_, &quarantine_}) {
    for (auto entries = all->begin(); entries != all->end();) {
      const bool is_meant = filter.project.empty() || filter.project == entries->first.project;
      std::erase_if(entries->second, [&](const auto& entry) {
        if (!is_meant || !matching.contains(entry.first)) return false;
        ++result.record_count;
        result.window_count += entry.second.evidence.window_count;
        return true;
      });
      entries = entries->second.empty() ? all->erase(entries) : std::next(entries);
    }
  }
  for (const std::string& id : matching) FindSource(id).revoked = true;
  if (BarsUnknown(filter)) FindSource(filter.id).revoked = true;
  return result;
}

absl::StatusOr<std::vector<priors::AuditSegment>> MemoryPriorStore::ListAudit(
    const priors::AuditFilter& filter, uint64_t after, uint32_t limit) {
  return audit_.List(filter, after, limit);
}

absl::StatusOr<std::vector<AuditRow>> MemoryPriorStore::LoadAudit(uint64_t segment_id,
                                                                  uint64_t first_row,
                                                                  uint32_t limit,
                                                                  size_t max_bytes) {
  return audit_.Load(segment_id, first_row, limit, max_bytes);
}

}  // namespace sweepstake::storage
