// Runs a test on each instruction set that this machine has kernels for.
#pragma once

#include <gtest/gtest.h>

#include <string_view>

#include "sweepstake/simd.h"

namespace sweepstake::test_support {

// Ends with the one that ran before, also after the first fatal failure.
template <class Test>
void OnEachSimdTarget(const Test& test) {
  const std::string_view before = SimdTarget();
  for (const std::string_view target : SimdTargets()) {
    SCOPED_TRACE(target);
    EXPECT_TRUE(UseSimdTarget(target).ok());
    EXPECT_EQ(SimdTarget(), target);
    test();
    if (testing::Test::HasFatalFailure()) break;
  }
  EXPECT_TRUE(UseSimdTarget(before).ok());
}

}  // namespace sweepstake::test_support
