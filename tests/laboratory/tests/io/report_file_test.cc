// Tests the report file: the page with the documents in it.
#include "tests/laboratory/io/report_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/laboratory/report/report_page.h"
#include "tests/support/file_text.h"
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

TEST(WriteReport, WritesThePageOrFailsWithTheReason) {
  const test_support::TemporaryDirectory folder;
  const std::string path = (folder.path() / "report.html").string();
  std::ostringstream out, err;
  Terminal terminal{.out = out, .err = err};
  const Status status = WriteReport(path, std::array<std::string, 1>{"{\"rows\":[]}"}, terminal);
  EXPECT_EQ(status.code(), ReportPageStatus().code());
  if (!status.ok()) return;
  EXPECT_THAT(err.str(), HasSubstr(path));
  EXPECT_THAT(test_support::FileText(path), HasSubstr("[{\"rows\":[]}]"));
  EXPECT_FALSE(WriteReport("/nonexistent/x.html", {}, terminal).ok());
}

}  // namespace
}  // namespace sweepstake::cli
