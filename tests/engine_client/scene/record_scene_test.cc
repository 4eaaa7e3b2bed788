#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tests/engine_client/scene/file_fixtures.h"
#include "tests/engine_client/scene/scene_fixtures.h"

#if defined(__linux__)
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#endif

namespace sweepstake {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Recording : public FileTest {};

TEST_F(Recording, ReadingARecordingGivesTheSameBoxesBitForBit) {
  const auto path = PathOf("scene.aabbs");
  for (const std::string_view name : SceneNames(SceneGroup::kReference)) {
    const std::unique_ptr<Scene> recorded = MustMakeScene(name, WithCount(70));
    ASSERT_TRUE(RecordScene(*recorded, 50, path.string()).ok());
    EXPECT_EQ(recorded->frame_index(), 50U);
    const std::unique_ptr<Scene> replayed = MustMakeScene(path.string(), {});
    EXPECT_EQ(replayed->name(), name);
    EXPECT_EQ(replayed->world(), recorded->world());
    EXPECT_EQ(HashOfFrames(*replayed, 50), HashOfFrames(*MustMakeScene(name, WithCount(70)), 50));
  }
}

TEST_F(Recording, WritesBroadmarksLayoutByteForByte) {
  ScriptedScene scene({{BoxAt(0), BoxAt(1)}, {BoxAt(2), BoxAt(3)}});
  ASSERT_TRUE(RecordScene(scene, 1, PathOf("scene.aabbs").string()).ok());
  const FileBytes expected = FileBytes()
                                 .Text("scripted", 128)
                                 .Text("AABB", 128)
                                 .Int(2)
                                 .Int(1)
                                 .Int(0)
                                 .Int(0)
                                 .Box(scene.world())
                                 .Boxes(4);
  EXPECT_EQ(Read(PathOf("scene.aabbs")), expected.str());
}

TEST_F(Recording, NotesFollowTheBoxesAndAreReadBackUnchanged) {
  const std::string notes = "a line\nand \xFF, any bytes";
  for (const auto& frames : {std::vector<std::vector<Aabb>>{{BoxAt(0)}, {BoxAt(1)}},
                             std::vector<std::vector<Aabb>>{{BoxAt(0)}, {BoxAt(1), BoxAt(2)}}}) {
    ScriptedScene scene(frames);
    const std::string path = PathOf("scene.aabbs").string();
    ASSERT_TRUE(RecordScene(scene, 1, path, notes).ok());
    EXPECT_TRUE(Read(path).ends_with(notes));
    EXPECT_EQ(*RecordedNotes(path), notes);
    std::unique_ptr<Scene> replayed = MustMakeScene(path, {});
    replayed->Step();
    EXPECT_EQ(replayed->aabbs().size(), frames[1].size());
    replayed->Step();
    EXPECT_EQ(replayed->aabbs()[0], BoxAt(0));
    replayed.reset();  // Windows cannot replace an open file.
    ASSERT_TRUE(RecordScene(scene, 0, path).ok());
    EXPECT_EQ(*RecordedNotes(path), "");
  }
}

TEST_F(Recording, NotesHaveAMaximumSizeAndNeedARecording) {
  ScriptedScene scene({{BoxAt(0)}});
  const std::string path = PathOf("scene.aabbs").string();
  const Status status = RecordScene(scene, 0, path, std::string((16 << 20) + 1, 'x'));
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("at most 16777216 bytes"));
  EXPECT_EQ(FileCount(), 0U);
  EXPECT_EQ(RecordedNotes(path).status().code(), StatusCode::kNotFound);
}

TEST_F(Recording, ChangingCountsUseTheExtensionAndAreReadBackUnchanged) {
  ScriptedScene scene({{}, {BoxAt(0)}, {BoxAt(1), BoxAt(2)}, {BoxAt(3)}});
  const auto path = PathOf("scene.aabbs");
  ASSERT_TRUE(RecordScene(scene, 3, path.string()).ok());
  const std::string bytes = Read(path);
  EXPECT_EQ(bytes.size(), 304U + 4 * 32 + 4 * 4);
  EXPECT_EQ(bytes.substr(304), FileBytes().Boxes(4).Int(0).Int(1).Int(2).Int(1).str());
  const std::unique_ptr<Scene> replayed = MustMakeScene(path.string(), {});
  EXPECT_TRUE(replayed->aabbs().empty());
  replayed->Step();
  EXPECT_THAT(replayed->aabbs(), ElementsAre(BoxAt(0)));
  replayed->Step();
  EXPECT_THAT(replayed->aabbs(), ElementsAre(BoxAt(1), BoxAt(2)));
}

TEST_F(Recording, ZeroStepsRecordTheFirstFrame) {
  ScriptedScene scene({{BoxAt(0)}});
  ASSERT_TRUE(RecordScene(scene, 0, PathOf("scene.aabbs").string()).ok());
  EXPECT_EQ(Read(PathOf("scene.aabbs")).size(), 304U + 32);
}

