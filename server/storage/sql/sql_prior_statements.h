// The SQL statements of SqlPriorStore (sql_prior_store.h), in the form that SqlDatabase explains.
//
// In SQLite each statement that writes a row also writes its hash (sql_schema.h). A new row gets
// row_hash of its values. A changed row gets next_hash, which keeps a wrong hash wrong, so that
// damage stays visible.
#pragma once

namespace sweepstake::storage {

inline constexpr const char* kLockSources = R"sql(
    SELECT name, id, is_session, revoked, commit_sequence, [0]{writer} FROM source{, @given}
    WHERE name = ?1 {ORDER BY name FOR NO KEY UPDATE OF source})sql";
inline constexpr const char* kNextSourceIds = R"sql(
    [WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < ?1)
     SELECT i + (SELECT coalesce(max(id), 0) FROM source) FROM n]
    {SELECT nextval('source_number') FROM generate_series(1, ?1)})sql";
inline constexpr const char* kAddSources = R"sql(
    INSERT INTO source (id, name, build, last_seen_unix_s[, hash])
    [VALUES (?1, ?2, ?3, ?4, row_hash(?2, 0, 0, 0, 0, 0, 0, 0, 0, 0, ?4, ?3, 0, '', ''))]
    {SELECT ?1, ?2, ?3, ?4 FROM @given} ON CONFLICT (name) DO NOTHING RETURNING id)sql";
// The first commit of a source sets created_unix_s and its origin. Later commits keep them.
inline constexpr const char* kUpdateSources = R"sql(
    UPDATE source
    SET is_session = true, commit_sequence = ?2, message_sequence = ?3, explored_arm_count = ?4,
        decision_count = ?5, frame_count = ?6, seed = ?7, last_seen_unix_s = ?8,
        created_unix_s = CASE WHEN is_session THEN created_unix_s ELSE ?9 END,
        build = CASE WHEN is_session THEN build ELSE ?10 END,
        token_id = CASE WHEN is_session THEN token_id ELSE ?11 END,
        player = CASE WHEN is_session THEN player ELSE ?12 END,
        network = CASE WHEN is_session THEN network ELSE ?13 END
        {, writer = ?14}
        [, hash = next_hash(hash, content_hash,
                            row_hash(name, 1, revoked, ?2, ?3, ?4, ?5, ?6, ?7,
                                     iif(is_session, created_unix_s, ?9), ?8,
                                     iif(is_session, build, ?10),
                                     iif(is_session, token_id, ?11),
                                     iif(is_session, player, ?12),
                                     iif(is_session, network, ?13)))]
    {FROM @given} WHERE id = ?1)sql";
inline constexpr const char* kLockMatching = R"sql(
    SELECT id FROM source
    WHERE (NOT revoked OR ?8) AND (?1 = '' OR name = ?1) AND (?2 = '' OR build = ?2)
      AND (?3 = 0 OR token_id = ?3) AND (?9 = '' OR player = ?9) AND (?10 = '' OR network = ?10)
      AND created_unix_s BETWEEN ?4 AND ?5 AND name <> ?7
      AND (?6 = ''
           OR EXISTS (SELECT 1 FROM scene_source j JOIN scene s ON s.id = scene_id
                      WHERE source_id = source.id AND project = ?6)
           OR EXISTS (SELECT 1 FROM quarantined_evidence q JOIN evidence_key k ON k.id = key_id
                      WHERE source_id = source.id AND project = ?6))
      AND (NOT ?8 OR EXISTS (SELECT 1 FROM quarantined_evidence WHERE source_id = source.id))
    ORDER BY name {FOR NO KEY UPDATE})sql";
inline constexpr const char* kBar = R"sql(
    UPDATE source
    SET revoked = true
        [, hash = next_hash(hash, content_hash,
                            row_hash(name, is_session, 1, commit_sequence, message_sequence,
                                     explored_arm_count, decision_count, frame_count, seed,
                                     created_unix_s, last_seen_unix_s, build, token_id, player,
                                     network))]
    {FROM @given} WHERE id = ?1)sql";

