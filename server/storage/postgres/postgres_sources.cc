#include "server/storage/postgres/postgres_sources.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine_client/decider/audit/audit_log.h"

namespace sweepstake::storage {
namespace {

using priors::SourceUpdate;

constexpr const char* kLockSources = R"sql(
    SELECT id, name, is_session, revoked, commit_sequence, writer FROM source
    WHERE name = ANY($1::text[]) ORDER BY name FOR NO KEY UPDATE)sql";
constexpr const char* kNextIds =
    "SELECT nextval('source_number') FROM generate_series(1, $1::bigint)";
constexpr const char* kAddSources = R"sql(
    INSERT INTO source (id, name, build, last_seen_unix_s)
    SELECT * FROM unnest($1::bigint[], $2::text[], $3::text[], $4::bigint[])
                  AS given(id, name, build, last_seen_unix_s)
    ORDER BY name COLLATE "C" ON CONFLICT (name) DO NOTHING RETURNING id)sql";
// The origin of a source and its start are kept from its first commit on.
constexpr const char* kUpdateSources = R"sql(
    UPDATE source s
    SET commit_sequence = g.commit_sequence, message_sequence = g.message_sequence,
        explored_arm_count = g.explored_arm_count, decision_count = g.decision_count,
        frame_count = g.frame_count, seed = g.seed, last_seen_unix_s = g.last_seen_unix_s,
        writer = g.writer, is_session = true,
        created_unix_s = CASE WHEN is_session THEN s.created_unix_s ELSE g.created_unix_s END,
        build = CASE WHEN is_session THEN s.build ELSE g.build END,
        token_id = CASE WHEN is_session THEN s.token_id ELSE g.token_id END
    FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::bigint[], $5::bigint[],
                $6::bigint[], $7::bigint[], $8::bigint[], $9::bigint[], $10::bigint[],
                $11::text[], $12::bigint[])
         AS g(id, commit_sequence, message_sequence, explored_arm_count, decision_count,
              frame_count, seed, last_seen_unix_s, writer, created_unix_s, build, token_id)
    WHERE s.id = g.id)sql";
constexpr const char* kLockMatching = R"sql(
    SELECT id FROM source
    WHERE (NOT revoked OR $8::boolean) AND ($1 = '' OR name = $1) AND ($2 = '' OR build = $2)
      AND ($3::bigint = 0 OR token_id = $3::bigint)
      AND created_unix_s BETWEEN $4::bigint AND $5::bigint AND name <> $7
      AND ($6 = ''
           OR EXISTS (SELECT 1 FROM scene_source j JOIN scene s ON s.id = scene_id
                      WHERE source_id = source.id AND project = $6)
           OR EXISTS (SELECT 1 FROM quarantined_evidence q JOIN evidence_key k ON k.id = key_id
                      WHERE source_id = source.id AND project = $6))
      AND (NOT $8::boolean
           OR EXISTS (SELECT 1 FROM quarantined_evidence WHERE source_id = source.id))
    ORDER BY name FOR NO KEY UPDATE)sql";
constexpr const char* kBar = "UPDATE source SET revoked = true WHERE id = ANY($1::bigint[])";

}  // namespace

absl::StatusOr<bool> LockedSource::Advance(const SourceUpdate& update) {
  if (revoked) return false;
  const auto& [id_of_writer, resumed_sequence] = update.writer;
  if (id_of_writer != writer && id_of_writer != 0 && resumed_sequence != commit_sequence) {
    return absl::FailedPreconditionError(
        absl::StrCat("another daemon goes on with session ", update.progress.source_id));
  }
  if (update.progress.commit_sequence <= commit_sequence) return false;
  commit_sequence = update.progress.commit_sequence;
  writer = id_of_writer;
  if (first == nullptr) first = &update;
  last = &update;
  return true;
}

