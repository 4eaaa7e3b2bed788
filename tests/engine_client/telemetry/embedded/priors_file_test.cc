#include "engine_client/decider/embedded/priors_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "engine_client/decider/pooling/priors_sums.h"

namespace sweepstake {
namespace {

using ::testing::HasSubstr;

PriorRecord RecordOf(const std::string& source) {
  PriorRecord record;
  record.key.project = "game";
  record.key.scene = "hurricane";
  record.key.arm = "KDTree";
  record.key.backend_version = 2;
  record.key.machine_class = "desktop";
  record.key.reward_version = 1;
  record.source_id = source;
  record.source_sequence = 9;
  record.evidence.alpha = 12.5;
  record.evidence.beta = 0.1;
  record.evidence.window_count = 40;
  record.evidence.bail_out_count = 1;
  record.build = "1.2";
  record.last_seen_unix_s = 1'700'000'000;
  return record;
}

// Returns the document with one record in which `field` is set to `value`.
std::string DocumentWith(const std::string& field, const std::string& value) {
  const std::string document = FormatPriors(std::vector{RecordOf("s")});
  const size_t start = document.find("\"" + field + "\"");
  if (start == std::string::npos) {
    std::string longer = document;
    return longer.insert(longer.find("\"alpha"), "\"" + field + "\": " + value + ", ");
  }
  const size_t end = document.find_first_of(",}", start);
  return document.substr(0, start) + "\"" + field + "\": " + value + document.substr(end);
}

std::string ComplaintAbout(const std::string& text) {
  const auto result = ParsePriors(text);
  if (result.ok()) return "none";
  EXPECT_EQ(result.status().code(), StatusCode::kDataLoss);
  EXPECT_EQ(result.status().message().find('\n'), std::string::npos);
  return result.status().message();
}

TEST(PriorsFile, IsNotWrittenWithMoreRecordsThanCanBeRead) {
  std::vector<PriorRecord> records(200'000, RecordOf("s"));
  EXPECT_TRUE(CheckRecordCount(records).ok());
  records.push_back(RecordOf("s"));
  const Status status = CheckRecordCount(records);
  EXPECT_EQ(status.code(), StatusCode::kResourceExhausted);
  EXPECT_THAT(status.message(), HasSubstr("200001 records are more than"));
  EXPECT_THAT(status.message(), HasSubstr("--sums"));
}

TEST(PriorsFile, IsReadAsItWasWritten) {
  const std::vector<PriorRecord> records = {RecordOf("first"), RecordOf("second")};
  const auto read = ParsePriors(FormatPriors(records));
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read->size(), 2U);
  const PriorRecord& record = (*read)[1];
  EXPECT_EQ(record.key.project, "game");
  EXPECT_EQ(record.key.scene, "hurricane");
  EXPECT_EQ(record.key.measured_by, "");
  EXPECT_EQ(record.key.arm, "KDTree");
  EXPECT_EQ(record.key.backend_version, 2U);
  EXPECT_EQ(record.key.machine_class, "desktop");
  EXPECT_EQ(record.key.reward_version, 1U);
  EXPECT_EQ(record.source_id, "second");
  EXPECT_EQ(record.source_sequence, 9U);
  EXPECT_EQ(record.evidence.alpha, 12.5);
  EXPECT_EQ(record.evidence.beta, 0.1);
  EXPECT_EQ(record.evidence.window_count, 40U);
  EXPECT_EQ(record.evidence.bail_out_count, 1U);
  EXPECT_EQ(record.build, "1.2");
  EXPECT_EQ(record.last_seen_unix_s, 1'700'000'000U);
}

TEST(PriorsFile, KeepsTheRegimeOfRecordsAndSums) {
  std::vector<PriorRecord> records(2, RecordOf("s"));
  records[1].key.regime = "13/-4/0";
  const auto read = ParsePriors(FormatPriors(records));
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].key.regime, "");
  EXPECT_EQ((*read)[1].key.regime, "13/-4/0");
  const std::vector<PriorRecord> sums = SumByBuild(records);
  ASSERT_EQ(sums.size(), 2U);
  const auto read_sums = ParsePriors(FormatPriors(sums));
  ASSERT_TRUE(read_sums.ok()) << read_sums.status().message();
  EXPECT_EQ(*read_sums, sums);
  EXPECT_THAT(ComplaintAbout(DocumentWith("regime", "\"fast\"")), HasSubstr("13/-4/0"));
}

TEST(PriorsFile, KeepsQuarantinedRecordsBesideOthers) {
  std::vector<PriorRecord> records(2, RecordOf("s"));
  records[1].is_quarantined = true;
  records[1].source_sequence = 10;
  const std::string text = FormatPriors(records);
  const auto read = ParsePriors(text);
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read->size(), 2U);
  EXPECT_FALSE((*read)[0].is_quarantined);
  EXPECT_TRUE((*read)[1].is_quarantined);
  EXPECT_EQ(FormatPriors(*read), text);
  EXPECT_THAT(ComplaintAbout(DocumentWith("is_quarantined", "1")), HasSubstr("true or false"));
}

TEST(PriorsFile, MayHaveNoRecordsAndNoOptionalFields) {
  EXPECT_TRUE(ParsePriors(FormatPriors({})).ok());
  const auto read = ParsePriors(
      R"({"format":"sweepstake-priors","version":1,"records":[{"project":"p","scene":"s",
          "arm":"SAP","backend_version":1,"reward_version":1,"source_id":"x","source_sequence":1,
          "alpha_increment":1,"beta_increment":0}]})");
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ((*read)[0].key.machine_class, "");
  EXPECT_EQ((*read)[0].evidence.window_count, 0U);
  EXPECT_EQ((*read)[0].build, "");
}