inline constexpr const char* kCountCommits =
    "SELECT CAST(total(commit_sequence) AS INTEGER) FROM source";

inline constexpr const char* kFindKeys = R"sql(
    SELECT ?9, id, scene_id, is_known FROM evidence_key{, @given}
    WHERE project = ?1 AND scene = ?2 AND measured_by = ?3 AND arm = ?4 AND backend_version = ?5
      AND machine_class = ?6 AND reward_version = ?7 AND regime = ?8)sql";
inline constexpr const char* kAddScenes = R"sql(
    INSERT INTO scene (project, scene, machine_class, reward_version, added_by_token,
                       added_by_party[, hash])
    [VALUES (?1, ?2, ?3, ?4, ?5, ?6, row_hash(?1, ?2, ?3, ?4, 0, 0, ?5, ?6))]
    {SELECT ?1, ?2, ?3, ?4, ?5, ?6 FROM @given} ON CONFLICT DO NOTHING)sql";
// Counts the scenes of this name that the party has added, and whether the given one is stored.
inline constexpr const char* kCountAdded = R"sql(
    SELECT coalesce(sum(CASE WHEN added_by_token = ?5 AND added_by_party = ?6 THEN 1 ELSE 0 END), 0),
           coalesce(max(CASE WHEN machine_class = ?3 AND reward_version = ?4 THEN 1 ELSE 0 END), 0)
    FROM scene WHERE project = ?1 AND scene = ?2)sql";
// The regimes of a scene on all machine classes.
inline constexpr const char* kRegimes = R"sql(
    SELECT DISTINCT regime FROM evidence_key
    WHERE project = ?1 AND scene = ?2 AND reward_version = ?3 AND regime <> ''
      AND source_count > 0)sql";
// ON CONFLICT DO NOTHING, because another daemon may have added a key after kFindKeys found
// none.
inline constexpr const char* kAddKeys = R"sql(
    INSERT INTO evidence_key (project, scene, measured_by, arm, backend_version, machine_class,
                              reward_version, regime, scene_id[, hash])
    SELECT ?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, id
           [, row_hash(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, id, 0.0, 0.0, 0, 0, 0, 0)]
    FROM scene{, @given}
    WHERE project = ?1 AND scene = ?2 AND machine_class = ?6 AND reward_version = ?7
    {ORDER BY 1, 2, 3, 4, 5, 6, 7, 8} ON CONFLICT DO NOTHING)sql";

// ForBothTables replaces the word TABLE by `evidence` or by `quarantined_evidence`.
inline constexpr const char* kLoadSequences = R"sql(
    SELECT key_id, source_id, sequence FROM TABLE{, @given}
    WHERE key_id = ?1 AND source_id = ?2)sql";
inline constexpr const char* kPutRows = R"sql(
    INSERT INTO TABLE (key_id, source_id, sequence, alpha, beta, window_count,
                       bail_out_count[, hash])
    [VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, row_hash(?1, ?2, ?3, ?4, ?5, ?6, ?7))]
    {SELECT ?1, ?2, ?3, ?4, ?5, ?6, ?7 FROM @given}
    ON CONFLICT (key_id, source_id) DO UPDATE
      SET sequence = excluded.sequence, alpha = excluded.alpha, beta = excluded.beta,
          window_count = excluded.window_count, bail_out_count = excluded.bail_out_count
          [, hash = next_hash(hash, content_hash, excluded.hash)])sql";
// Has no RETURNING clause, because SQLite would then keep a journal of each changed row.
inline constexpr const char* kAddToRows = R"sql(
    UPDATE evidence
    SET sequence = ?3, alpha = alpha + ?4, beta = beta + ?5, window_count = window_count + ?6,
        bail_out_count = bail_out_count + ?7
        [, hash = next_hash(hash, content_hash,
                            row_hash(key_id, source_id, ?3, alpha + ?4, beta + ?5,
                                     window_count + ?6, bail_out_count + ?7))]
    {FROM @given} WHERE key_id = ?1 AND source_id = ?2)sql";
