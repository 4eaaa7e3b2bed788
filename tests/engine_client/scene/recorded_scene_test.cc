#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "engine_client/scene/random.h"
#include "tests/engine_client/scene/file_fixtures.h"
#include "tests/engine_client/scene/scene_fixtures.h"

namespace sweepstake {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr int32_t kLargest = std::numeric_limits<int32_t>::max();
constexpr int32_t kTwoToThe31 = std::numeric_limits<int32_t>::min();

class RecordedFile : public FileTest {
 protected:
  std::unique_ptr<Scene> Open(const std::string& bytes) const {
    return MustMakeScene(Write(bytes).string(), {});
  }

  // Expects kDataLoss with a message of one line that contains the file name and `what`.
  void ExpectBroken(const std::string& bytes, const std::string& what) const {
    const Status status = MakeScene(Write(bytes).string(), {}).status();
    EXPECT_EQ(status.code(), StatusCode::kDataLoss) << what;
    EXPECT_THAT(status.message(),
                AllOf(HasSubstr("scene.aabbs: "), HasSubstr(what), Not(HasSubstr("\n"))));
  }

  static std::string WithByte(std::string bytes, size_t offset, char value) {
    bytes.at(offset) = value;
    return bytes;
  }
};

TEST_F(RecordedFile, RepeatsTheFramesOfABroadmarkFile) {
  const auto scene = Open(FileBytes().Header(2, 1).Boxes(4).str());
  EXPECT_EQ(scene->name(), "crates");
  EXPECT_EQ(scene->world(), (Aabb{{-1, -1, -1}, {1, 1, 1}}));
  EXPECT_THAT(scene->aabbs(), ElementsAre(BoxAt(0), BoxAt(1)));
  scene->Step();
  EXPECT_THAT(scene->aabbs(), ElementsAre(BoxAt(2), BoxAt(3)));
  scene->Step();
  EXPECT_THAT(scene->aabbs(), ElementsAre(BoxAt(0), BoxAt(1)));
  EXPECT_EQ(scene->frame_index(), 2U);
}

TEST_F(RecordedFile, ReadsChangingCountsFromTheTableAtTheEnd) {
  const FileBytes bytes = FileBytes().Header(2, 2, 1).Boxes(3).Int(1).Int(0).Int(2);
  const auto scene = Open(bytes.str());
  EXPECT_THAT(scene->aabbs(), ElementsAre(BoxAt(0)));
  scene->Step();
  EXPECT_THAT(scene->aabbs(), IsEmpty());
  scene->Step();
  EXPECT_THAT(scene->aabbs(), ElementsAre(BoxAt(1), BoxAt(2)));
  scene->Step();
  EXPECT_THAT(scene->aabbs(), ElementsAre(BoxAt(0)));
}

TEST_F(RecordedFile, OneFrameWithoutStepsIsValid) {
  const auto scene = Open(FileBytes().Header(1, 0).Boxes(1).str());
  scene->Step();
  EXPECT_THAT(scene->aabbs(), ElementsAre(BoxAt(0)));
}

TEST_F(RecordedFile, AnEmptyNameAndInvertedBoxesAreValid) {
  const std::string named = FileBytes().Header(1, 0).Box({{5, 0, 0}, {-5, 1, 1}}).str();
  const auto scene = Open(std::string(128, '\0') + named.substr(128));
  EXPECT_EQ(scene->name(), "recorded");
  EXPECT_EQ(scene->aabbs()[0].min[0], 5);
}

TEST_F(RecordedFile, AMissingFileIsNotFound) {
  const Status status = MakeScene(PathOf("none.aabbs").string(), {}).status();
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
  EXPECT_THAT(status.message(), HasSubstr("none.aabbs: no such file"));
}

TEST_F(RecordedFile, FileNamesAreUtf8) {
  const std::u8string name = u8"K\u00F6rper \u7BB1 \U0001F4E6.aabbs";
  const std::filesystem::path path = PathOf("") / std::filesystem::path(name);
  std::ofstream(path, std::ios::binary) << FileBytes().Header(1, 0).Boxes(1).str();
  const std::u8string text = path.u8string();
  const Result<std::unique_ptr<Scene>> scene = MakeScene(std::string(text.begin(), text.end()), {});
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_THAT((*scene)->aabbs(), ElementsAre(BoxAt(0)));
}

TEST_F(RecordedFile, ANameThatIsNotUtf8IsNotFound) {
  const Status status = MakeScene(PathOf("").string() + "\xFF\xC0.aabbs", {}).status();
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
}

TEST_F(RecordedFile, ADirectoryIsRefused) {
  std::filesystem::create_directory(PathOf("folder.aabbs"));
  const Status status = MakeScene(PathOf("folder.aabbs").string(), {}).status();
  EXPECT_EQ(status.code(), StatusCode::kDataLoss);
  EXPECT_THAT(status.message(), HasSubstr("not a regular file"));
}

TEST_F(RecordedFile, AShortHeaderIsRefused) {
  ExpectBroken("", "shorter than the 304 bytes");
  ExpectBroken(FileBytes().Header(1, 0).str().substr(0, 303), "shorter than the 304 bytes");
}

TEST_F(RecordedFile, TheSizeMustBeExact) {
  const std::string whole = FileBytes().Header(2, 2).Boxes(6).str();
  EXPECT_NE(Open(whole), nullptr);
  ExpectBroken(whole + '\0', "304 + (1 + 2) * 2 * 32");
  ExpectBroken(whole.substr(0, whole.size() - 1), "304 + (1 + 2) * 2 * 32");
  ExpectBroken(whole.substr(0, 304), "has 304 bytes");
  ExpectBroken(FileBytes().Header(2, 2).Boxes(8).str(), "has 560 bytes");
}

TEST_F(RecordedFile, CountsOutOfRangeAreRefused) {
  ExpectBroken(FileBytes().Header(0, 0).str(), "the object count is 0");
  ExpectBroken(FileBytes().Header(kTwoToThe31, 0).str(), "the object count is -2147483648");
  ExpectBroken(FileBytes().Header(-1, 0).str(), "the object count is -1");
  ExpectBroken(FileBytes().Header(1, -1).Boxes(1).str(), "the frame count is -1");
}

TEST_F(RecordedFile, AHeaderWithLargerCountsThanTheFileAllocatesNothing) {
  ExpectBroken(FileBytes().Header(kLargest, kLargest).Boxes(1).str(), "* 2147483647 * 32");
  ExpectBroken(FileBytes().Header(kLargest, 0).Boxes(1).str(), "* 2147483647 * 32");
  ExpectBroken(FileBytes().Header(kLargest, kLargest, 1).Boxes(1).str(), "2147483648 counts");
}

TEST_F(RecordedFile, TooManyObjectsAreRefusedEvenIfTheSizeFits) {
  const auto path = Write(FileBytes().Header(16'777'217, 0).str());
  std::filesystem::resize_file(path, 304 + 16'777'217ULL * 32);  // a sparse file
  const Status status = MakeScene(path.string(), {}).status();
  EXPECT_EQ(status.code(), StatusCode::kResourceExhausted);
  EXPECT_THAT(status.message(), HasSubstr("at most 16777216"));
}

TEST_F(RecordedFile, NamesMustBeTerminatedAndPrintable) {
  const std::string whole = FileBytes().Header(1, 0).Boxes(1).str();
  ExpectBroken(std::string(128, 'x') + whole.substr(128), "the scene name does not end");
  ExpectBroken(whole.substr(0, 128) + std::string(128, 'x') + whole.substr(256),
               "the object type does not end");
  ExpectBroken(WithByte(whole, 2, '\n'), "the scene name is not printable");
  ExpectBroken(WithByte(whole, 2, '\xFF'), "the scene name is not printable");
}

TEST_F(RecordedFile, UnknownLayoutsAndMissingNotesAreRefused) {
  ExpectBroken(FileBytes().Header(1, 0, 2).Boxes(1).str(), "layout flag at byte 264 is 2");
  const std::string whole = FileBytes().Header(1, 0).Boxes(1).str();
  ExpectBroken(WithByte(whole, 268, 33), "shorter than the 33 bytes of notes");
  ExpectBroken(WithByte(whole, 268, 1), "but its header requires");
  ExpectBroken(WithByte(whole, 271, -1), "size of the notes at byte 268");
  ExpectBroken(WithByte(whole, 271, 2), "size of the notes at byte 268");
}

TEST_F(RecordedFile, TheErrorNamesTheFrameOfACoordinateThatIsNotFinite) {
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float bad : {std::nanf(""), infinity, -infinity}) {
    for (int corner = 0; corner < 6; ++corner) {
      Aabb box = BoxAt(0);
      (corner < 3 ? box.min[corner] : box.max[corner - 3]) = bad;
      ExpectBroken(FileBytes().Header(2, 1).Boxes(3).Box(box).str(),
                   "frame 1, object 1 has a coordinate that is not finite");
    }
  }
}

