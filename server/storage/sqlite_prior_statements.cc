#include "server/storage/sqlite_prior_statements.h"

#include <utility>

namespace sweepstake::storage {
namespace {

template <typename Statements>
struct StatementText {
  SqliteStatement Statements::*statement;
  const char* sql;
};

// An upsert returns a row exactly if it changed something. This shows repeated updates, revoked
// sources, and the sessions of this store, which imports leave alone.
//
// Counts are added by total() or up to their maximum, because an overflow would make a scene
// unreadable after two imported records.
//
// Each statement that writes a row writes its hash (sqlite_schema.h): row_hash of the values of a
// new row, and next_hash for a changed one, which keeps a wrong hash wrong.
constexpr StatementText<PriorStatements> kStatements[] = {
    {&PriorStatements::advance_source, R"sql(
        INSERT INTO source (name, is_session, revoked, commit_sequence, message_sequence,
                            explored_arm_count, decision_count, frame_count, seed,
                            created_unix_s, last_seen_unix_s, build, token_id, hash)
        VALUES (?1, 1, 0, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?8, ?9, ?10,
                row_hash(?1, 1, 0, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?8, ?9, ?10))
        ON CONFLICT (name) DO UPDATE
          SET is_session = 1, commit_sequence = ?2, message_sequence = ?3, explored_arm_count = ?4,
              decision_count = ?5, frame_count = ?6, seed = ?7,
              created_unix_s = iif(is_session, created_unix_s, ?8), last_seen_unix_s = ?8,
              build = iif(is_session, build, ?9), token_id = iif(is_session, token_id, ?10),
              hash = next_hash(hash, content_hash,
                               row_hash(name, 1, revoked, ?2, ?3, ?4, ?5, ?6, ?7,
                                        iif(is_session, created_unix_s, ?8), ?8,
                                        iif(is_session, build, ?9),
                                        iif(is_session, token_id, ?10)))
          WHERE revoked = 0 AND ?2 > commit_sequence
        RETURNING id)sql"},
    {&PriorStatements::add_scene, R"sql(
        INSERT INTO scene (project, scene, machine_class, reward_version, source_count, hash)
        VALUES (?1, ?2, ?3, ?4, 0, row_hash(?1, ?2, ?3, ?4, 0))
        ON CONFLICT DO UPDATE SET project = ?1
        RETURNING id)sql"},
    {&PriorStatements::add_key, R"sql(
        INSERT INTO evidence_key (project, scene, measured_by, arm, backend_version,
                                  machine_class, reward_version, scene_id, hash)
        VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8,
                row_hash(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, 0.0, 0.0, 0, 0, 0))
        RETURNING id)sql"},
    {&PriorStatements::advance_evidence, R"sql(
        UPDATE evidence
        SET sequence = ?3, alpha = alpha + ?4, beta = beta + ?5,
            window_count = window_count + ?6, bail_out_count = bail_out_count + ?7,
            hash = next_hash(hash, content_hash,
                             row_hash(key_id, source_id, ?3, alpha + ?4, beta + ?5,
                                      window_count + ?6, bail_out_count + ?7))
        WHERE key_id = ?1 AND source_id = ?2
        RETURNING 1)sql"},
    {&PriorStatements::add_evidence, R"sql(
        INSERT INTO evidence (key_id, source_id, sequence, alpha, beta, window_count,
                              bail_out_count, hash)
        VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, row_hash(?1, ?2, ?3, ?4, ?5, ?6, ?7)))sql"},
    {&PriorStatements::add_to_sums, R"sql(
        UPDATE evidence_key
        SET alpha_sum = alpha_sum + ?2, beta_sum = beta_sum + ?3,
            window_sum = min(window_sum, 9223372036854775807 - ?4) + ?4,
            bail_out_sum = min(bail_out_sum, 9223372036854775807 - ?5) + ?5,
            source_count = source_count + ?6,
            hash = next_hash(hash, content_hash,
                             row_hash(project, scene, measured_by, arm, backend_version,
                                      machine_class, reward_version, scene_id, alpha_sum + ?2,
                                      beta_sum + ?3,
                                      min(window_sum, 9223372036854775807 - ?4) + ?4,
                                      min(bail_out_sum, 9223372036854775807 - ?5) + ?5,
                                      source_count + ?6))
        WHERE id = ?1)sql"},
    {&PriorStatements::recount_sums, R"sql(
        UPDATE evidence_key
        SET (alpha_sum, beta_sum, window_sum, bail_out_sum, source_count, hash) = (a, b, w, o, n,
            next_hash(hash, content_hash,
                      row_hash(project, scene, measured_by, arm, backend_version, machine_class,
                               reward_version, scene_id, a, b, w, o, n)))
        FROM (SELECT total(alpha) AS a, total(beta) AS b, CAST(total(window_count) AS INTEGER) AS w,
                     CAST(total(bail_out_count) AS INTEGER) AS o, count(*) AS n
              FROM evidence WHERE key_id = ?1 AND hash = content_hash)
        WHERE id = ?1)sql"},
    {&PriorStatements::join_scene, R"sql(
        INSERT INTO scene_source (source_id, scene_id) VALUES (?1, ?2)
        ON CONFLICT DO NOTHING RETURNING 1)sql"},
    {&PriorStatements::count_source, R"sql(
        UPDATE scene
        SET source_count = source_count + 1,
            hash = next_hash(hash, content_hash,
                             row_hash(project, scene, machine_class, reward_version,
                                      source_count + 1))
        WHERE id = ?1
        RETURNING project, scene, source_count)sql"},
    {&PriorStatements::import_source, R"sql(
        INSERT INTO source (name, is_session, revoked, commit_sequence, message_sequence,
                            explored_arm_count, decision_count, frame_count, seed, build, last_seen_unix_s,
                            hash)
        VALUES (?1, 0, 0, 0, 0, 0, 0, 0, 0, ?2, ?3,
                row_hash(?1, 0, 0, 0, 0, 0, 0, 0, 0, 0, ?3, ?2, 0))
        ON CONFLICT (name) DO UPDATE SET name = name WHERE revoked = 0 AND is_session = 0
        RETURNING id)sql"},
    {&PriorStatements::import_evidence, R"sql(
        INSERT INTO evidence (key_id, source_id, sequence, alpha, beta, window_count,
                              bail_out_count, hash)
        VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, row_hash(?1, ?2, ?3, ?4, ?5, ?6, ?7))
        ON CONFLICT DO UPDATE
          SET sequence = ?3, alpha = ?4, beta = ?5, window_count = ?6, bail_out_count = ?7,
              hash = next_hash(hash, content_hash, row_hash(key_id, source_id, ?3, ?4, ?5, ?6, ?7))
          WHERE ?3 > sequence
        RETURNING 1)sql"},
    {&PriorStatements::revoke_source, R"sql(
        INSERT INTO source (name, is_session, revoked, commit_sequence, message_sequence,
                            explored_arm_count, decision_count, frame_count, seed, hash)
        VALUES (?1, 0, 1, 0, 0, 0, 0, 0, 0, row_hash(?1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, '', 0))
        ON CONFLICT (name) DO UPDATE
          SET revoked = 1,
              hash = next_hash(hash, content_hash,
                               row_hash(name, is_session, 1, commit_sequence, message_sequence,
                                        explored_arm_count, decision_count, frame_count, seed,
                                        created_unix_s, last_seen_unix_s, build, token_id))
        RETURNING id)sql"},
    {&PriorStatements::matching_sources, R"sql(
        SELECT id, name FROM source
        WHERE (revoked = 0 OR ?8) AND (?1 = '' OR name = ?1) AND (?2 = '' OR build = ?2)
          AND (?3 = 0 OR token_id = ?3) AND created_unix_s BETWEEN ?4 AND ?5 AND name <> ?7
          AND (?6 = ''
               OR EXISTS (SELECT 1 FROM scene_source j JOIN scene s ON s.id = scene_id
                          WHERE source_id = source.id AND project = ?6)
               OR EXISTS (SELECT 1 FROM quarantined_evidence q JOIN evidence_key k ON k.id = key_id
                          WHERE source_id = source.id AND project = ?6))
          AND (NOT ?8
               OR EXISTS (SELECT 1 FROM quarantined_evidence WHERE source_id = source.id)))sql"},
    {&PriorStatements::leave_scenes, R"sql(
        UPDATE scene
        SET source_count = source_count - 1,
            hash = next_hash(hash, content_hash,
                             row_hash(project, scene, machine_class, reward_version,
                                      source_count - 1))
        WHERE (?2 = '' OR project = ?2)
          AND id IN (SELECT scene_id FROM scene_source WHERE source_id = ?1))sql"},
    {&PriorStatements::forget_scenes, R"sql(
        DELETE FROM scene_source
        WHERE source_id = ?1
          AND (?2 = '' OR (SELECT project FROM scene WHERE id = scene_id) = ?2))sql"},
    {&PriorStatements::delete_evidence, R"sql(
        DELETE FROM evidence
        WHERE source_id = ?1
          AND (?2 = '' OR (SELECT project FROM evidence_key WHERE id = key_id) = ?2)
        RETURNING key_id, window_count)sql"},
    {&PriorStatements::quarantine_evidence, R"sql(
        INSERT INTO quarantined_evidence (key_id, source_id, sequence, alpha, beta, window_count,
                                          bail_out_count, hash)
        SELECT ?1, ?2, ?3, ?4, ?5, ?6, ?7, row_hash(?1, ?2, ?3, ?4, ?5, ?6, ?7)
        WHERE NOT EXISTS (SELECT 1 FROM evidence
                          WHERE key_id = ?1 AND source_id = ?2 AND sequence >= ?3)
        ON CONFLICT DO UPDATE
          SET sequence = ?3, alpha = ?4, beta = ?5, window_count = ?6, bail_out_count = ?7,
              hash = next_hash(hash, content_hash, row_hash(key_id, source_id, ?3, ?4, ?5, ?6, ?7))
          WHERE ?3 > sequence
        RETURNING 1)sql"},
    {&PriorStatements::drop_quarantined, R"sql(
        DELETE FROM quarantined_evidence
        WHERE key_id = ?1 AND source_id = ?2 AND sequence <= ?3)sql"},
    {&PriorStatements::forget_quarantined, R"sql(
        DELETE FROM quarantined_evidence
        WHERE source_id = ?1
          AND (?2 = '' OR (SELECT project FROM evidence_key WHERE id = key_id) = ?2)
        RETURNING window_count)sql"},
    {&PriorStatements::quarantined_of_source, R"sql(
        SELECT q.key_id, k.scene_id, sequence, alpha, beta, window_count, bail_out_count
        FROM quarantined_evidence q CROSS JOIN evidence_key k ON k.id = q.key_id
        WHERE source_id = ?1 AND (?2 = '' OR project = ?2) AND q.hash = q.content_hash
        ORDER BY key_id)sql"},
    {&PriorStatements::count_quarantined, "SELECT count(*) FROM quarantined_evidence"},
};