inline constexpr const char* kLockKeys = R"sql({
    SELECT 1 FROM evidence_key, @given WHERE id = ?1 ORDER BY id FOR NO KEY UPDATE OF evidence_key
    })sql";
// In SQLite the sums of counts stop at 2^63 - 1. Without this limit two imported records could
// overflow a sum, which would make the scene unreadable.
inline constexpr const char* kAddToSums = R"sql(
    UPDATE evidence_key
    SET alpha_sum = alpha_sum + ?2, beta_sum = beta_sum + ?3,
        window_sum = [min(window_sum, 9223372036854775807 - ?4)]{window_sum} + ?4,
        bail_out_sum = [min(bail_out_sum, 9223372036854775807 - ?5)]{bail_out_sum} + ?5,
        source_count = source_count + ?6
        [, hash = next_hash(hash, content_hash,
                            row_hash(project, scene, measured_by, arm, backend_version,
                                     machine_class, reward_version, regime, scene_id,
                                     alpha_sum + ?2, beta_sum + ?3,
                                     min(window_sum, 9223372036854775807 - ?4) + ?4,
                                     min(bail_out_sum, 9223372036854775807 - ?5) + ?5,
                                     source_count + ?6, is_known))]
    {FROM @given} WHERE id = ?1)sql";
inline constexpr const char* kMakeKnown = R"sql(
    UPDATE evidence_key
    SET is_known = true
        [, hash = next_hash(hash, content_hash,
                            row_hash(project, scene, measured_by, arm, backend_version,
                                     machine_class, reward_version, regime, scene_id, alpha_sum,
                                     beta_sum, window_sum, bail_out_sum, source_count, 1))]
    {FROM @given} WHERE id = ?1)sql";
// Arms without evidence, after a revocation.
inline constexpr const char* kMakeUnknown = R"sql(
    UPDATE evidence_key
    SET is_known = false
        [, hash = next_hash(hash, content_hash,
                            row_hash(project, scene, measured_by, arm, backend_version,
                                     machine_class, reward_version, regime, scene_id, alpha_sum,
                                     beta_sum, window_sum, bail_out_sum, source_count, 0))]
    {FROM @given} WHERE scene_id = ?1 AND source_count = 0 AND is_known)sql";
inline constexpr const char* kMakeScenesKnown = R"sql(
    UPDATE scene
    SET is_known = true
        [, hash = next_hash(hash, content_hash,
                            row_hash(project, scene, machine_class, reward_version, source_count, 1,
                                     added_by_token, added_by_party))]
    {FROM @given} WHERE id = ?1)sql";
inline constexpr const char* kRecountSums = R"sql(
    UPDATE evidence_key
    SET (alpha_sum, beta_sum, window_sum, bail_out_sum, source_count[, hash]) =
          (SELECT a, b, w, o, n
                  [, next_hash(hash, content_hash,
                               row_hash(project, scene, measured_by, arm, backend_version,
                                        machine_class, reward_version, regime, scene_id, a, b, w,
                                        o, n, is_known))]
           FROM (SELECT [total(alpha)]{coalesce(sum(alpha), 0)} AS a,
                        [total(beta)]{coalesce(sum(beta), 0)} AS b,
                        [CAST(total(window_count) AS INTEGER)]{coalesce(sum(window_count), 0)} AS w,
                        [CAST(total(bail_out_count) AS INTEGER)]
                        {coalesce(sum(bail_out_count), 0)} AS o, count(*) AS n
                 FROM evidence WHERE key_id = ?1 [AND evidence.hash = evidence.content_hash]) sums)
    {FROM @given} WHERE id = ?1)sql";
inline constexpr const char* kDeleteEvidence = R"sql(
    DELETE FROM evidence {USING @given}
    WHERE source_id = ?1
      AND (?2 = '' OR (SELECT project FROM evidence_key WHERE id = key_id) = ?2)
    RETURNING key_id, window_count)sql";