TEST_F(Recording, LongAndUnprintableNamesAreMadeValid) {
  ScriptedScene scene({{BoxAt(0)}});
  scene.set_name("line\nbreak" + std::string(300, 'x'));
  ASSERT_TRUE(RecordScene(scene, 0, PathOf("scene.aabbs").string()).ok());
  const auto replayed = MustMakeScene(PathOf("scene.aabbs").string(), {});
  EXPECT_EQ(replayed->name(), "line?break" + std::string(117, 'x'));
}

TEST_F(Recording, ASceneWithoutObjectsCannotBeRecorded) {
  ScriptedScene scene(std::vector<std::vector<Aabb>>(1));
  const Status status = RecordScene(scene, 3, PathOf("scene.aabbs").string());
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("the scene has 0"));
  EXPECT_EQ(FileCount(), 0U);
}

TEST_F(Recording, AnInvalidCoordinateKeepsOnlyTheOldFile) {
  const auto path = Write("old");
  Aabb bad = BoxAt(0);
  bad.max[1] = std::nanf("");
  ScriptedScene scene({{BoxAt(0), BoxAt(1)}, {BoxAt(2), bad}});
  const Status status = RecordScene(scene, 5, path.string());
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("frame 1, object 1"));
  EXPECT_EQ(Read(path), "old");
  EXPECT_EQ(FileCount(), 1U);
}

TEST_F(Recording, TheErrorNamesAMissingDirectory) {
  ScriptedScene scene({{BoxAt(0)}});
  const Status status = RecordScene(scene, 1, (PathOf("none") / "scene.aabbs").string());
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
  EXPECT_THAT(status.message(), HasSubstr("none is not a directory: create it first"));
}

TEST_F(Recording, ADirectoryOrAnInvalidNameIsRefused) {
  ScriptedScene scene({{BoxAt(0)}});
  std::filesystem::create_directory(PathOf("folder.aabbs"));
  EXPECT_EQ(RecordScene(scene, 1, PathOf("folder.aabbs").string()).code(),
            StatusCode::kUnavailable);
  EXPECT_EQ(RecordScene(scene, 1, "").code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(RecordScene(scene, 1, "\xff.aabbs").message(), HasSubstr("'?.aabbs' is not UTF-8"));
  EXPECT_EQ(FileCount(), 1U);
}

#if defined(__linux__)
TEST_F(Recording, APipeOrADeviceIsNotReplacedByAFile) {
  ScriptedScene scene({{BoxAt(0)}});
  ASSERT_EQ(mkfifo(PathOf("pipe").c_str(), 0600), 0);
  const Status status = RecordScene(scene, 1, PathOf("pipe").string());
  EXPECT_THAT(status.message(), HasSubstr("it is not a file"));
  EXPECT_TRUE(std::filesystem::is_fifo(PathOf("pipe")));
}
#endif

TEST_F(Recording, MoreFramesThanTheHeaderAllowsAreRefusedAtOnce) {
  ScriptedScene scene({{BoxAt(0)}});
  const Status status = RecordScene(scene, uint64_t{1} << 31U, PathOf("scene.aabbs").string());
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(scene.frame_index(), 0U);
  EXPECT_EQ(FileCount(), 0U);
}

TEST_F(Recording, AFileCanBeReplacedWhileItIsReplayed) {
  const auto path = PathOf("scene.aabbs");
  ASSERT_TRUE(RecordScene(*MustMakeScene("suite-b", WithCount(20)), 9, path.string()).ok());
  const std::string once = Read(path);
  const Status again = RecordScene(*MustMakeScene(path.string(), {}), 9, path.string());
#if defined(_WIN32)
  // On Windows an open file cannot be replaced.
  EXPECT_EQ(again.code(), StatusCode::kUnavailable);
  EXPECT_EQ(FileCount(), 1U);
#else
  EXPECT_TRUE(again.ok()) << again.message();
#endif
  EXPECT_EQ(Read(path), once);
}

#if defined(__linux__)

// Simulates a full disk by a limit on the size of files.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }

  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, old_handler_);
  }

  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*old_handler_)(int) = nullptr;
};

TEST_F(Recording, AFullDiskKeepsOnlyTheOldFile) {
  const auto path = Write("old");
  const std::unique_ptr<Scene> scene = MustMakeScene("brownian", WithCount(1000));
  const Status status = [&] {
    const FileSizeLimit limit(300'000);
    return RecordScene(*scene, 100, path.string());
  }();
  EXPECT_EQ(status.code(), StatusCode::kUnavailable);
  EXPECT_THAT(status.message(), HasSubstr("cannot be written: File too large"));
  EXPECT_EQ(Read(path), "old");
  EXPECT_EQ(FileCount(), 1U);
}

TEST_F(Recording, AWriteErrorInTheLastBytesIsReported) {
  ScriptedScene scene({{BoxAt(0)}});
  const Status status = [&] {
    const FileSizeLimit limit(100);
    return RecordScene(scene, 0, PathOf("scene.aabbs").string());
  }();
  EXPECT_EQ(status.code(), StatusCode::kUnavailable);
  EXPECT_EQ(FileCount(), 0U);
}

#endif

}  // namespace
}  // namespace sweepstake
