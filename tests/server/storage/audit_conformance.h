// Tests of audit rows for every prior store. Included together with prior_store_conformance.h.
#pragma once

#include <string>
#include <vector>

#include "engine_client/decider/audit/audit_log.h"
#include "tests/server/storage/prior_store_conformance.h"

namespace sweepstake::storage {

// Returns `count` rows "segment/number", starting with `first`.
inline priors::AuditRows Rows(uint32_t segment, uint64_t first, uint64_t count,
                              const std::string& scene = "harbour") {
  priors::AuditRows rows{.segment = segment,
                         .project = "game",
                         .scene = scene,
                         .unix_start_ms = 1'800'000'000'000 + segment,
                         .rows = {}};
  for (uint64_t i = first; i < first + count; ++i)
    rows.rows.push_back({.number = i, .bytes = std::to_string(segment) + "/" + std::to_string(i)});
  return rows;
}

class AuditConformance : public PriorStoreConformance {
 protected:
  // Makes the session's next commit, with audit rows only.
  absl::Status Append(const std::string& session, const priors::AuditRows& rows,
                      uint64_t unix_time_s = 0) {
    SourceUpdate update = Update(session, ++commit_count_, {});
    update.unix_time_s = unix_time_s;
    update.audit = rows;
    return Commit({update});
  }
  std::vector<priors::AuditSegment> Segments(const priors::AuditFilter& filter = {}) {
    return *store_->ListAudit(filter, 0, 1000);
  }
  // Returns the rows of the session's segment; empty if there is no such segment.
  std::vector<std::string> Stored(const std::string& session, uint32_t segment = 1) {
    for (const auto& each : Segments({session, "", ""})) {
      if (each.segment == segment) return Texts(*store_->LoadAudit(each.id, 1, 1000, 1 << 20));
    }
    return {};
  }
  static std::vector<std::string> Texts(const std::vector<priors::StoredAuditRow>& rows) {
    std::vector<std::string> texts;
    for (const priors::StoredAuditRow& row : rows) texts.push_back(row.bytes);
    return texts;
  }

  static std::vector<std::string> PlacedTexts(const priors::AuditScan& scan) {
    std::vector<std::string> texts;
    for (const priors::PlacedAuditRow& placed : scan.rows) texts.push_back(placed.row.bytes);
    return texts;
  }

  uint64_t commit_count_ = 0;
};

TEST_P(AuditConformance, RowsAreStoredInOrderWithTheirOrigin) {
  ASSERT_TRUE(Append("a", Rows(1, 1, 2)).ok());
  ASSERT_TRUE(Append("a", Rows(1, 3, 1)).ok());
  EXPECT_EQ(Stored("a"), (std::vector<std::string>{"1/1", "1/2", "1/3"}));
  const auto segments = Segments();
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].session_id, "a");
  EXPECT_EQ(segments[0].project, "game");
  EXPECT_EQ(segments[0].scene, "harbour");
  EXPECT_EQ(segments[0].unix_start_ms, 1'800'000'000'001);
  EXPECT_EQ(segments[0].first_row, 1u);
  EXPECT_EQ(segments[0].row_count, 3u);
  EXPECT_EQ(segments[0].lost_row_count, 0u);
}

TEST_P(AuditConformance, ASegmentNamesWhoBeganItsSession) {
  SourceUpdate update = Update("a", 1, {});
  update.audit = Rows(1, 1, 1);
  update.origin = {.build = "", .token_id = 7, .player = "", .network = "203.0.113.0/24"};
  ASSERT_TRUE(Commit({update}).ok());
  update.progress.source_id = "b";
  update.origin.player = "ann";
  ASSERT_TRUE(Commit({update}).ok());
  const auto segments = Segments();
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_EQ(segments[0].token_id, 7);
  EXPECT_EQ(segments[0].party, "203.0.113.0/24");
  EXPECT_EQ(segments[1].party, "ann");
}

