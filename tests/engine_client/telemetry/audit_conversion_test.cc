#include "engine_client/telemetry/conversion/audit_conversion.h"

#include <gtest/gtest.h>

#include <vector>

#include "engine_client/decider/audit/rederive.h"
#include "tests/engine_client/decider/audit/audited_game.h"

namespace sweepstake {
namespace {

using decision::AuditedGame;
using decision::AuditedSetup;
using decision::AuditFile;
using decision::AuditRow;

AuditFile LogOf(std::string_view policy) {
  AuditFile file;
  AuditedGame(AuditedSetup(1, policy), &file).Run(2'000);
  file.rows.push_back(decision::MissingRow("other", 3, 1));
  decision::AdminRows admin(1);
  file.rows.push_back(admin.Next(-5, 1'800'000'000'000, "ann", "kicked session 7"));
  return file;
}

TEST(AuditConversion, KeepsEveryBitOfARow) {
  std::vector<AuditRow> rows;
  for (const AuditRow& row : LogOf("default").rows) rows.push_back(FromProto(ToProto(row)));
  const decision::AuditReport report = decision::Rederive(rows);
  EXPECT_FALSE(report.difference) << report.difference->Text();
  EXPECT_GT(report.decision_count, 100U);
  EXPECT_EQ(rows.back().action, "kicked session 7");
}

// The sizes in AuditLimits assume such small rows. The rows here have 7 arms and all fields of a
// policy with a gate.
TEST(AuditConversion, ARowOfSevenArmsIsSmall) {
  const AuditFile file = LogOf("default");
  size_t bytes = 0;
  for (const AuditRow& row : file.rows) bytes += EncodeAuditRow(row).size();
  EXPECT_LT(bytes, 1'000 * file.rows.size());
  RecordProperty("bytes_per_row", static_cast<int>(bytes / file.rows.size()));
}

}  // namespace
}  // namespace sweepstake