TEST_F(RecordedFile, WorldBoundsMustBeFiniteAndOrdered) {
  const std::string head = FileBytes().Header(1, 0).str().substr(0, 272);
  const std::string not_finite = FileBytes().Box({{0, std::nanf(""), 0}, {1, 1, 1}}).str();
  const std::string inverted = FileBytes().Box({{0, 2, 0}, {1, 1, 1}}).str();
  const std::string box = FileBytes().Boxes(1).str();
  ExpectBroken(head + not_finite + box, "the world bounds are not finite");
  ExpectBroken(head + inverted + box, "the world bounds are inverted");
}

TEST_F(RecordedFile, TheCountTableMustMatchTheBoxesAndTheHeader) {
  ExpectBroken(FileBytes().Header(2, 1, 1).Int(2).str(), "2 counts of 4 bytes");
  ExpectBroken(FileBytes().Header(2, 1, 1).Boxes(3).Int(2).Int(2).str(), "304 + 4 * 32");
  ExpectBroken(FileBytes().Header(2, 1, 1).Boxes(3).Int(3).Int(0).str(), "frame 0 has 3 objects");
  ExpectBroken(FileBytes().Header(2, 1, 1).Boxes(1).Int(2).Int(-1).str(), "frame 1 has -1");
  ExpectBroken(FileBytes().Header(9, 1, 1).Boxes(3).Int(2).Int(1).str(), "no frame has the 9");
}

