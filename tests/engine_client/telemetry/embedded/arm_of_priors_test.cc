// Tests the selection of an arm from priors alone, for a game without measurements.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine_client/decider/embedded/priors_file.h"
#include "sweepstake/embedded_decider.h"
#include "sweepstake/machine_class.h"

namespace sweepstake {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kPriorArms = {"SAP", "DBVT", "KDTree"};
const std::vector<uint32_t> kPriorVersions = {1, 1, 2};

// Returns priors of the lane's visits of the arms from `first_arm` on; each arm costs less than the
// previous arm.
std::string Visits(size_t first_arm = 0, const std::string& machine_class = MachineClass()) {
  std::vector<PriorRecord> records;
  for (size_t arm = first_arm; arm < kPriorArms.size(); ++arm) {
    PriorRecord& record = records.emplace_back();
    record.key.project = record.key.scene = "default";
    record.key.machine_class = machine_class;
    record.key.measured_by = "lane";
    record.key.arm = kPriorArms[arm];
    record.key.backend_version = kPriorVersions[arm];
    record.key.reward_version = 3;
    record.source_id = "studio";
    record.source_sequence = 1;
    record.evidence.alpha = 500 + 20 * static_cast<double>(arm);
    record.evidence.beta = 1000 - record.evidence.alpha;
  }
  return FormatPriors(records);
}

TEST(ArmOfPriors, IsTheCheapestForAnySeedSceneAndMachine) {
  EmbeddedOptions options;
  for (const std::string& priors : {Visits(), Visits(0, "of the studio")}) {
    options.priors_data = priors;
    for (const char* scene : {"default", "a new one"}) {
      options.scene = scene;
      for (options.seed = 1; options.seed <= 3; ++options.seed) {
        const auto arm = EmbeddedDecider::ArmOfPriors(options, kPriorArms, kPriorVersions);
        ASSERT_TRUE(arm.ok()) << arm.status().message();
        EXPECT_EQ(*arm, "KDTree");
      }
    }
  }
}

TEST(ArmOfPriors, IgnoresPriorsInQuarantine) {
  std::vector<PriorRecord> records = *ParsePriors(Visits());
  for (PriorRecord& record : records) record.is_quarantined = true;
  EmbeddedOptions options;
  options.priors_data = FormatPriors(records);
  EXPECT_FALSE(EmbeddedDecider::ArmOfPriors(options, kPriorArms, kPriorVersions).ok());
}

TEST(ArmOfPriors, IsAnArmWithPriors) {
  EmbeddedOptions options;
  for (const size_t first_arm : {1, 2}) {
    options.priors_data = Visits(first_arm);
    const auto arm = EmbeddedDecider::ArmOfPriors(options, kPriorArms, kPriorVersions);
    ASSERT_TRUE(arm.ok()) << arm.status().message();
    EXPECT_EQ(*arm, "KDTree");
  }
  options.scene = "a new one, whose neighbour compares nothing";
  EXPECT_EQ(EmbeddedDecider::ArmOfPriors(options, kPriorArms, kPriorVersions).status().code(),
            StatusCode::kNotFound);
}

TEST(ArmOfPriors, IsAnErrorWithoutPriors) {
  EmbeddedOptions options;
  options.priors_data = Visits();
  options.project = "another game";
  const auto unknown = EmbeddedDecider::ArmOfPriors(options, kPriorArms, kPriorVersions);
  EXPECT_EQ(unknown.status().code(), StatusCode::kNotFound);
  EXPECT_THAT(unknown.status().message(), HasSubstr("another game"));
  options.priors_data = "[";
  EXPECT_EQ(EmbeddedDecider::ArmOfPriors(options, kPriorArms, kPriorVersions).status().code(),
            StatusCode::kDataLoss);
}

}  // namespace
}  // namespace sweepstake
