// Tests the text of a statement for each database.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/storage/sql/sql_database.h"

namespace sweepstake::storage {
namespace {

TEST(SqlTextTest, SqliteReadsWhatIsInBracketsAndRunsAStatementForEachRow) {
  EXPECT_EQ(SqliteText("SELECT [hash]{true} FROM t{, @given} WHERE a = ?1"),
            "SELECT hash FROM t WHERE a = ?1");
}

TEST(SqlTextTest, PostgresReadsWhatIsInBracesAndKnowsTheTypeOfEachParameter) {
  const char* types[] = {"text", "bigint"};
  EXPECT_EQ(PostgresText("SELECT [hash]{true} FROM t WHERE instr(?1, char(10)) > ?2", types),
            "SELECT true FROM t WHERE strpos($1::text, chr(10)) > $2::bigint");
}

TEST(SqlTextTest, PostgresReadsTheRowsOfABatchAsATable) {
  const std::vector<const char*> types(10, "bigint");
  const std::string text = PostgresText("SELECT ?10, ?1 {FROM @given}", types);
  EXPECT_EQ(text.substr(0, text.find(" FROM")), "SELECT g.p10, g.p1");
  const char* one[] = {"text"};
  EXPECT_EQ(PostgresText("DELETE FROM t {USING @given} WHERE a = ?1", one),
            "DELETE FROM t USING unnest($1::text[]) AS g(p1) WHERE a = g.p1");
}

}  // namespace
}  // namespace sweepstake::storage