// Adds sources to scenes. Returns the scenes that gained a source.
inline constexpr const char* kJoinScenes = R"sql(
    INSERT INTO scene_source (source_id, scene_id, token_id, party)
    SELECT ?1, ?2, token_id, CASE WHEN player = '' THEN network ELSE player END
    FROM source{, @given} WHERE id = ?1
    ON CONFLICT DO NOTHING RETURNING scene_id)sql";
// Several of the sources can be of one party.
inline constexpr const char* kJoinParties = R"sql(
    INSERT INTO scene_party (scene_id, token_id, party, latest_source_id)
    SELECT scene_id, token_id, party, max(source_id) FROM scene_source{, @given}
    WHERE source_id = ?1 AND scene_id = ?2 GROUP BY 1, 2, 3 {ORDER BY 1, 2, 3}
    ON CONFLICT (scene_id, token_id, party) DO UPDATE
      SET latest_source_id = [max]{greatest}(scene_party.latest_source_id,
                                             excluded.latest_source_id))sql";
inline constexpr const char* kLeaveScenes = R"sql(
    DELETE FROM scene_source {USING @given}
    WHERE source_id = ?1 AND (?2 = '' OR (SELECT project FROM scene WHERE id = scene_id) = ?2)
    RETURNING scene_id, token_id, party)sql";
inline constexpr const char* kLeaveParties = R"sql(
    DELETE FROM scene_party {USING @given}
    WHERE scene_id = ?1 AND token_id = ?2 AND party = ?3)sql";
// Adds the parties that still have sources in the scene.
inline constexpr const char* kKeepParties = R"sql(
    INSERT INTO scene_party (scene_id, token_id, party, latest_source_id)
    SELECT scene_id, token_id, party, max(source_id) FROM scene_source{, @given}
    WHERE scene_id = ?1 AND token_id = ?2 AND party = ?3 GROUP BY 1, 2, 3
    ON CONFLICT (scene_id, token_id, party) DO UPDATE
      SET latest_source_id = [max]{greatest}(scene_party.latest_source_id,
                                             excluded.latest_source_id))sql";
inline constexpr const char* kLockScenes =
    "{SELECT 1 FROM scene, @given WHERE id = ?1 ORDER BY id FOR NO KEY UPDATE OF scene}";
// In SQLite the third column of the result is true if the scene had no sources before.
inline constexpr const char* kChangeScenes = R"sql(
    UPDATE scene
    SET source_count = source_count + ?2
        {, changed_in = pg_current_xact_id()}
        [, hash = next_hash(hash, content_hash,
                            row_hash(project, scene, machine_class, reward_version,
                                     source_count + ?2, is_known, added_by_token,
                                     added_by_party))]
    {FROM @given} WHERE id = ?1 [RETURNING project, scene, source_count = ?2])sql";
inline constexpr const char* kCountKeysOfName = R"sql(
    SELECT count(*) FROM scene WHERE project = ?1 AND scene = ?2 AND source_count > 0)sql";

inline constexpr const char* kTakeOut = R"sql(
    DELETE FROM quarantined_evidence {USING @given}
    WHERE source_id = ?1
      AND (?2 = '' OR (SELECT project FROM evidence_key WHERE id = key_id) = ?2)
      AND (?3 [OR hash = content_hash]{OR true})
    RETURNING key_id, source_id, sequence, alpha, beta, window_count, bail_out_count,
              (SELECT scene_id FROM evidence_key WHERE id = key_id))sql";
inline constexpr const char* kDropWaiting = R"sql(
    DELETE FROM quarantined_evidence {USING @given}
    WHERE key_id = ?1 AND source_id = ?2 AND sequence <= ?3)sql";
inline constexpr const char* kCountWaiting = "SELECT count(*) FROM quarantined_evidence";

}  // namespace sweepstake::storage
