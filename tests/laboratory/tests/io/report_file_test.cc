// Reports: a page with documents in it.
#include "tests/laboratory/io/report_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/laboratory/report/report_page.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr std::string_view kPage = "<script>SWEEPSTAKE_DOCUMENTS</script>";

TEST(FillReportPage, PutsTheDocumentsInPlaceOfTheMarker) {
  EXPECT_EQ(FillReportPage(kPage, std::array<std::string, 2>{"{\"a\":1}", "2"}),
            "<script>[{\"a\":1},2]</script>");
  EXPECT_EQ(FillReportPage(kPage, {}), "<script>[]</script>");
}

TEST(FillReportPage, NoTextOfADocumentEndsTheScript) {
  const nlohmann::json document = {{"cpu", "</script><!-- <b>"}};
  const std::string page = FillReportPage(kPage, std::array{document.dump()});
  const std::string json = page.substr(8, page.size() - 17);
  EXPECT_THAT(json, Not(HasSubstr("<")));
  EXPECT_EQ(nlohmann::json::parse(json)[0], document);
}

TEST(ReportPage, IsThereOrSaysWhatIsMissing) {
  if (ReportPage().empty()) {
    EXPECT_THAT(std::string(ReportPageProblem()), HasSubstr("built without the page"));
  } else {
    EXPECT_EQ(ReportPageProblem(), "");
    EXPECT_EQ(ReportPage().find("SWEEPSTAKE_DOCUMENTS"),
              ReportPage().rfind("SWEEPSTAKE_DOCUMENTS"));
    EXPECT_THAT(std::string(ReportPage()), HasSubstr("Content-Security-Policy"));
  }
}

TEST(ReportFile, AppearsWholeOrNotAtAll) {
  const test_support::TemporaryDirectory folder;
  const std::filesystem::path path = folder.path() / "report.html";
  {
    const auto dropped = ReportFile::Create(path.string());
    if (ReportPage().empty()) {
      EXPECT_EQ(dropped.status().code(), StatusCode::kUnavailable);
      return;
    }
    ASSERT_TRUE(dropped.ok());
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  const auto file = ReportFile::Create(path.string());
  std::ostringstream out, err;
  Terminal terminal{.out = out, .err = err};
  ASSERT_TRUE((*file)->Commit(std::array<std::string, 1>{"{\"rows\":[]}"}, terminal).ok());
  EXPECT_THAT(err.str(), HasSubstr(path.string()));
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("[{\"rows\":[]}]"));
}

}  // namespace
}  // namespace sweepstake::cli