TEST_P(AuditConformance, RowsAreStoredOnceWithTheirCommit) {
  SourceUpdate update = Update("a", 1, {Key("Grid")});
  update.audit = Rows(1, 1, 2);
  ASSERT_TRUE(Commit({update}).ok());
  ASSERT_TRUE(Commit({update}).ok());
  EXPECT_EQ(Stored("a").size(), 2u);
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence.window_count, 1u);
}

TEST_P(AuditConformance, AFailedCommitStoresNoRows) {
  SourceUpdate good = Update("a", 1, {});
  good.audit = Rows(1, 1, 2);
  EXPECT_FALSE(Commit({good, Update("", 1, {})}).ok());
  EXPECT_TRUE(Segments().empty());
}

TEST_P(AuditConformance, RowsThatAreAlreadyStoredAreIgnored) {
  ASSERT_TRUE(Append("a", Rows(1, 1, 2)).ok());
  ASSERT_TRUE(Append("a", Rows(1, 1, 3)).ok());
  EXPECT_EQ(Stored("a"), (std::vector<std::string>{"1/1", "1/2", "1/3"}));
  EXPECT_EQ(store_->losses().audit_row_count, 0u);
}

TEST_P(AuditConformance, RowsOfARevokedSourceAreStored) {
  ASSERT_TRUE(Append("a", Rows(1, 1, 2)).ok());
  ASSERT_TRUE(store_->Revoke({.id = "a"}, false).ok());
  ASSERT_TRUE(Append("a", Rows(1, 3, 1)).ok());
  ASSERT_TRUE(Append("a", Rows(1, 3, 1)).ok()) << "sent again";
  EXPECT_EQ(Stored("a"), (std::vector<std::string>{"1/1", "1/2", "1/3"}));
}

TEST_P(AuditConformance, ASegmentContinuesAfterLostRows) {
  ASSERT_TRUE(Append("a", Rows(1, 1, 2)).ok());
  ASSERT_TRUE(Append("a", Rows(1, 6, 1)).ok());
  EXPECT_EQ(Stored("a"), (std::vector<std::string>{"1/1", "1/2", "1/6"}));
  const auto segments = Segments();
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].row_count, 3u);
  EXPECT_EQ(segments[0].lost_row_count, 3u);
  EXPECT_EQ(store_->LoadAudit(segments[0].id, 3, 9, 99)->at(0).number, 6u);
}

TEST_P(AuditConformance, LoadSourceReturnsTheLatestSegmentOfASession) {
  ASSERT_TRUE(Append("a", {}).ok());
  EXPECT_EQ((*store_->LoadSource("a"))->audit_segment, 0u);
  ASSERT_TRUE(Append("a", Rows(1, 1, 1)).ok());
  ASSERT_TRUE(Append("a", Rows(2, 1, 2)).ok());
  EXPECT_EQ((*store_->LoadSource("a"))->audit_segment, 2u);
  EXPECT_EQ(Stored("a", 1).size(), 1u);
  EXPECT_EQ(Stored("a", 2).size(), 2u);
}

TEST_P(AuditConformance, AboveItsSizeLimitTheLogLosesItsOldestRows) {
  static_assert(kConformanceAuditLimits.bytes == 64);
  ASSERT_TRUE(Append("a", Rows(1, 1, 9)).ok());
  ASSERT_TRUE(Append("b", Rows(1, 1, 6)).ok());
  ASSERT_TRUE(Append("a", Rows(2, 1, 6)).ok());
  EXPECT_EQ(Segments().size(), 3u);
  ASSERT_TRUE(Append("b", Rows(1, 7, 1)).ok());
  EXPECT_TRUE(Stored("a", 1).empty());
  EXPECT_EQ(Stored("a", 2).size(), 6u);
  EXPECT_EQ(Stored("b").size(), 7u);
  ASSERT_TRUE(Append("a", Rows(1, 10, 5)).ok());
  EXPECT_EQ(Stored("a", 1).front(), "1/10");
  ASSERT_TRUE(Append("b", Rows(1, 8, 5)).ok());
  EXPECT_EQ(Stored("b").front(), "1/7") << "the oldest rows of all sessions were removed";
  EXPECT_EQ(Stored("b").size(), 6u);
  const auto segments = Segments({"b", "", ""});
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].first_row, 7u);
  EXPECT_EQ(segments[0].lost_row_count, 0u);
  EXPECT_EQ(store_->losses().audit_row_count, 0u);
}

