// What every prior store must do with audit rows. prior_store_test.cc alone includes it.
#pragma once

#include <string>
#include <vector>

#include "tests/server/storage/prior_store_conformance.h"

namespace sweepstake::storage {

// Rows "segment/number", from `first` on.
inline priors::AuditRows Rows(uint32_t segment, uint64_t first, uint64_t count,
                              const std::string& scene = "harbour") {
  priors::AuditRows rows{.segment = segment,
                         .project = "game",
                         .scene = scene,
                         .unix_start_ms = 1'800'000'000'000 + segment,
                         .first_row = first,
                         .rows = {}};
  for (uint64_t i = 0; i < count; ++i)
    rows.rows.push_back(std::to_string(segment) + "/" + std::to_string(first + i));
  return rows;
}

class AuditConformance : public PriorStoreConformance {
 protected:
  // The session's next commit, with rows of its audit log and nothing else.
  absl::Status Append(const std::string& session, const priors::AuditRows& rows) {
    SourceUpdate update = Update(session, ++commit_count_, {});
    update.audit = rows;
    return Commit({update});
  }
  std::vector<priors::AuditSegment> Segments(const priors::AuditFilter& filter = {}) {
    return *store_->ListAudit(filter, 0, 1000);
  }
  // Rows of the session's segment; empty: there is no such segment.
  std::vector<std::string> Stored(const std::string& session, uint32_t segment = 1) {
    for (const auto& each : Segments({session, "", ""})) {
      if (each.segment == segment) return *store_->LoadAudit(each.id, 1, 1000, 1 << 20);
    }
    return {};
  }

  uint64_t commit_count_ = 0;
};

TEST_P(AuditConformance, RowsAreThereInTheirOrderWithWhereTheyComeFrom) {
  ASSERT_TRUE(Append("a", Rows(1, 1, 2)).ok());
  ASSERT_TRUE(Append("a", Rows(1, 3, 1)).ok());
  EXPECT_EQ(Stored("a"), (std::vector<std::string>{"1/1", "1/2", "1/3"}));
  const auto segments = Segments();
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].session_id, "a");
  EXPECT_EQ(segments[0].project, "game");
  EXPECT_EQ(segments[0].scene, "harbour");
  EXPECT_EQ(segments[0].unix_start_ms, 1'800'000'000'001);
  EXPECT_EQ(segments[0].row_count, 3u);
}

TEST_P(AuditConformance, RowsGoWithTheirCommitOnce) {
  SourceUpdate update = Update("a", 1, {Key("Grid")});
  update.audit = Rows(1, 1, 2);
  ASSERT_TRUE(Commit({update}).ok());
  ASSERT_TRUE(Commit({update}).ok());
  EXPECT_EQ(Stored("a").size(), 2u);
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence.window_count, 1u);
}

TEST_P(AuditConformance, ACommitThatFailsKeepsNoRows) {
  SourceUpdate good = Update("a", 1, {});
  good.audit = Rows(1, 1, 2);
  EXPECT_FALSE(Commit({good, Update("", 1, {})}).ok());
  EXPECT_TRUE(Segments().empty());
}

TEST_P(AuditConformance, RowsThatDoNotGoOnFromWhatIsStoredAreLeftOut) {
  ASSERT_TRUE(Append("a", Rows(1, 2, 1)).ok());
  EXPECT_TRUE(Segments().empty());
  ASSERT_TRUE(Append("a", Rows(1, 1, 2)).ok());
  ASSERT_TRUE(Append("a", Rows(1, 4, 1)).ok());
  ASSERT_TRUE(Append("a", Rows(1, 2, 1)).ok());
  ASSERT_TRUE(Append("a", Rows(1, 1, 1)).ok());
  EXPECT_EQ(Stored("a"), (std::vector<std::string>{"1/1", "1/2"}));
}

