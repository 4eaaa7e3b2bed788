#include "server/storage/postgres/postgres_quarantine.h"

#include "server/storage/record_limits.h"

namespace sweepstake::storage {
namespace {

constexpr const char* kLoad = R"sql(
    SELECT key_id, source_id, sequence, alpha, beta, window_count, bail_out_count
    FROM unnest($1::bigint[], $2::bigint[]) AS given(key_id, source_id)
         JOIN quarantined_evidence USING (key_id, source_id))sql";
constexpr const char* kPut = R"sql(
    INSERT INTO quarantined_evidence (key_id, source_id, sequence, alpha, beta, window_count,
                                      bail_out_count)
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::numeric[], $5::numeric[],
                         $6::numeric[], $7::numeric[])
    ON CONFLICT (key_id, source_id) DO UPDATE
      SET sequence = excluded.sequence, alpha = excluded.alpha, beta = excluded.beta,
          window_count = excluded.window_count, bail_out_count = excluded.bail_out_count)sql";
constexpr const char* kCount = "SELECT count(*) FROM quarantined_evidence";
constexpr const char* kDrop = R"sql(
    DELETE FROM quarantined_evidence q
    USING unnest($1::bigint[], $2::bigint[], $3::bigint[]) AS newer(key_id, source_id, sequence)
    WHERE q.key_id = newer.key_id AND q.source_id = newer.source_id
      AND q.sequence <= newer.sequence)sql";
constexpr const char* kTakeOut = R"sql(
    DELETE FROM quarantined_evidence q USING evidence_key k
    WHERE k.id = q.key_id AND q.source_id = ANY($1::bigint[]) AND ($2 = '' OR k.project = $2)
    RETURNING q.key_id, q.source_id, q.sequence, q.alpha, q.beta, q.window_count,
              q.bail_out_count, k.scene_id)sql";

// The columns that identify rows, as parameters.
struct PlaceArrays {
  PostgresArray keys, sources, sequences;

  void Add(const RowPlace& place, uint64_t sequence) {
    keys.Add(place.first);
    sources.Add(place.second);
    sequences.Add(sequence);
  }
};

}  // namespace

absl::StatusOr<RowChanges> PostgresQuarantine::Load(const std::set<RowPlace>& places) {
  PlaceArrays arrays;
  for (const RowPlace& place : places) arrays.Add(place, 0);
  RowChanges rows;
  absl::Status status = connection_.ForEachRow(
      kLoad,
      [&](const PostgresRow& row) {
        rows[{row.Integer(0), row.Integer(1)}] = {row.Unsigned(2), UnitsOf(row, 3)};
      },
      arrays.keys, arrays.sources);
  if (!status.ok()) return status;
  return rows;
}

absl::Status PostgresQuarantine::Put(const RowChanges& rows) {
  PlaceArrays places;
  UnitArrays units;
  for (const auto& [place, row] : rows) {
    places.Add(place, row.sequence);
    units.Add(row.units);
  }
  return connection_.Run(kPut, places.keys, places.sources, places.sequences, units.alpha,
                         units.beta, units.window_count, units.bail_out_count);
}

absl::Status PostgresQuarantine::CheckSize(uint64_t max_rows) {
  uint64_t count = 0;
  absl::Status status =
      connection_.ForEachRow(kCount, [&](const PostgresRow& row) { count = row.Unsigned(0); });
  return status.ok() ? QuarantineBound(count, max_rows) : status;
}

absl::Status PostgresQuarantine::Drop(const RowChanges& newer) {
  PlaceArrays arrays;
  for (const auto& [place, row] : newer) arrays.Add(place, row.sequence);
  return connection_.Run(kDrop, arrays.keys, arrays.sources, arrays.sequences);
}

absl::StatusOr<QuarantinedRows> PostgresQuarantine::TakeOut(const PostgresArray& sources,
                                                            const std::string& project) {
  QuarantinedRows taken;
  absl::Status status = connection_.ForEachRow(
      kTakeOut,
      [&](const PostgresRow& row) {
        const EvidenceUnits units = UnitsOf(row, 3);
        taken.rows[{row.Integer(0), row.Integer(1)}] = {row.Unsigned(2), units};
        taken.window_count += static_cast<uint64_t>(units.window_count);
        taken.scenes.insert(row.Integer(7));
      },
      sources, project);
  if (!status.ok()) return status;
  return taken;
}

}  // namespace sweepstake::storage