TEST_F(RecordedFile, TruncatingAFileDuringReplayKeepsTheBoxes) {
  const auto scene = Open(FileBytes().Header(1000, 99).Boxes(100'000).str());
  std::filesystem::resize_file(PathOf("scene.aabbs"), 0);
  StepTimes(*scene, 300);
  EXPECT_EQ(scene->frame_index(), 300U);
  ASSERT_EQ(scene->aabbs().size(), 1000U);
  for (const Aabb& box : scene->aabbs()) EXPECT_TRUE(IsValid(box));
}

// Flips up to three bytes, and sometimes truncates or extends the end.
std::string Mutated(std::string bytes, const CounterRandom& random, uint64_t round) {
  uint64_t draws = 0;
  const auto below = [&](uint64_t bound) { return random.Bits(round, draws++) % bound; };
  for (uint64_t flips = below(4); flips > 0; --flips) {
    // Half of the flips are in the numbers of the header, on which most checks depend.
    const size_t offset = below(2) == 0 ? 256 + below(48) : below(bytes.size());
    bytes[offset] = static_cast<char>(below(256));
  }
  if (below(4) == 0) bytes.resize(below(bytes.size() + 64));
  return bytes;
}

void ExpectFiniteForFrames(Scene& scene, int frame_count) {
  for (int frame = 0; frame < frame_count; ++frame) {
    for (const Aabb& box : scene.aabbs()) {
      for (const float x : box.min) ASSERT_TRUE(std::isfinite(x));
      for (const float x : box.max) ASSERT_TRUE(std::isfinite(x));
    }
    scene.Step();
  }
}

TEST_F(RecordedFile, CorruptFilesNeverCrashTheReader) {
  const std::string originals[] = {
      FileBytes().Header(2, 2).Boxes(6).str(),
      FileBytes().Header(3, 3, 1).Boxes(6).Int(1).Int(3).Int(0).Int(2).str()};
  const CounterRandom random(20240607, SceneDraw::kKick);
  int legal = 0;
  for (uint64_t round = 0; round < 4000; ++round) {
    const std::string bytes = Mutated(originals[round % 2], random, round);
    const Result<std::unique_ptr<Scene>> scene = MakeScene(Write(bytes).string(), {});
    if (scene.ok()) {
      ++legal;
      ExpectFiniteForFrames(**scene, 5);
    } else {
      EXPECT_EQ(scene.status().code(), StatusCode::kDataLoss) << scene.status().message();
      EXPECT_THAT(scene.status().message(), Not(HasSubstr("\n")));
    }
  }
  EXPECT_GT(legal, 400);
  EXPECT_LT(legal, 3600);
}

}  // namespace
}  // namespace sweepstake