TEST(PriorsFile, ErrorsNameTheInvalidRecordAndField) {
  EXPECT_EQ(ComplaintAbout(DocumentWith("project", "\"\"")), "priors record 0: project is empty");
  EXPECT_THAT(ComplaintAbout(DocumentWith("arm", "7")), HasSubstr("record 0: arm is not a string"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("scene", "\"a\\u0000b\"")), HasSubstr("scene"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("backend_version", "0")), HasSubstr("is 0"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("backend_version", "4294967296")),
              HasSubstr("too large"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("source_sequence", "-1")), HasSubstr("whole number"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("source_sequence", "1.5")), HasSubstr("whole number"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("source_sequence", "9223372036854775808")),
              HasSubstr("source_sequence is too large"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("window_count", "9223372036854775808")),
              HasSubstr("window_count is too large"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("bail_out_count", "9223372036854775808")),
              HasSubstr("bail_out_count is too large"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("alpha_increment", "-0.5")), HasSubstr("0 to 1e15"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("alpha_increment", "1e16")), HasSubstr("0 to 1e15"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("beta_increment", "\"nan\"")), HasSubstr("number"));
  EXPECT_THAT(ComplaintAbout(DocumentWith("machine_clas", "\"x\"")),
              HasSubstr("machine_clas is an unknown field"));
}

TEST(PriorsFile, OtherDocumentsAreRefused) {
  for (const char* text :
       {"", "{", "[]", "null", "{\"format\":\"other\"}", "{\"format\":\"sweepstake-priors\"}",
        "{\"format\":\"sweepstake-priors\",\"version\":2,\"records\":[]}",
        "{\"format\":\"sweepstake-priors\",\"version\":1}",
        "{\"format\":\"sweepstake-priors\",\"version\":1,\"records\":[3]}",
        "{\"format\":\"sweepstake-priors\",\"version\":1,\"records\":[{}]}"}) {
    EXPECT_NE(ComplaintAbout(text), "none") << text;
  }
  EXPECT_NE(ComplaintAbout(DocumentWith("alpha_increment", "1e999")), "none");
  EXPECT_NE(ComplaintAbout(std::string(1 << 20, '[')), "none");
}

TEST(PriorsFile, DoesNotDependOnTheOrderOfItsFields) {
  const std::string record = DocumentWith("build", "\"1\"");
  const std::string records = record.substr(record.find("\"records\""));
  const std::string turned =
      "{" + records.substr(0, records.rfind('}')) + R"(,"version":1,"format":"sweepstake-priors"})";
  EXPECT_EQ(ComplaintAbout(turned), "none");
  EXPECT_EQ(ParsePriors(turned)->size(), 1U);
  EXPECT_THAT(ComplaintAbout(R"({"records":[{}],"version":1,"format":"other"})"),
              HasSubstr("do not have the format"));
}

TEST(PriorsFile, HasItsRecordsOnlyInTheArrayRecords) {
  const std::string record = DocumentWith("build", "\"1\"");
  std::string nested = record;
  nested.replace(nested.find("\"records\":["), 11, "\"other\":[");
  EXPECT_THAT(ComplaintAbout(nested), HasSubstr("neither \"records\" nor \"scenes\""));
  std::string object = record;
  object.replace(object.find("\"records\":["), 11, "\"records\":{\"a\":");
  object.replace(object.rfind(']'), 1, "}");
  EXPECT_THAT(ComplaintAbout(object), HasSubstr("\"records\" must be an array"));
}

TEST(PriorsFile, RepeatedEvidenceIsRefused) {
  EXPECT_THAT(ComplaintAbout(FormatPriors(std::vector{RecordOf("a"), RecordOf("a")})),
              HasSubstr("priors record 1: repeats"));
  EXPECT_THAT(ComplaintAbout(FormatPriors(std::vector{RecordOf("b"), RecordOf("a"), RecordOf("c"),
                                                      RecordOf("b"), RecordOf("a")})),
              HasSubstr("priors record 3: repeats"));
}

TEST(PriorsFile, RefusesASumAmongTheRecords) {
  EXPECT_THAT(ComplaintAbout(DocumentWith("source_id", "\"*0\"")),
              HasSubstr("record 0: source_id must not begin with *"));
}

TEST(PriorsFile, IsRefusedIfTruncatedAnywhere) {
  const std::string text = FormatPriors(std::vector{RecordOf("a")});
  for (size_t length = 0; length + 2 < text.size(); ++length) {
    EXPECT_FALSE(ParsePriors(text.substr(0, length)).ok()) << length;
  }
}

TEST(PriorsFile, IsReadFromItsPath) {
  const auto path = std::filesystem::path(::testing::TempDir()) / "priors_file_test.json";
  std::ofstream(path) << FormatPriors(std::vector{RecordOf("a")});
  const auto read = ReadPriorsFile(path);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->size(), 1U);
  std::filesystem::remove(path);
}

TEST(PriorsFile, ErrorsNameTheMissingOrInvalidFile) {
  const auto missing = ReadPriorsFile("no/such/priors.json");
  EXPECT_EQ(missing.status().code(), StatusCode::kNotFound);
  EXPECT_THAT(missing.status().message(), HasSubstr("no/such/priors.json"));
  EXPECT_EQ(ReadPriorsFile(::testing::TempDir()).status().code(), StatusCode::kNotFound);
  const auto path = std::filesystem::path(::testing::TempDir()) / "broken_priors.json";
  std::ofstream(path) << "{";
  const auto broken = ReadPriorsFile(path);
  EXPECT_EQ(broken.status().code(), StatusCode::kDataLoss);
  EXPECT_THAT(broken.status().message(), HasSubstr("broken_priors.json"));
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace sweepstake