TEST_P(AuditConformance, ASegmentAfterTheOtherIsKnownToWhoResumes) {
  ASSERT_TRUE(Append("a", {}).ok());
  EXPECT_EQ((*store_->LoadSource("a"))->audit_segment, 0u);
  ASSERT_TRUE(Append("a", Rows(1, 1, 1)).ok());
  ASSERT_TRUE(Append("a", Rows(2, 1, 2)).ok());
  EXPECT_EQ((*store_->LoadSource("a"))->audit_segment, 2u);
  EXPECT_EQ(Stored("a", 1).size(), 1u);
  EXPECT_EQ(Stored("a", 2).size(), 2u);
}

TEST_P(AuditConformance, ASessionsLogEndsAtItsBoundAndKeepsItsBeginning) {
  const uint64_t most = kConformanceAuditLimits.rows_per_session;
  ASSERT_TRUE(Append("a", Rows(1, 1, most - 1)).ok());
  ASSERT_TRUE(Append("a", Rows(1, most, 2)).ok());
  ASSERT_TRUE(Append("a", Rows(1, most + 2, 1)).ok());
  ASSERT_TRUE(Append("a", Rows(2, 1, 1)).ok());
  EXPECT_EQ(Stored("a").size(), most);
  EXPECT_EQ(Segments().size(), 1u);
}

TEST_P(AuditConformance, BeyondTheBoundInAllTheOldestSegmentsGoAndDoNotComeBack) {
  static_assert(kConformanceAuditLimits.rows == 10 &&
                kConformanceAuditLimits.rows_per_session == 6);
  ASSERT_TRUE(Append("a", Rows(1, 1, 5)).ok());
  ASSERT_TRUE(Append("b", Rows(1, 1, 5)).ok());
  EXPECT_EQ(Segments().size(), 2u);
  ASSERT_TRUE(Append("c", Rows(1, 1, 1)).ok());
  EXPECT_TRUE(Stored("a").empty());
  EXPECT_EQ(Stored("b").size(), 5u);
  EXPECT_EQ(Stored("c").size(), 1u);
  ASSERT_TRUE(Append("a", Rows(1, 6, 1)).ok());
  EXPECT_TRUE(Stored("a").empty());
}

TEST_P(AuditConformance, RowsThatAreTooLongOrEmptyEndTheLogAndNotTheCommit) {
  priors::AuditRows rows = Rows(1, 1, 3);
  rows.rows[1].assign(priors::kMaxAuditRowBytes + 1, 'x');
  SourceUpdate update = Update("a", 1, {Key("Grid")});
  update.audit = rows;
  ASSERT_TRUE(Commit({update}).ok());
  EXPECT_EQ(Stored("a"), (std::vector<std::string>{"1/1"}));
  rows = Rows(1, 1, 1);
  rows.rows[0].clear();
  ASSERT_TRUE(Append("b", rows).ok());
  rows = Rows(1, 1, 1, std::string(129, 's'));
  ASSERT_TRUE(Append("c", rows).ok());
  EXPECT_EQ(Segments().size(), 1u);
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

TEST_P(AuditConformance, RowsAreReadByPageAndByBytes) {
  ASSERT_TRUE(Append("a", Rows(1, 1, 5)).ok());
  const uint64_t id = Segments()[0].id;
  EXPECT_EQ(*store_->LoadAudit(id, 2, 2, 100), (std::vector<std::string>{"1/2", "1/3"}));
  EXPECT_EQ(*store_->LoadAudit(id, 1, 5, 4), (std::vector<std::string>{"1/1", "1/2"}));
  EXPECT_TRUE(store_->LoadAudit(id, 6, 5, 100)->empty());
  EXPECT_TRUE(store_->LoadAudit(id + 1, 1, 5, 100)->empty());
}

TEST_P(AuditConformance, TextComesBackByteByByte) {
  priors::AuditRows rows = Rows(1, 1, 1, "scène; DROP TABLE audit_row");
  rows.rows[0] = "a,\"b\n\r\",ä€😀\\";
  ASSERT_TRUE(Append("a", rows).ok());
  EXPECT_EQ(Stored("a"), rows.rows);
  EXPECT_EQ(Segments()[0].scene, rows.scene);
}

}  // namespace sweepstake::storage
