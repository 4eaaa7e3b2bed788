#include "engine_client/telemetry/protocol/resumable_session.h"

#include <gtest/gtest.h>

namespace sweepstake {
namespace {

EvidenceMessage BatchOf(uint32_t frame_count) {
  return {.message = "batch", .frame_count = frame_count};
}

// Returns the sequence numbers of the messages that a connection would send.
std::vector<uint64_t> SendAll(ResendBuffer& buffer) {
  std::vector<uint64_t> sequences;
  while (const auto* entry = buffer.Next()) {
    sequences.push_back(entry->sequence);
    buffer.MarkSent();
  }
  return sequences;
}

using Sequences = std::vector<uint64_t>;

TEST(ResendBuffer, NumbersMessagesFromOne) {
  ResendBuffer buffer(8);
  for (int i = 0; i < 3; ++i) buffer.Append(BatchOf(1));
  EXPECT_EQ(SendAll(buffer), (Sequences{1, 2, 3}));
  EXPECT_EQ(SendAll(buffer), Sequences{});
  EXPECT_EQ(buffer.last_sequence(), 3U);
}

TEST(ResendBuffer, ResendsUnacknowledgedMessages) {
  ResendBuffer buffer(8);
  for (int i = 0; i < 4; ++i) buffer.Append(BatchOf(1));
  SendAll(buffer);
  buffer.Acknowledge(2);
  buffer.Rewind();
  EXPECT_TRUE(buffer.Next()->sent_before);
  EXPECT_EQ(SendAll(buffer), (Sequences{3, 4}));
}

TEST(ResendBuffer, ContinuesAtTheNextMessageAfterAnAcknowledgement) {
  ResendBuffer buffer(8);
  for (int i = 0; i < 4; ++i) buffer.Append(BatchOf(1));
  buffer.MarkSent();
  buffer.MarkSent();
  buffer.Acknowledge(1);
  EXPECT_EQ(buffer.Next()->sequence, 3U);
  buffer.Acknowledge(3);  // an earlier connection sent these messages
  EXPECT_EQ(SendAll(buffer), Sequences{4});
}

TEST(ResendBuffer, IgnoresAcknowledgementsOfUnknownNumbers) {
  ResendBuffer buffer(8);
  buffer.Append(BatchOf(1));
  buffer.Acknowledge(99);
  EXPECT_NE(buffer.Next(), nullptr);
}

TEST(ResendBuffer, IsFullAtItsCapacityAndNotAfterAnAcknowledgement) {
  ResendBuffer buffer(2);
  buffer.Append(BatchOf(1));
  EXPECT_FALSE(buffer.full());
  buffer.Append(BatchOf(1));
  EXPECT_TRUE(buffer.full());
  buffer.Acknowledge(1);
  EXPECT_FALSE(buffer.full());
}

TEST(ResendBuffer, RenumbersForANewSession) {
  ResendBuffer buffer(8);
  for (int i = 0; i < 4; ++i) buffer.Append(BatchOf(1));
  SendAll(buffer);
  buffer.Acknowledge(2);
  buffer.Renumber();
  buffer.Rewind();
  EXPECT_EQ(SendAll(buffer), (Sequences{1, 2}));
  buffer.Append(BatchOf(1));
  EXPECT_EQ(SendAll(buffer), Sequences{3});
}

TEST(ResendBuffer, DiscardsSentMessagesAndCountsTheirFrames) {
  ResendBuffer buffer(8);
  buffer.Append(BatchOf(5));
  buffer.Append(BatchOf(6));
  buffer.Append(BatchOf(7));
  buffer.MarkSent();
  buffer.MarkSent();
  EXPECT_EQ(buffer.DiscardSent(), 11U);
  EXPECT_EQ(SendAll(buffer), Sequences{3});
}

}  // namespace
}  // namespace sweepstake