constexpr StatementText<PriorReadStatements> kReadStatements[] = {
    // The scene's classes of machines: the given one first, then the newest ones.
    {&PriorReadStatements::scene_classes, R"sql(
        SELECT id, machine_class, hash = content_hash FROM scene
        WHERE project = ?1 AND scene = ?2 AND reward_version = ?4 AND source_count > 0
        ORDER BY machine_class = ?3 DESC, id DESC LIMIT ?5)sql"},
    {&PriorReadStatements::scene_keys, R"sql(
        SELECT id, arm, backend_version, measured_by, hash = content_hash FROM evidence_key
        WHERE scene_id = ?1 AND source_count > 0)sql"},
    {&PriorReadStatements::latest_sources, R"sql(
        SELECT source_id FROM evidence WHERE key_id = ?1 ORDER BY source_id DESC LIMIT ?2)sql"},
    {&PriorReadStatements::token_of_source, "SELECT token_id FROM source WHERE id = ?1"},
    {&PriorReadStatements::evidence_of_source, R"sql(
        SELECT name, build, last_seen_unix_s, alpha, beta, window_count, bail_out_count
        FROM evidence e CROSS JOIN source s ON s.id = e.source_id
        WHERE key_id = ?1 AND source_id = ?2
          AND e.hash = e.content_hash AND s.hash = s.content_hash)sql"},
    {&PriorReadStatements::find_key, R"sql(
        SELECT id, scene_id FROM evidence_key
        WHERE project = ?1 AND scene = ?2 AND measured_by = ?3 AND arm = ?4
          AND backend_version = ?5 AND machine_class = ?6 AND reward_version = ?7)sql"},
    {&PriorReadStatements::load_source, R"sql(
        SELECT id, commit_sequence, message_sequence, explored_arm_count, decision_count,
               frame_count, seed, created_unix_s, last_seen_unix_s, hash = content_hash
        FROM source WHERE name = ?1 AND is_session = 1 AND revoked = 0)sql"},
    {&PriorReadStatements::source_evidence, R"sql(
        SELECT project, scene, measured_by, arm, backend_version, machine_class, reward_version,
               alpha, beta, window_count, bail_out_count,
               k.hash = k.content_hash AND evidence.hash = evidence.content_hash
        FROM evidence JOIN evidence_key k ON k.id = key_id
        WHERE source_id = ?1
        ORDER BY project, scene, measured_by, arm, backend_version, machine_class,
                 reward_version)sql"},
    // The row value ends the range of the index at the project and the scene, if given. A blob
    // sorts after every text.
    {&PriorReadStatements::list_scenes, R"sql(
        SELECT id, source_count, project, scene, machine_class, reward_version FROM scene
        WHERE (project, scene) <= (iif(?1 = '', x'', ?1), iif(?2 = '', x'', ?2))
          AND (?1 = '' OR project = ?1) AND (?2 = '' OR scene = ?2)
          AND (project, scene, machine_class, reward_version) > (?3, ?4, ?5, ?6)
          AND source_count > 0 AND hash = content_hash
          AND NOT EXISTS (SELECT 1 FROM evidence_key k
                          WHERE k.scene_id = scene.id AND k.hash <> k.content_hash)
          AND (?8 = '' OR instr(?8, char(10) || project || char(10)))
        ORDER BY project, scene, machine_class, reward_version LIMIT ?7)sql"},
    {&PriorReadStatements::count_scenes, R"sql(
        SELECT count(DISTINCT scene), count(*) FROM scene
        WHERE project = ?1 AND source_count > 0)sql"},
    {&PriorReadStatements::other_keys_of_name, R"sql(
        SELECT 1 FROM scene
        WHERE project = ?1 AND scene = ?2 AND source_count > 0 AND id <> ?3 LIMIT 1)sql"},
    // Jumps from one project to the next in the index, however many scenes they have.
    {&PriorReadStatements::count_projects, R"sql(
        WITH RECURSIVE known(project) AS (
          SELECT min(project) FROM scene
          UNION ALL
          SELECT (SELECT min(project) FROM scene WHERE project > known.project)
          FROM known WHERE project IS NOT NULL)
        SELECT count(*) FROM known
        WHERE EXISTS (SELECT 1 FROM scene
                      WHERE project = known.project AND source_count > 0))sql"},
    {&PriorReadStatements::find_scene, R"sql(
        SELECT id, source_count,
               hash = content_hash
                 AND NOT EXISTS (SELECT 1 FROM evidence_key k
                                 WHERE k.scene_id = scene.id AND k.hash <> k.content_hash)
        FROM scene
        WHERE project = ?1 AND scene = ?2 AND machine_class = ?3 AND reward_version = ?4
          AND source_count > 0)sql"},
    {&PriorReadStatements::scene_arms, R"sql(
        SELECT arm, backend_version, measured_by, alpha_sum, beta_sum, window_sum, bail_out_sum
        FROM evidence_key WHERE scene_id = ?1 AND source_count > 0
        ORDER BY arm, backend_version)sql"},
    {&PriorReadStatements::scene_ages, R"sql(
        SELECT arm, backend_version,
               (SELECT coalesce(max(last_seen_unix_s), 0)
                FROM (SELECT source_id FROM evidence WHERE key_id = evidence_key.id
                      ORDER BY source_id DESC LIMIT ?2) e
                     CROSS JOIN source s ON s.id = e.source_id AND s.hash = s.content_hash)
        FROM evidence_key WHERE scene_id = ?1 AND source_count > 0)sql"},
    // The row value finds its place in the index without reading what comes before it.
    {&PriorReadStatements::next_key, R"sql(
        SELECT project, scene, measured_by, arm, backend_version, machine_class, reward_version,
               id, hash = content_hash
        FROM evidence_key
        WHERE (project, scene, measured_by, arm, backend_version, machine_class, reward_version)
              >= (?3, ?4, ?5, ?6, ?7, ?8, ?9)
          AND (?1 = '' OR project = ?1) AND (?2 = '' OR scene = ?2)
          AND (?10 = '' OR instr(?10, char(10) || project || char(10)))
          AND EXISTS (SELECT 1 FROM evidence WHERE key_id = id)
        ORDER BY 1, 2, 3, 4, 5, 6, 7 LIMIT 1)sql"},
    {&PriorReadStatements::key_evidence, R"sql(
        SELECT s.id, name, sequence, alpha, beta, window_count, bail_out_count,
               e.hash = e.content_hash AND s.hash = s.content_hash, build, last_seen_unix_s,
               NOT is_session
        FROM evidence e CROSS JOIN source s ON s.id = source_id
        WHERE key_id = ?1 AND source_id > ?2
        ORDER BY source_id LIMIT ?3)sql"},
    {&PriorReadStatements::next_quarantined_key, R"sql(
        SELECT project, scene, measured_by, arm, backend_version, machine_class, reward_version,
               id, hash = content_hash
        FROM evidence_key
        WHERE (project, scene, measured_by, arm, backend_version, machine_class, reward_version)
              >= (?3, ?4, ?5, ?6, ?7, ?8, ?9)
          AND (?1 = '' OR project = ?1) AND (?2 = '' OR scene = ?2)
          AND (?10 = '' OR instr(?10, char(10) || project || char(10)))
          AND EXISTS (SELECT 1 FROM quarantined_evidence WHERE key_id = id)
        ORDER BY 1, 2, 3, 4, 5, 6, 7 LIMIT 1)sql"},
    {&PriorReadStatements::quarantined_evidence, R"sql(
        SELECT s.id, name, sequence, alpha, beta, window_count, bail_out_count,
               q.hash = q.content_hash AND s.hash = s.content_hash, build, last_seen_unix_s,
               NOT is_session
        FROM quarantined_evidence q CROSS JOIN source s ON s.id = source_id
        WHERE key_id = ?1 AND source_id > ?2
        ORDER BY source_id LIMIT ?3)sql"},
};

template <typename Statements, size_t kCount>
absl::StatusOr<Statements> PrepareAll(SqliteDatabase& database,
                                      const StatementText<Statements> (&texts)[kCount]) {
  Statements statements;
  for (const StatementText<Statements>& text : texts) {
    auto statement = database.Prepare(text.sql);
    if (!statement.ok()) return statement.status();
    statements.*text.statement = *std::move(statement);
  }
  return statements;
}

}  // namespace

absl::StatusOr<PriorStatements> PriorStatements::Prepare(SqliteDatabase& database) {
  return PrepareAll(database, kStatements);
}

absl::StatusOr<PriorReadStatements> PriorReadStatements::Prepare(SqliteDatabase& database) {
  return PrepareAll(database, kReadStatements);
}

}  // namespace sweepstake::storage
