#include "engine_client/decider/pooling/priors_sums.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "engine_client/decider/embedded/priors_file.h"
#include "engine_client/math/hash.h"

namespace sweepstake {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

PriorRecord RecordOf(const std::string& source, const std::string& build, const std::string& arm,
                     const std::string& measured_by = "") {
  return {.key = {.project = "game",
                  .scene = "harbour",
                  .measured_by = measured_by,
                  .arm = arm,
                  .backend_version = 2,
                  .machine_class = "desktop",
                  .reward_version = 3},
          .source_id = source,
          .source_sequence = 9,
          .evidence = {12.5, 0.25, 40, measured_by.empty() ? 1u : 0u},
          .build = build,
          .last_seen_unix_s = 1'700'000'000};
}

std::vector<PriorRecord> SomeSums() {
  return SumByBuild(
      std::vector{RecordOf("a-session", "1.2", "SAP"), RecordOf("another", "1.2", "SAP"),
                  RecordOf("another", "1.2", "SAP", "lane"),
                  RecordOf("another", "1.2", "Grid", "lane"), RecordOf("a-third", "1.3", "SAP")});
}

// Returns the document with changed scenes and a correct checksum.
template <typename Change>
std::string SumsWith(Change change) {
  json document = json::parse(FormatPriors(SomeSums()));
  change(document["scenes"]);
  document["checksum"] = math::HexOf(math::Fnv1a(math::kFnv1aStart, document["scenes"].dump()));
  return document.dump();
}

std::string ComplaintAboutSums(const std::string& text) {
  const auto result = ParsePriors(text);
  if (result.ok()) return "none";
  EXPECT_EQ(result.status().code(), StatusCode::kDataLoss);
  return result.status().message();
}

TEST(PriorsSums, SumTheEvidenceOfEachBuildWithoutSessionIds) {
  const std::vector<PriorRecord> sums = SomeSums();
  ASSERT_EQ(sums.size(), 4U);
  for (const PriorRecord& sum : sums) EXPECT_TRUE(IsSum(sum)) << sum.source_id;
  EXPECT_FALSE(IsSum(RecordOf("a-session", "", "SAP")));
  const PriorRecord& sap = sums[0].build == "1.2" ? sums[0] : sums[1];
  EXPECT_EQ(sap.evidence.alpha, 25);
  EXPECT_EQ(sap.evidence.beta, 0.5);
  EXPECT_EQ(sap.evidence.window_count, 80U);
  EXPECT_EQ(sap.evidence.bail_out_count, 2U);
  const std::string text = FormatPriors(sums);
  EXPECT_THAT(text, Not(HasSubstr("a-session")));
  EXPECT_THAT(text, Not(HasSubstr("another")));
}

TEST(PriorsSums, ExcludeRecordsInQuarantine) {
  PriorRecord record = RecordOf("one", "1.0", "SAP");
  const std::vector<PriorRecord> sums = SumByBuild(std::vector{record});
  PriorRecord waiting = record;
  waiting.is_quarantined = true;
  EXPECT_EQ(FormatPriors(SumByBuild(std::vector{record, waiting})), FormatPriors(sums));
  EXPECT_TRUE(SumByBuild(std::vector{waiting}).empty());
}

TEST(PriorsSums, StandBesideTheRecordsOfSourcesInOneFile) {
  std::vector<PriorRecord> both = SomeSums();
  both.push_back(RecordOf("a-session", "1.2", "SAP"));
  const std::string text = FormatPriors(both);
  const auto read = ParsePriors(text);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->size(), both.size());
  EXPECT_EQ(read->front(), both.back());
  EXPECT_EQ(FormatPriors(*read), text);
}

TEST(PriorsSums, AreReadBackAsTheyWereWritten) {
  const std::vector<PriorRecord> sums = SomeSums();
  const std::string text = FormatPriors(sums);
  const auto read = ParsePriors(text);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->size(), sums.size());
  EXPECT_EQ(FormatPriors(*read), text);
  for (const PriorRecord& sum : *read) {
    EXPECT_EQ(sum.key.project, "game");
    EXPECT_EQ(sum.key.scene, "harbour");
    EXPECT_EQ(sum.key.machine_class, "desktop");
    EXPECT_EQ(sum.key.backend_version, 2U);
    EXPECT_EQ(sum.key.reward_version, 3U);
    EXPECT_EQ(sum.last_seen_unix_s, 1'700'000'000U);
    EXPECT_EQ(sum.source_sequence, sum.evidence.window_count);
  }
  EXPECT_TRUE(ParsePriors(json::parse(text).dump(4)).ok()) << "white space does not matter";
  EXPECT_EQ(FormatPriors(SumByBuild(*read)), text) << "a sum of sums is the same sum";
}

TEST(PriorsSums, HaveFiveDigitsInAFile) {
  PriorRecord record = RecordOf("a", "", "SAP");
  record.evidence.alpha = 123'456.789;
  record.evidence.beta = 0.000'123'456;
  const auto sums = ParsePriors(FormatPriors(SumByBuild(std::vector{record})));
  ASSERT_TRUE(sums.ok()) << sums.status().message();
  EXPECT_EQ((*sums)[0].evidence.alpha, 123'460);
  EXPECT_EQ((*sums)[0].evidence.beta, 0.000'123'46);
}

TEST(PriorsSums, AreRefusedIfChangedOrTruncated) {
  const std::string text = FormatPriors(SomeSums());
  std::string changed = text;
  changed.replace(changed.find("0.5"), 3, "0.6");
  EXPECT_THAT(ComplaintAboutSums(changed), HasSubstr("checksum"));
  for (size_t length = 0; length + 2 < text.size(); ++length)
    EXPECT_FALSE(ParsePriors(text.substr(0, length)).ok()) << length;
}

TEST(PriorsSums, ErrorsNameTheInvalidScene) {
  const auto same = [](json&) {};
  EXPECT_EQ(ComplaintAboutSums(SumsWith(same)), "none");
  const auto complaint_where = [](const char* pointer, const json& value) {
    return ComplaintAboutSums(
        SumsWith([&](json& scenes) { scenes[json::json_pointer(pointer)] = value; }));
  };
  EXPECT_EQ(complaint_where("/0/project", ""), "priors scene 0: project is empty");
  EXPECT_THAT(complaint_where("/0/scen", "x"), HasSubstr("scen is an unknown field"));
  EXPECT_THAT(complaint_where("/0/arms", 3), HasSubstr("arms is not an array"));
  EXPECT_THAT(complaint_where("/0/arms/0", "Grid"), HasSubstr("NAME/VERSION"));
  EXPECT_THAT(complaint_where("/0/arms/0", "Grid/0"), HasSubstr("NAME/VERSION"));
  EXPECT_THAT(complaint_where("/0/arms/0", "Grid/2x"), HasSubstr("NAME/VERSION"));
  EXPECT_THAT(complaint_where("/0/arms/0", "/2"), HasSubstr("NAME/VERSION"));
  EXPECT_THAT(complaint_where("/0/builds", json::array()), HasSubstr("builds is not an object"));
  EXPECT_THAT(complaint_where("/0/builds/1.2", json::array()), HasSubstr("a build must be"));
  EXPECT_THAT(complaint_where("/0/builds/1.2/0", -1), HasSubstr("a build must be"));
  EXPECT_THAT(complaint_where("/0/builds/1.2/1", json::array()), HasSubstr("a build must be"));
  EXPECT_THAT(complaint_where("/0/builds/1.2/1/1", "x"), HasSubstr("evidence must be"));
  EXPECT_THAT(complaint_where("/0/builds/1.2/1/1", {1, 2}), HasSubstr("evidence must be"));
  EXPECT_THAT(complaint_where("/0/builds/1.2/1/1", {-1, 2, 3}), HasSubstr("from 0 to 1e15"));
  EXPECT_THAT(complaint_where("/0/builds/1.2/1/1", {1, 2, uint64_t{1} << 63}),
              HasSubstr("a count is too large"));
  EXPECT_THAT(ComplaintAboutSums(SumsWith([](json& scenes) { scenes.push_back(json(scenes[0])); })),
              HasSubstr("priors scene 1: repeats"));
  EXPECT_THAT(ComplaintAboutSums(SumsWith(
                  [](json& scenes) { scenes[0]["arms"].push_back(json(scenes[0]["arms"][0])); })),
              HasSubstr("priors scene 0: repeats an arm"));
}

TEST(PriorsSums, OfAThousandScenesAndTwentyBuildsHaveAtMostFiveMegabytes) {
  std::vector<PriorRecord> records;
  uint64_t state = 1;
  for (int scene = 0; scene < 1'000; ++scene) {
    for (int build = 0; build < 20; ++build) {
      for (int arm = 0; arm < 10;
           ++arm) {  // records 0-6: lane visits, 7-9: live windows of three arms
        const std::string name = "Algorithm" + std::to_string(arm % 7);
        PriorRecord& record = records.emplace_back(
            RecordOf("s", "1." + std::to_string(build), name, arm < 7 ? "lane" : ""));
        record.key.scene = "level " + std::to_string(scene);
        state = math::Mix64(state);
        record.evidence.alpha = static_cast<double>(state % 10'000'000) / 777;
        record.evidence.beta = static_cast<double>(state / 3 % 10'000'000) / 777;
        record.evidence.bail_out_count = 0;
      }
    }
  }
  const std::string text = FormatPriors(SumByBuild(records));
  EXPECT_LE(text.size(), 5'000'000U);
  const auto read = ParsePriors(text);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->size(), records.size());
}

}  // namespace
}  // namespace sweepstake
