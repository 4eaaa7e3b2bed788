// Tests a struct that has grown twice, with callers compiled with each of its revisions.
#include "engine_client/c_api/sized_struct.h"

#include <gtest/gtest.h>

#include <cstring>

namespace sweepstake::c_api {
namespace {

struct Grown {
  uint32_t struct_size;
  uint32_t first;
  uint64_t second;  // added in the second revision
  uint64_t third;   // added in the third revision
};
constexpr Grown kDefaults = {sizeof(Grown), 1, 2, 3};

}  // namespace

template <>
inline constexpr std::array<uint32_t, 2> kEarlierSizes<Grown>{8, 16};

namespace {

TEST(SizedStructTest, ACallerOfAnEarlierRevisionGetsDefaultsForNewFields) {
  const Grown given = {8, 71, 72, 73};
  Grown options = kDefaults;
  ASSERT_EQ(TakeOptions("grown", &given, options), SWP_OK);
  EXPECT_EQ(options.struct_size, sizeof(Grown));
  EXPECT_EQ(options.first, 71U);
  EXPECT_EQ(options.second, 2U);
  EXPECT_EQ(options.third, 3U);
}

TEST(SizedStructTest, ACallerOfTheSecondRevisionSetsTwoFields) {
  const Grown given = {16, 71, 72, 73};
  Grown options = kDefaults;
  ASSERT_EQ(TakeOptions("grown", &given, options), SWP_OK);
  EXPECT_EQ(options.second, 72U);
  EXPECT_EQ(options.third, 3U);
}

TEST(SizedStructTest, NullLeavesTheDefaults) {
  Grown options = kDefaults;
  ASSERT_EQ(TakeOptions<Grown>("grown", nullptr, options), SWP_OK);
  EXPECT_EQ(std::memcmp(&options, &kDefaults, sizeof options), 0);
}

TEST(SizedStructTest, ASizeBetweenTwoRevisionsIsRefusedAndChangesNothing) {
  for (const uint32_t size : {7U, 12U, 17U, 23U}) {
    Grown given = {size, 71, 72, 73};
    const Grown before = given;
    Grown options = kDefaults;
    EXPECT_EQ(TakeOptions("grown", &given, options), SWP_INVALID_ARGUMENT);
    EXPECT_EQ(std::memcmp(&options, &kDefaults, sizeof options), 0);
    EXPECT_EQ(Give("grown", kDefaults, &given), SWP_INVALID_ARGUMENT);
    EXPECT_EQ(std::memcmp(&given, &before, sizeof given), 0);
  }
}

TEST(SizedStructTest, NothingIsWrittenBeyondTheStructOfAnEarlierRevision) {
  Grown out = {16, 71, 72, 73};
  ASSERT_EQ(Give("grown", kDefaults, &out), SWP_OK);
  EXPECT_EQ(out.struct_size, 16U);
  EXPECT_EQ(out.first, 1U);
  EXPECT_EQ(out.second, 2U);
  EXPECT_EQ(out.third, 73U);
}

}  // namespace
}  // namespace sweepstake::c_api