TEST_P(AuditConformance, RowsAboveTheAgeLimitAreRemovedWhileTheirSessionLives) {
  static_assert(kConformanceAuditLimits.age_s == 3200);
  ASSERT_TRUE(Append("a", Rows(1, 1, 1), 10'000).ok());
  ASSERT_TRUE(Append("b", Rows(1, 1, 1), 10'050).ok());
  ASSERT_TRUE(Append("a", Rows(1, 2, 1), 10'150).ok());
  ASSERT_TRUE(Append("a", Rows(1, 3, 1), 13'200).ok());
  EXPECT_EQ(Stored("a"), (std::vector<std::string>{"1/1", "1/2", "1/3"}));
  ASSERT_TRUE(Append("a", Rows(1, 4, 1), 13'300).ok());
  EXPECT_EQ(Stored("a"), (std::vector<std::string>{"1/2", "1/3", "1/4"}));
  EXPECT_TRUE(Stored("b").empty());
  ASSERT_TRUE(Append("a", Rows(1, 5, 1), 9'000).ok()) << "the clock was set back";
  EXPECT_EQ(Stored("a").size(), 4u);
}

TEST_P(AuditConformance, RowsOfAdministratorsAreNotDisplacedByGamesOrAge) {
  const std::string admin(decision::kAdminSession);
  ASSERT_TRUE(Append("a", Rows(1, 1, 1), 10'000).ok());
  ASSERT_TRUE(Append(admin, Rows(1, 1, 3), 10'000).ok());
  for (uint64_t row = 2; row < 60; ++row)
    ASSERT_TRUE(Append("a", Rows(1, row, 1), 10'000 + row * 1'000).ok());
  EXPECT_LT(Stored("a").size(), 10u);
  EXPECT_EQ(Stored(admin), (std::vector<std::string>{"1/1", "1/2", "1/3"}));
  EXPECT_EQ(store_->losses().audit_row_count, 0u);
}

TEST_P(AuditConformance, OnlyTheLatestRowsOfAdministratorsAreKept) {
  static_assert(kConformanceAuditLimits.admin_row_count == 5);
  const std::string admin(decision::kAdminSession);
  ASSERT_TRUE(Append("a", Rows(1, 1, 2)).ok());
  ASSERT_TRUE(Append(admin, Rows(1, 1, 3)).ok());
  ASSERT_TRUE(Append(admin, Rows(2, 1, 4)).ok());
  EXPECT_EQ(Stored(admin, 1), (std::vector<std::string>{"1/3"}));
  EXPECT_EQ(Stored(admin, 2).size(), 4u);
  ASSERT_TRUE(Append(admin, Rows(2, 5, 2)).ok());
  EXPECT_TRUE(Stored(admin, 1).empty());
  EXPECT_EQ(Stored(admin, 2), (std::vector<std::string>{"2/2", "2/3", "2/4", "2/5", "2/6"}));
  EXPECT_EQ(Stored("a").size(), 2u) << "administrators' rows do not displace rows of games";
}

TEST_P(AuditConformance, ARowLargerThanTheWholeLogIsNotStored) {
  priors::AuditRows rows = Rows(1, 1, 1);
  rows.rows[0].bytes.assign(kConformanceAuditLimits.bytes + 1, 'x');
  ASSERT_TRUE(Append("a", rows).ok());
  EXPECT_TRUE(Segments().empty());
  ASSERT_TRUE(Append("a", Rows(1, 2, 1)).ok());
  EXPECT_EQ(Stored("a").size(), 1u);
}

TEST_P(AuditConformance, TooLongOrEmptyRowsAreCountedAsLostAndOthersAreStored) {
  priors::AuditRows rows = Rows(1, 1, 3);
  rows.rows[1].bytes.assign(priors::kMaxAuditRowBytes + 1, 'x');
  SourceUpdate update = Update("a", 1, {Key("Grid")});
  update.audit = rows;
  ASSERT_TRUE(Commit({update}).ok());
  EXPECT_EQ(Stored("a"), (std::vector<std::string>{"1/1", "1/3"}));
  EXPECT_EQ(store_->losses().audit_row_count, 1u);
  rows = Rows(1, 1, 1);
  rows.rows[0].bytes.clear();
  ASSERT_TRUE(Append("b", rows).ok());
  rows = Rows(1, 1, 1, std::string(129, 's'));
  ASSERT_TRUE(Append("c", rows).ok());
  EXPECT_EQ(Segments().size(), 1u);
  EXPECT_EQ(store_->losses().audit_row_count, 3u);
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence.window_count, 1u);
}

TEST_P(AuditConformance, SegmentsAreListedByFilterAndPage) {
  ASSERT_TRUE(Append("a", Rows(1, 1, 1)).ok());
  ASSERT_TRUE(Append("b", Rows(1, 1, 1, "desert")).ok());
  ASSERT_TRUE(Append("a", Rows(2, 1, 1)).ok());
  EXPECT_EQ(Segments({"a", "", ""}).size(), 2u);
  EXPECT_EQ(Segments({"", "game", ""}).size(), 3u);
  EXPECT_EQ(Segments({"", "game", "desert"}).size(), 1u);
  EXPECT_TRUE(Segments({"", "other", ""}).empty());
  const auto first = *store_->ListAudit({}, 0, 2);
  ASSERT_EQ(first.size(), 2u);
  const auto rest = *store_->ListAudit({}, first.back().id, 2);
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_EQ(rest[0].segment, 2u);
}

TEST_P(AuditConformance, SegmentsOfSeveralProjectsAreListed) {
  for (const char* project : {"a", "b", "b c"}) {
    priors::AuditRows rows = Rows(1, 1, 1);
    rows.project = project;
    ASSERT_TRUE(Append(project, rows).ok());
  }
  const auto segments = Segments({"", "", "", {"a", "b", "none"}});
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_EQ(segments[0].project, "a");
  EXPECT_EQ(segments[1].project, "b");
}

TEST_P(AuditConformance, RowsAreReadByPageAndByBytes) {
  ASSERT_TRUE(Append("a", Rows(1, 1, 5)).ok());
  const uint64_t id = Segments()[0].id;
  EXPECT_EQ(Texts(*store_->LoadAudit(id, 2, 2, 100)), (std::vector<std::string>{"1/2", "1/3"}));
  EXPECT_EQ(Texts(*store_->LoadAudit(id, 1, 5, 4)), (std::vector<std::string>{"1/1", "1/2"}));
  EXPECT_TRUE(store_->LoadAudit(id, 6, 5, 100)->empty());
  EXPECT_TRUE(store_->LoadAudit(id + 1, 1, 5, 100)->empty());
}

TEST_P(AuditConformance, RowsOfAllSessionsAreScannedInTheOrderOfArrivalOrBackwards) {
  ASSERT_TRUE(Append("a", Rows(1, 1, 2)).ok());
  ASSERT_TRUE(Append("b", Rows(7, 1, 2, "desert")).ok());
  ASSERT_TRUE(Append("a", Rows(1, 3, 2)).ok());
  const std::vector<std::string> all = {"1/1", "1/2", "7/1", "7/2", "1/3", "1/4"};
  const auto forward = *store_->ScanAudit({}, priors::AuditOrder::kOldestFirst, 0, 10);
  EXPECT_EQ(PlacedTexts(forward), all);
  EXPECT_TRUE(forward.at_end);
  EXPECT_EQ(forward.last_id, forward.rows.back().id);
  EXPECT_EQ(forward.rows[2].segment_id, Segments({"b", "", ""})[0].id);
  EXPECT_EQ(forward.rows[2].row.number, 1u);
  const auto backward = *store_->ScanAudit({}, priors::AuditOrder::kNewestFirst, 0, 10);
  EXPECT_EQ(PlacedTexts(backward), std::vector<std::string>(all.rbegin(), all.rend()));
  EXPECT_TRUE(backward.at_end);
}

TEST_P(AuditConformance, AScanStopsAtItsLimitAndContinuesAfterItsLastRow) {
  ASSERT_TRUE(Append("a", Rows(1, 1, 5)).ok());
  for (const auto order : {priors::AuditOrder::kOldestFirst, priors::AuditOrder::kNewestFirst}) {
    std::vector<std::string> texts;
    priors::AuditScan scan;
    for (int i = 0; i < 3; ++i) {
      EXPECT_FALSE(scan.at_end);
      scan = *store_->ScanAudit({}, order, scan.last_id, 2);
      for (const std::string& text : PlacedTexts(scan)) texts.push_back(text);
    }
    EXPECT_TRUE(scan.at_end);
    EXPECT_EQ(texts.size(), 5u);
    EXPECT_EQ(texts.back(), order == priors::AuditOrder::kOldestFirst ? "1/5" : "1/1");
    const uint64_t last_id = scan.last_id;
    scan = *store_->ScanAudit({}, order, last_id, 2);
    EXPECT_TRUE(scan.rows.empty());
    EXPECT_TRUE(scan.at_end);
    EXPECT_EQ(scan.last_id, last_id);
  }
}

TEST_P(AuditConformance, AScanSelectsRowsByTheirSegment) {
  for (const char* project : {"a", "b", "b c"}) {
    priors::AuditRows rows = Rows(1, 1, 1, std::string("scene of ") + project);
    rows.project = project;
    ASSERT_TRUE(Append(std::string("session of ") + project, rows).ok());
  }
  const auto count = [&](const priors::AuditFilter& filter) {
    return store_->ScanAudit(filter, priors::AuditOrder::kNewestFirst, 0, 10)->rows.size();
  };
  EXPECT_EQ(count({}), 3u);
  EXPECT_EQ(count({"session of a", "", ""}), 1u);
  EXPECT_EQ(count({"", "b", ""}), 1u);
  EXPECT_EQ(count({"", "", "scene of b c"}), 1u);
  EXPECT_EQ(count({"", "", "", {"a", "b c", "none"}}), 2u);
  EXPECT_EQ(count({"", "b", "", {"a"}}), 0u);
  const auto none = *store_->ScanAudit({"", "none", ""}, priors::AuditOrder::kOldestFirst, 0, 10);
  EXPECT_TRUE(none.at_end);
  EXPECT_EQ(none.last_id, store_->ScanAudit({}, priors::AuditOrder::kOldestFirst, 0, 10)->last_id)
      << "rows that do not match are passed";
}

TEST_P(AuditConformance, AnEmptyLogIsScanned) {
  for (const auto order : {priors::AuditOrder::kOldestFirst, priors::AuditOrder::kNewestFirst})
    EXPECT_EQ(*store_->ScanAudit({}, order, 0, 10),
              (priors::AuditScan{.rows = {}, .first_id = 0, .last_id = 0, .at_end = true}));
}

TEST_P(AuditConformance, RowsComeBackByteByByte) {
  priors::AuditRows rows = Rows(1, 1, 1, "scène; DROP TABLE audit_row");
  rows.rows[0].bytes = std::string("\0\xff\xc3\n\"\\\0", 7);
  ASSERT_TRUE(Append("a", rows).ok());
  EXPECT_EQ(Stored("a"), Texts(rows.rows));
  EXPECT_EQ(Segments()[0].scene, rows.scene);
}

}  // namespace sweepstake::storage