absl::StatusOr<LockedSources> PostgresSources::LockOrAdd(std::span<const NewSource> sources) {
  LockedSources names;
  for (const NewSource& source : sources) names.try_emplace(source.name);
  LockedSources found;
  if (absl::Status status = Lock(names, found); !status.ok()) return status;
  std::vector<const NewSource*> unknown;
  for (const NewSource& source : sources) {
    if (found.try_emplace(source.name).second) unknown.push_back(&source);
  }
  if (absl::Status status = Add(unknown, found); !status.ok()) return status;
  return found;
}

absl::Status PostgresSources::Lock(const LockedSources& names, LockedSources& found) {
  PostgresArray array;
  for (const auto& [name, source] : names) array.Add(name);
  return connection_.ForEachRow(
      kLockSources,
      [&](const PostgresRow& row) {
        found[row.Text(1)] = {.id = row.Integer(0),
                              .is_session = row.Boolean(2),
                              .revoked = row.Boolean(3),
                              .commit_sequence = row.Unsigned(4),
                              .writer = row.Unsigned(5)};
      },
      array);
}

absl::Status PostgresSources::Add(std::span<const NewSource* const> sources, LockedSources& found) {
  if (sources.empty()) return absl::OkStatus();
  std::vector<int64_t> numbers;
  absl::Status status = connection_.ForEachRow(
      kNextIds, [&](const PostgresRow& row) { numbers.push_back(row.Integer(0)); }, sources.size());
  if (!status.ok()) return status;
  PostgresArray ids, names, builds, last_seen;
  for (size_t i = 0; i < sources.size(); ++i) {
    found[sources[i]->name].id = numbers[i];
    ids.Add(numbers[i]);
    names.Add(sources[i]->name);
    builds.Add(sources[i]->build);
    last_seen.Add(sources[i]->last_seen_unix_s);
  }
  size_t added = 0;
  status = connection_.ForEachRow(
      kAddSources, [&](const PostgresRow&) { ++added; }, ids, names, builds, last_seen);
  if (!status.ok() || added == sources.size()) return status;
  return absl::AbortedError("another daemon has added a source at the same time");
}

absl::Status PostgresSources::Update(const LockedSources& sources) {
  PostgresArray ids, commits, messages, arms, decisions, frames, seeds, last_seen, writers, created,
      builds, tokens;
  bool any = false;
  for (const auto& [name, source] : sources) {
    if (source.last == nullptr) continue;
    any = true;
    const auto& progress = source.last->progress;
    ids.Add(source.id);
    commits.Add(progress.commit_sequence);
    messages.Add(progress.message_sequence);
    arms.Add(progress.explored_arm_count);
    decisions.Add(progress.decision_count);
    frames.Add(progress.frame_count);
    seeds.Add(static_cast<int64_t>(progress.seed));
    last_seen.Add(source.last->unix_time_s);
    writers.Add(static_cast<int64_t>(source.writer));
    created.Add(source.first->unix_time_s);
    builds.Add(source.first->origin.build);
    tokens.Add(source.first->origin.token_id);
  }
  if (!any) return absl::OkStatus();
  return connection_.Run(kUpdateSources, ids, commits, messages, arms, decisions, frames, seeds,
                         last_seen, writers, created, builds, tokens);
}

absl::StatusOr<MatchingSources> PostgresSources::LockMatching(const priors::SourceFilter& filter,
                                                              bool quarantined) {
  MatchingSources matching;
  absl::Status status = connection_.ForEachRow(
      kLockMatching,
      [&](const PostgresRow& row) {
        matching.ids.Add(row.Integer(0));
        ++matching.count;
      },
      filter.id, filter.build, filter.token_id, filter.from_unix_s, filter.until_unix_s,
      filter.project, decision::kAdminSession, quarantined);
  if (!status.ok()) return status;
  return matching;
}

absl::Status PostgresSources::Bar(const PostgresArray& ids) { return connection_.Run(kBar, ids); }

}  // namespace sweepstake::storage
